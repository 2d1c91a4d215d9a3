// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "models/change.h"
#include "models/changes/innovation.h"

namespace octant {

/// Owner of a change that is common to all beacons.
inline constexpr std::size_t kAllBeacons = static_cast<std::size_t>(-1);

/// A change that may have happened on its own.
struct ChangeHypothesis {
  ChangeKind kind = ChangeKind::kBeaconMoved;
  std::size_t owner =
      0;  ///< index of the beacon or receiver; for a delay kAllBeacons: the same change of all beacons
  std::vector<int> columns;   ///< columns of the innovation's B: parameters that may change
  std::vector<double> sigma;  ///< prior standard deviations of their changes
};
/// Hypotheses for the position, delay and (with an attenuation) gain of each beacon, the position of each
/// receiver, and the speed.
[[nodiscard]] std::vector<ChangeHypothesis> change_hypotheses(const KnownParameters& known);

/// Result of the test of one hypothesis.
struct TestedChange {
  std::size_t hypothesis = 0;
  bool held = false;  ///< true if it is accepted as a change
  double drop = 0.0;  ///< decrease of chi-square
  int degrees_of_freedom = 0;
  double p = 1.0;            ///< probability of this decrease by chance, corrected for the number of tests
  Eigen::VectorXd estimate;  ///< new minus old values of its columns
  Eigen::MatrixXd covariance;
};

struct ChangeSearch {
  std::vector<TestedChange> tested;  ///< one for each hypothesis
  double chi2 = 0.0,
         chi2_left = 0.0;      ///< chi-square of the innovation, before and after the accepted changes
  int degrees_of_freedom = 0;  ///< degrees of freedom of chi2
  [[nodiscard]] std::vector<std::size_t> held() const;
};

/// Probability that a change is reported for a visit at which there was no change.
inline constexpr double kFalseAlarm = 0.01;

/// Finds the set of changes that explains the innovation best: congruence test on a free network with
/// localisation (Caspary 1987). The prior of a change is added to its information, so that directions which
/// the visit does not determine cost no degree of freedom and stay near zero. Each change costs the decrease
/// of chi-square that is exceeded by chance with a probability of kFalseAlarm over the number of hypotheses
/// (Bonferroni). Starting without changes, single changes are added, removed and replaced while the sum of
/// squares and costs decreases. A change that was accepted for lack of a better one can therefore be removed
/// later. The remaining changes are tested one by one.
/// @param also_from  hypotheses for a second start; the better result is used. If most beacons moved, those
/// that stayed look like moved ones, and single steps from an empty set end there.
[[nodiscard]] ChangeSearch search_changes(const Innovation& innovation,
                                          const std::vector<ChangeHypothesis>& hypotheses,
                                          const std::vector<std::size_t>& also_from = {});

}  // namespace octant
