// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/covariance.h"
#include "calib/problem/parameters.h"
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

/// Shared parameters as an adjustment left them.
struct AdjustedParameters {
  const ParameterLayout& layout;
  const Covariance& covariance;  ///< by the noise that the rows have
};

/// Score test (Rao 1948; for errors of known pattern the w-test of Baarda 1968) of each error c by itself,
/// states and shared parameters adjusted along with it. With J of the states' and the parameters' own rows,
/// each less what the states take up,
///   gradient = c'r,   information = c'c - (J'c)' C (J'c)
/// takes one sweep over the states and adjusts nothing. What parameters take up but for a fiftieth has no
/// information: they may be bent by what is no error at all.
/// @param trajectories  adjusted, or a part of those from which the parameters are
/// @param errors        how many; columns of what `patterns` fills
[[nodiscard]] ScoreTest score_test(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                   const AdjustedParameters& parameters, Eigen::Index errors,
                                   const ErrorPatterns& patterns, int threads = 1);

}  // namespace octant::calib
