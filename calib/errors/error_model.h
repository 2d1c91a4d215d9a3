// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/covariance.h"
#include "calib/errors/error_part.h"
#include "calib/problem/parameters.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Error model estimated from residuals that are not white.
struct ErrorModel {
  bool correlated =
      false;  ///< white noise does not explain the residuals; otherwise the other members are empty
  double white_tof = 1.0;  ///< variance of the part that is white, in units of the adjustment's noise
  double white_bearing = 1.0;
  std::vector<ErrorPart> parts;  ///< components with a variance
  double freedoms =
      INFINITY;  ///< median degrees of freedom of the parameters' variances, a measure of their accuracy
  /// Variance of the size of the sample's pattern, estimated by least squares, relative to white noise.
  double pattern_variance = 1.0;
  Eigen::MatrixXd
      covariance;  ///< covariance of the shared parameters with these errors, internal units; may be empty

  /// Standard deviation of the part of a time of flight that is constant for a while, in units of the
  /// adjustment's noise.
  [[nodiscard]] double correlated_sigma() const { return sigma_of(false); }
  /// Duration of the correlation [s]; for positions, directions and ranges the time for which a vehicle of
  /// that speed stays in a cell.
  [[nodiscard]] double correlation_time_s(double speed_mps, double typical_range_m) const;
  /// Standard deviation of the constant part of each pair, in units of the adjustment's noise.
  [[nodiscard]] double pair_sigma() const { return sigma_of(true); }

 private:
  [[nodiscard]] double sigma_of(bool constant) const;
};

struct ErrorSample;

/// Estimates the correlation of the errors of arrivals and bearings, and its effect on the covariance.
///
/// Errors are modelled as white noise plus variance components: random values that are constant over cells of
/// time, place, direction and range, at several scales each, of a pair or of a beacon. With F the influence
/// of each observation on the parameters (LeverageSweep) and Z_l the cells of component l, residuals r = M e
/// have E |Z_m'r|^2 = sum_l theta_l tr(Z_m'M Z_l Z_l'M Z_m), which is linear in the variances theta. The
/// traces come from random signs (Hutchinson), and theta from non-negative least squares weighted by the
/// covariance of the sums |Z_m'r|^2: quadratic estimation of variance components (Rao 1971; Searle, Casella
/// and McCulloch 1992, chapter 11), as REML does by likelihood. M accounts for the errors that the estimates
/// have absorbed.
///
/// The covariance is the model-based sandwich C + sum_l theta_l (F'Z_l)(F'Z_l)'. The variance of each
/// parameter is multiplied by nu / (nu - 2) (Student), where nu are the degrees of freedom that follow from
/// the scatter of theta.
///
/// Residuals that pass a test of whiteness (each sum against its simulated distribution, Bonferroni
/// correction, one in a hundred) leave the covariance unchanged; down to one in ten thousand the model counts
/// in part.
/// @param C  covariance under white noise; sites without a dense matrix are not modelled
/// @param trajectories  solved, outliers rejected
/// @param share_of_log  their share of the log of which C is the covariance
[[nodiscard]] ErrorModel error_model_of(const ParameterLayout& layout,
                                        const std::vector<Trajectory>& trajectories, const SharedState& state,
                                        const Covariance& C, double share_of_log = 1.0, int threads = 1);

/// Error model of a sample.
[[nodiscard]] ErrorModel error_model_of(const ErrorSample& sample, int threads = 1);

/// Maximum number of rows of a sample for an error model.
inline constexpr std::size_t kMostRows = 40'000;

}  // namespace octant::calib
