// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "models/trajectory/linearise.h"

namespace octant::calib {

/// By how much a row (its observation, whitened) grows with the size of each of some errors that the
/// observations may have in common; false: with none of them.
using ErrorPatterns = std::function<bool(const Trajectory&, const ObservationRow&, Eigen::RowVectorXd& by)>;

/// What the residuals of an adjustment say of errors that were not in it.
struct ScoreTest {
  Eigen::VectorXd gradient, information;  ///< an element for each error

  [[nodiscard]] double size(Eigen::Index error) const;    ///< that explains the residuals best
  [[nodiscard]] double sigmas(Eigen::Index error) const;  ///< of it, in its own standard deviations
};

/// Score test (Rao 1948; for errors of known pattern the w-test of Baarda 1968) of each error by itself, all
/// states adjusted along with it, the shared parameters held: these are at their optimum without it, so that
/// its significance comes out at most too small, and so may its size. Takes one sweep over the states and
/// adjusts nothing.
/// @param trajectories  adjusted
/// @param errors        how many; columns of what `patterns` fills
[[nodiscard]] ScoreTest score_test(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                   Eigen::Index errors, const ErrorPatterns& patterns, int threads = 1);

}  // namespace octant::calib
