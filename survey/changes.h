// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"

namespace octant::survey {

/// How a beacon of one deployment differs from its namesake in an earlier one.
struct BeaconChange {
  std::string name;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< new less old
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< of the shift: both deployments' variances together
  std::optional<double> p;  ///< of a shift this large by chance; none where both are held fixed
  double delay_change_s = 0.0, delay_sigma_s = 0.0;
  std::optional<double>
      delay_p;               ///< of such a change of the delay by chance; none where it is no beacon's own
  bool significant = false;  ///< it moved: p below the limit
  bool delay_significant = false;  ///< its delay is another one
  /// Its shift may be that of the frame: a control point does not fit its stated position any more. Then
  /// nothing is said of it.
  bool by_datum = false;

  [[nodiscard]] bool moved() const { return significant && !by_datum; }
  [[nodiscard]] bool changed() const { return moved() || delay_significant; }
};
/// A place or a delay is called changed where chance makes such a difference less often than this; with more
/// than kChangesByChance / kSignificance of them that are compared, less often in proportion (Bonferroni), so
/// that of a hundred comparisons of unchanged sites one accuses somebody.
inline constexpr double kSignificance = 1.0e-3, kChangesByChance = 0.01;

struct Changes {
  std::string since;                  ///< when the earlier one was made
  bool same_datum = true;             ///< otherwise shifts are in part those of the frame
  std::vector<BeaconChange> beacons;  ///< of both
  std::vector<std::string> gone, added;
  double limit_p = kSignificance;  ///< as used
  std::vector<std::string>
      doubted_control_points;  ///< held where they were stated, and their delays changed beyond chance
  std::optional<double> speed_change_mps;  ///< at the new one's reference temperature
  double speed_sigma_mps = 0.0;
};

/// The deployments are taken as independent: sigmas of shifts are too large where they share control points.
[[nodiscard]] Changes changes_between(const Deployment& before, const Deployment& now);

/// How many beacons moved and how many delays changed, in a sentence.
[[nodiscard]] std::string changes_sentence(const Changes& changes);

/// Probability that chi-square with this many degrees of freedom (1 to 3) exceeds a value, in closed form.
[[nodiscard]] double chi_square_tail(double value, int degrees_of_freedom);

}  // namespace octant::survey
