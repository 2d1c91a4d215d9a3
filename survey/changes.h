// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/changes/comparison.h"
#include "models/changes/reception.h"
#include "models/deployment.h"

namespace octant::survey {

/// Difference between a beacon of one deployment and the beacon of the same name in an earlier one.
struct BeaconChange {
  std::string name;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< new less old
  Eigen::Vector3d sigma_m =
      Eigen::Vector3d::Zero();  ///< sigma of the shift, from the variances of both deployments
  std::optional<double> p;  ///< probability of a shift this large by chance, as a single test; no value if
                            ///< the beacon is fixed in both
  double delay_change_s = 0.0, delay_sigma_s = 0.0;
  std::optional<double> delay_p;   ///< probability of such a change of the delay by chance; no value if the
                                   ///< beacon has no delay of its own
  bool significant = false;        ///< the beacon moved or was exchanged
  bool delay_significant = false;  ///< its delay changed
  /// The shift may be one of the frame, because a control point no longer fits its stated position. Then it
  /// is not reported.
  bool by_datum = false;

  [[nodiscard]] bool moved() const { return significant && !by_datum; }
  [[nodiscard]] bool changed() const { return moved() || delay_significant; }
};
struct Changes {
  std::string since;                  ///< when the earlier one was made
  bool same_datum = true;             ///< otherwise shifts are in part those of the frame
  std::vector<BeaconChange> beacons;  ///< beacons of both deployments
  std::vector<std::string> gone, added;
  std::vector<Change> found;     ///< changes: beacons, delays, receivers, speed, datum
  double limit_p = kFalseAlarm;  ///< significance level of each test
  std::vector<std::string>
      doubted_control_points;  ///< fixed at their stated positions, but their delays changed significantly
  std::optional<double> speed_change_mps;  ///< at the new one's reference temperature
  double speed_sigma_mps = 0.0;
  std::vector<Silence> silent;            ///< beacons and receivers received far less than expected
  std::vector<std::string> not_observed;  ///< beacons out of reach during the second visit
};

/// Compares two deployments. Changes are tested jointly, independent of the datum and with the drift that the
/// time between the visits allows (models/changes/comparison.h). The single shifts and their p-values are
/// given as well.
[[nodiscard]] Changes changes_between(const Deployment& before, const Deployment& now, const Drift& drift);
/// With the drift of the time between them.
[[nodiscard]] Changes changes_between(const Deployment& before, const Deployment& now);

/// "412 arrivals were expected from 301 s on, and 0 received".
[[nodiscard]] std::string reception_words(const Silence& silence);
/// Number of moved beacons and of changed delays, in a sentence.
[[nodiscard]] std::string changes_sentence(const Changes& changes);

}  // namespace octant::survey
