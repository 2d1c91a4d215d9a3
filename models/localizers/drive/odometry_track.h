// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "models/physics/pose.h"
#include "models/run.h"

namespace octant {

/// A planar pose that odometry propagates, with its covariance (x, y in the map, heading).
struct OdometryState {
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  [[nodiscard]] Pose pose() const { return Pose::planar(p_map_m.x(), p_map_m.y(), heading_rad); }
};

/// Deviation of a from b: x, y, heading.
[[nodiscard]] inline Eigen::Vector3d difference(const OdometryState& a, const OdometryState& b) {
  return {a.p_map_m.x() - b.p_map_m.x(), a.p_map_m.y() - b.p_map_m.y(),
          wrap_angle(a.heading_rad - b.heading_rad)};
}

/// Propagates by a fraction (0 to 1) of an odometry row; the variance of `OdometryAccuracy` is applied in
/// proportion.
/// @return derivative of the new state by the previous one
Eigen::Matrix3d advance(OdometryState& state, const OdometryStep& step, const OdometryAccuracy& accuracy,
                        double fraction = 1.0);

/// Odometry rows of a vehicle, consumed in order of time.
class OdometryCursor {
 public:
  OdometryCursor(std::span<const OdometryStep> steps, double from_s) : steps_(steps), now_s_(from_s) {
    while (next_ < steps_.size() && steps_[next_].time_s <= now_s_) ++next_;
  }
  /// Calls move(step, fraction) for every row, or part of a row, up to a time.
  template <class Move>
  void advance_to(double time_s, Move&& move) {
    while (next_ < steps_.size() && now_s_ < time_s) {
      const double start_s = next_ > 0 ? steps_[next_ - 1].time_s : now_s_,
                   span_s = steps_[next_].time_s - start_s;
      const double until_s = std::min(time_s, steps_[next_].time_s);
      // The first row is the anchor and describes no motion.
      if (next_ > 0 && span_s > 0) move(steps_[next_], (until_s - now_s_) / span_s);
      now_s_ = until_s;
      if (now_s_ >= steps_[next_].time_s) ++next_;
    }
  }

 private:
  std::span<const OdometryStep> steps_;
  double now_s_;
  std::size_t next_ = 0;
};

}  // namespace octant
