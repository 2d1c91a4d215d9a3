// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/changes/comparison.h"
#include "models/deployment.h"

namespace octant::survey {

/// How a beacon of one deployment differs from its namesake in an earlier one.
struct BeaconChange {
  std::string name;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< new less old
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< of the shift: both deployments' variances together
  std::optional<double> p;  ///< of a shift this large by chance, on its own; none where both are held fixed
  double delay_change_s = 0.0, delay_sigma_s = 0.0;
  std::optional<double>
      delay_p;               ///< of such a change of the delay by chance; none where it is no beacon's own
  bool significant = false;  ///< held to have moved, or to be exchanged
  bool delay_significant = false;  ///< its delay is held to be another one
  /// Its shift may be that of the frame: a control point does not fit its stated position any more. Then
  /// nothing is said of it.
  bool by_datum = false;

  [[nodiscard]] bool moved() const { return significant && !by_datum; }
  [[nodiscard]] bool changed() const { return moved() || delay_significant; }
};
struct Changes {
  std::string since;                  ///< when the earlier one was made
  bool same_datum = true;             ///< otherwise shifts are in part those of the frame
  std::vector<BeaconChange> beacons;  ///< of both
  std::vector<std::string> gone, added;
  std::vector<Change> found;     ///< what is held to be changed: beacons, delays, receivers, speed, datum
  double limit_p = kFalseAlarm;  ///< of each test
  std::vector<std::string>
      doubted_control_points;  ///< held where they were stated, and their delays changed beyond chance
  std::optional<double> speed_change_mps;  ///< at the new one's reference temperature
  double speed_sigma_mps = 0.0;
  std::vector<std::string> silent;  ///< beacons and receivers of which a visit should have heard, and did not
};

/// What is held to be changed is told by all that both know together, free of the datum and with the drift
/// that time allows (models/changes/comparison.h); the single shifts and their p stand beside it.
[[nodiscard]] Changes changes_between(const Deployment& before, const Deployment& now, const Drift& drift);
/// With the drift of the time between them.
[[nodiscard]] Changes changes_between(const Deployment& before, const Deployment& now);

/// How many beacons moved and how many delays changed, in a sentence.
[[nodiscard]] std::string changes_sentence(const Changes& changes);

}  // namespace octant::survey
