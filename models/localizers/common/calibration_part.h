// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Contribution of the calibration to the uncertainty of a fix, which does not average out. With the joint
/// covariance C of the calibrated parameters, the information D of the state and the coupling G between both,
///   P = D^-1 + D^-1 G C G' D^-1
/// See chain_calibration.h for the states of a drive and drive_filter.h for a filter.
class CalibrationPart {
 public:
  explicit CalibrationPart(const Deployment& deployment);

  /// Adds the second term to the covariance of a fix, for the state in the segment. Has no effect without
  /// calibration uncertainty.
  void add_to(PoseCovariance& covariance, const Trajectory& trajectory, const Segment& segment,
              const SharedState& state) const;

  /// Joint covariance C; empty if the deployment has none.
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }

  /// Calls visit(column of C, derivative) for every calibrated parameter that an observation depends on.
  template <class Visitor>
  void for_each_coupling(const ObservationRow& row, Visitor&& visit) const {
    if (!row.has_shared) return;
    const auto couple = [&visit](int at, double derivative) {
      if (at >= 0 && derivative != 0.0) visit(at, derivative);
    };
    const auto& beacon = beacon_[row.beacon.index()];
    for (std::size_t i = 0; i < 3; ++i) couple(beacon[i], row.by_beacon[static_cast<int>(i)]);
    if (!row.receiver.valid()) return;
    const auto& receiver = receiver_[row.receiver.index()];
    for (std::size_t i = 0; i < 3; ++i) couple(receiver[i], row.by_receiver[static_cast<int>(i)]);
    for (std::size_t i = 0; i < attenuation_.size(); ++i)
      couple(attenuation_[i], row.by_attenuation[static_cast<int>(i)]);
    couple(beacon[3], row.by(kByDelay));
    couple(receiver[3], row.by(kByDelay));
    couple(site_delay_, row.by(kByDelay));
    couple(speed_, row.by(kBySpeed));
  }

  /// Calls visit(column of C) for every calibrated parameter that arrivals of a beacon at a receiver may
  /// depend on, or bearings of a beacon (invalid receiver).
  template <class Visitor>
  void for_each_parameter(BeaconId beacon, ReceiverId receiver, Visitor&& visit) const {
    const auto stated = [&visit](std::span<const int> columns) {
      for (const int at : columns)
        if (at >= 0) visit(at);
    };
    stated(beacon_[beacon.index()]);
    if (!receiver.valid()) return;
    stated(receiver_[receiver.index()]);
    stated(attenuation_);
    stated(std::array{site_delay_, speed_});
  }

 private:
  Eigen::MatrixXd covariance_;
  std::vector<std::array<int, 4>> beacon_,
      receiver_;  ///< columns of x, y, z and delay in the joint covariance; -1: fixed parameter
  int site_delay_ = -1, speed_ = -1;
  std::array<int, kAttenuationUnknowns> attenuation_ = {-1, -1, -1, -1};
};

}  // namespace octant
