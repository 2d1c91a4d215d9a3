// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Directions in which the receivers of a vehicle face: outwards from the middle of their array. The delay of
/// an antenna or a transducer depends on the direction of arrival. Its first harmonic, A cos(angle to the
/// outward direction), is the same for all receivers and looks like an array of another size.
class ReceiverPattern {
 public:
  ReceiverPattern(const Trajectory& t, const SharedState& state) : trajectory_(&t), state_(state) {
    std::vector<bool> is_seen(state.receiver_p_vehicle_m.size(), false);
    for (const ArrivalObservation& a : t.arrivals) is_seen[a.receiver.index()] = true;
    double count = 0.0;
    for (std::size_t r = 0; r < is_seen.size(); ++r)
      if (is_seen[r]) middle_m_ += state.receiver_p_vehicle_m[r], count += 1.0;
    middle_m_ /= std::max(count, 1.0);
    for (std::size_t r = 0; r < is_seen.size(); ++r)
      if (is_seen[r]) least_lever_m_ = std::min(least_lever_m_, lever_m(r).norm());
  }
  [[nodiscard]] const Trajectory* trajectory() const { return trajectory_; }

  /// Distance of the innermost receiver from the middle of the array. Zero for a single receiver.
  [[nodiscard]] double least_lever_m() const { return std::isfinite(least_lever_m_) ? least_lever_m_ : 0.0; }

  /// Cosine of the angle between the direction to the beacon and the direction in which the receiver faces.
  [[nodiscard]] double cosine(const ArrivalObservation& a) const {
    constexpr double kSmallest_m = 1e-3;
    if (least_lever_m() < kSmallest_m) return 0.0;
    const Pose& pose = trajectory_->nodes[a.node].T_map_vehicle;
    const Eigen::Vector3d to_beacon_m = state_.beacon_p_map_m[a.beacon.index()] -
                                        pose * state_.receiver_p_vehicle_m[a.receiver.index()],
                          outwards = pose.rotation * lever_m(a.receiver.index()).normalized();
    return outwards.dot(to_beacon_m) / std::max(to_beacon_m.norm(), kSmallest_m);
  }

  /// Effect of an amplitude of one metre on the time of flight of an arrival [s].
  [[nodiscard]] double delay_s(const ArrivalObservation& a) const {
    return a.legs() * cosine(a) / trajectory_->nominal_speed_mps;
  }

 private:
  [[nodiscard]] Eigen::Vector3d lever_m(std::size_t receiver) const {
    Eigen::Vector3d lever = state_.receiver_p_vehicle_m[receiver] - middle_m_;
    lever.z() = 0.0;
    return lever;
  }

  const Trajectory* trajectory_;
  const SharedState& state_;
  Eigen::Vector3d middle_m_ = Eigen::Vector3d::Zero();
  double least_lever_m_ = std::numeric_limits<double>::infinity();
};

}  // namespace octant::calib
