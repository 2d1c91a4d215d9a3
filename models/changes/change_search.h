// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "models/change.h"
#include "models/changes/innovation.h"

namespace octant {

/// Owner of what all beacons share.
inline constexpr std::size_t kAllBeacons = static_cast<std::size_t>(-1);

/// Something that may have changed on its own.
struct ChangeHypothesis {
  ChangeKind kind = ChangeKind::kBeaconMoved;
  std::size_t owner = 0;      ///< beacon or receiver; of a delay kAllBeacons: the same change of all
  std::vector<int> columns;   ///< of the innovation's B: parameters that are free to change then
  std::vector<double> sigma;  ///< prior standard deviations of their changes
};
/// Each beacon's place, delay and (with an attenuation) gain, each receiver's place, the speed.
[[nodiscard]] std::vector<ChangeHypothesis> change_hypotheses(const KnownParameters& known);

/// A hypothesis beside those that are held.
struct TestedChange {
  std::size_t hypothesis = 0;
  bool held = false;  ///< for changed
  double drop = 0.0;  ///< of chi-square by it
  int degrees_of_freedom = 0;
  double p = 1.0;            ///< of such a drop by chance, after all tests
  Eigen::VectorXd estimate;  ///< new less old, of its columns
  Eigen::MatrixXd covariance;
};

struct ChangeSearch {
  std::vector<TestedChange> tested;    ///< one for each hypothesis
  double chi2 = 0.0, chi2_left = 0.0;  ///< of the innovation, and of what the changes held leave of it
  int degrees_of_freedom = 0;          ///< of chi2
  [[nodiscard]] std::vector<std::size_t> held() const;
};

/// Probability that a visit at which nothing changed is said to have changed something.
inline constexpr double kFalseAlarm = 0.01;

/// The set of changes that explains the innovation best: the congruence test on a free network with
/// localisation (Caspary 1987). The prior of a change is added to the information on it, so that directions
/// which the visit does not determine cost no freedom and stay near zero. Each change comes at the price of
/// the drop in chi-square that chance exceeds with a probability of kFalseAlarm over the number of hypotheses
/// (Bonferroni). From none, changes are added, dropped and replaced by others for as long as squares and
/// prices together fall, so that a change that was held only for want of a better one is given up again. What
/// is left is tested one by one.
/// @param also_from  hypotheses to begin with as well; the better end counts. Where most beacons moved, those
/// that stayed look like the ones that moved, and single steps from none end there.
[[nodiscard]] ChangeSearch search_changes(const Innovation& innovation,
                                          const std::vector<ChangeHypothesis>& hypotheses,
                                          const std::vector<std::size_t>& also_from = {});

}  // namespace octant
