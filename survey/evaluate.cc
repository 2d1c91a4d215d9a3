// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/evaluate.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace octant::survey {
namespace {

/// Fix times are often means of equal times: rounding must not push one off its sample, or beyond the
/// reference's end.
constexpr double kSameInstant_s = 1.0e-6;

/// A vehicle at rest was not elsewhere in between: one reference pose at the beginning of a stop and one at
/// its end are sufficient.
bool at_rest(const Pose& a, const Pose& b) {
  constexpr double kMoved_m = 1.0e-3, kTurned_rad = 1.0e-3;
  return (a.translation_m - b.translation_m).norm() < kMoved_m &&
         a.rotation.angularDistance(b.rotation) < kTurned_rad;
}

std::optional<Pose> reference_at(const std::vector<TimedPose>& truth, double time_s, double max_gap_s) {
  const auto after = std::ranges::lower_bound(truth, time_s - kSameInstant_s, {}, &TimedPose::time_s);
  if (after == truth.end()) return std::nullopt;
  if (std::abs(after->time_s - time_s) <= kSameInstant_s) return after->T_map_vehicle;
  if (after == truth.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double gap_s = after->time_s - before->time_s;
  if (gap_s > max_gap_s && !at_rest(before->T_map_vehicle, after->T_map_vehicle)) return std::nullopt;
  return interpolate(before->T_map_vehicle, after->T_map_vehicle, (time_s - before->time_s) / gap_s);
}

struct ErrorOfFix {
  Eigen::VectorXd tangent;           ///< fix less truth, in the tangent space of the motion
  Eigen::MatrixXd truth_covariance;  ///< covariance of the truth in the same tangent space
  double position_m = 0.0;
  double heading_rad = 0.0;
};

ErrorOfFix error_of(const Pose& fix, const Pose& truth, const PoseAccuracy& accuracy, Motion motion) {
  const auto square = [](double x) { return x * x; };
  ErrorOfFix error;
  const Eigen::Vector3d offset_m = fix.translation_m - truth.translation_m;
  error.tangent = tangent_between(truth, fix, motion);
  error.heading_rad = wrap_angle(fix.heading_rad() - truth.heading_rad());
  if (motion == Motion::kPlanar) {
    error.truth_covariance =
        Eigen::Vector3d(square(accuracy.position_sigma_m), square(accuracy.position_sigma_m),
                        square(accuracy.heading_sigma_rad))
            .asDiagonal();
    error.position_m = offset_m.head<2>().norm();
    return error;
  }
  // Heading and attitude are about the map's axes, the tangent is in the vehicle frame.
  const Eigen::Matrix3d R = truth.rotation.toRotationMatrix();
  const Eigen::Vector3d about_map_rad2(square(accuracy.attitude_sigma_rad),
                                       square(accuracy.attitude_sigma_rad),
                                       square(accuracy.heading_sigma_rad));
  error.truth_covariance = Eigen::MatrixXd::Zero(6, 6);
  error.truth_covariance.topLeftCorner<3, 3>().diagonal().setConstant(square(accuracy.position_sigma_m));
  error.truth_covariance.bottomRightCorner<3, 3>() = R.transpose() * about_map_rad2.asDiagonal() * R;
  error.position_m = offset_m.norm();
  return error;
}

/// A fix in space whose attitude was not estimated says so by the variance of a uniform angle.
bool has_rotation(const Fix& fix, Motion motion) {
  return motion == Motion::kPlanar ||
         fix.covariance.diagonal().tail<3>().minCoeff() < 0.99 * kUnknownRotationVariance;
}

/// Squared Mahalanobis distance over its degrees of freedom; of the position only if the reference or the fix
/// has no heading.
std::optional<double> nees_over_dof(const Fix& fix, const ErrorOfFix& error, bool heading_known,
                                    Motion motion) {
  if (fix.covariance.rows() < error.tangent.size() || fix.covariance.cols() < error.tangent.size())
    return std::nullopt;
  const bool with_rotation = heading_known && has_rotation(fix, motion);
  const Eigen::Index n = with_rotation ? error.tangent.size() : (motion == Motion::kPlanar ? 2 : 3);
  const Eigen::MatrixXd C = fix.covariance.topLeftCorner(n, n) + error.truth_covariance.topLeftCorner(n, n);
  if (!C.allFinite()) return std::nullopt;
  const Eigen::LLT<Eigen::MatrixXd> llt(C);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const double nees = llt.matrixL().solve(error.tangent.head(n)).squaredNorm() / static_cast<double>(n);
  return std::isfinite(nees) ? std::optional<double>(nees) : std::nullopt;
}

/// Quantile with linear interpolation between order statistics. @param values not empty, ascending
double quantile(const std::vector<double>& values, double q) {
  const double at = q * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

struct ErrorSums {
  std::vector<double> position_m;
  double heading_rad2 = 0.0, nees = 0.0;
  std::size_t headings = 0, nees_count = 0;
};

void add_run(const ReferencedRun& run, Motion motion, Evaluation& result, ErrorSums& sums) {
  for (const Fix& fix : run.fixes) {
    if (!fix.ok()) {
      ++result.no_fix;
      continue;
    }
    ++result.fixes;
    const auto truth = reference_at(run.truth, fix.time_s, run.truth_accuracy.max_gap_s);
    if (!truth) continue;
    const ErrorOfFix error = error_of(fix.T_map_vehicle, *truth, run.truth_accuracy, motion);
    sums.position_m.push_back(error.position_m);
    if (run.truth_accuracy.heading_known && has_rotation(fix, motion)) {
      sums.heading_rad2 += error.heading_rad * error.heading_rad;
      ++sums.headings;
    }
    if (const auto nees = nees_over_dof(fix, error, run.truth_accuracy.heading_known, motion)) {
      sums.nees += *nees;
      ++sums.nees_count;
    }
  }
}

}  // namespace

bool Evaluation::pass() const {
  return std::ranges::all_of(gates, [](const Gate& gate) { return gate.pass; });
}

Evaluation evaluate(const std::vector<Fix>& fixes, const std::vector<TimedPose>& truth,
                    const PoseAccuracy& truth_accuracy, Motion motion, const Tolerance& tolerance) {
  return evaluate({ReferencedRun{fixes, truth, truth_accuracy}}, motion, tolerance);
}

Evaluation evaluate(const std::vector<ReferencedRun>& runs, Motion motion, const Tolerance& tolerance) {
  Evaluation result;
  ErrorSums sums;
  for (const ReferencedRun& run : runs) add_run(run, motion, result, sums);
  result.matched = sums.position_m.size();
  if (result.matched == 0) {
    result.gates.push_back({"matched", 1.0, 0.0, false});
    return result;
  }
  double squares_m2 = 0.0;
  for (double error_m : sums.position_m) squares_m2 += error_m * error_m;
  result.position_rmse_m = std::sqrt(squares_m2 / static_cast<double>(result.matched));
  std::ranges::sort(sums.position_m);
  const std::size_t quantiles = std::min(kErrorQuantiles, result.matched);
  for (std::size_t i = 0; i < quantiles; ++i)
    result.error_quantiles_m.push_back(quantile(
        sums.position_m, quantiles > 1 ? static_cast<double>(i) / static_cast<double>(quantiles - 1) : 1.0));
  result.position_p95_m = quantile(sums.position_m, 0.95);
  result.max_error_m = sums.position_m.back();
  if (sums.headings > 0)
    result.heading_rmse_rad = std::sqrt(sums.heading_rad2 / static_cast<double>(sums.headings));
  if (sums.nees_count > 0) result.nees_mean = sums.nees / static_cast<double>(sums.nees_count);
  if (tolerance.fix_m) {
    result.gates.push_back(
        {"fix_m", *tolerance.fix_m, result.position_rmse_m, result.position_rmse_m <= *tolerance.fix_m});
  }
  return result;
}

std::vector<BeaconError> beacon_errors(const Deployment& deployment, const Deployment& reference) {
  std::vector<BeaconError> errors;
  for (const DeploymentBeacon& beacon : deployment.beacons) {
    if (beacon.status != BeaconStatus::kCalibrated) continue;
    const auto same = std::ranges::find(reference.beacons, beacon.name, &DeploymentBeacon::name);
    if (same != reference.beacons.end())
      errors.push_back({beacon.name, (beacon.position_m - same->position_m).norm()});
  }
  return errors;
}

}  // namespace octant::survey
