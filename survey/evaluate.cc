// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/evaluate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "models/localizers/common/open_attitude.h"

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
  return motion == Motion::kPlanar || !has_open_attitude(fix);
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
  std::vector<double> position_m, horizontal_m, vertical_m;
  double heading_rad2 = 0.0, nees = 0.0;
  std::size_t headings = 0, nees_count = 0;
  std::size_t fixes = 0, no_fix = 0, reference_poses = 0, covered = 0;

  void add(const ErrorSums& other) {
    for (auto list : {&ErrorSums::position_m, &ErrorSums::horizontal_m, &ErrorSums::vertical_m})
      (this->*list).insert((this->*list).end(), (other.*list).begin(), (other.*list).end());
    heading_rad2 += other.heading_rad2;
    nees += other.nees;
    headings += other.headings;
    nees_count += other.nees_count;
    fixes += other.fixes;
    no_fix += other.no_fix;
    reference_poses += other.reference_poses;
    covered += other.covered;
  }
  [[nodiscard]] double availability() const { return share(fixes, fixes + no_fix); }
  [[nodiscard]] double coverage() const { return share(covered, reference_poses); }
  static double share(std::size_t part, std::size_t all) {
    return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0;
  }
};

/// Fixes whose attitude is open are compared at the point that they locate, where the reference has an
/// attitude. Else its unknown place about that point stays in their covariance.
void compare_where_located(const ReferencedRun& run, Fix& fix, Pose& truth) {
  if (!has_open_attitude(fix) || !run.truth_accuracy.heading_known) return;
  truth.translation_m = truth * run.p_located_vehicle_m;
  fix.covariance.diagonal().head<3>().array() -= open_attitude_variance_m2(run.p_located_vehicle_m);
}

void add_error(const ReferencedRun& run, Fix fix, Pose truth, Motion motion, ErrorSums& sums) {
  compare_where_located(run, fix, truth);
  const ErrorOfFix error = error_of(fix.T_map_vehicle, truth, run.truth_accuracy, motion);
  const Eigen::Vector3d off_m = fix.T_map_vehicle.translation_m - truth.translation_m;
  sums.position_m.push_back(error.position_m);
  sums.horizontal_m.push_back(off_m.head<2>().norm());
  sums.vertical_m.push_back(std::abs(off_m.z()));
  if (run.truth_accuracy.heading_known && has_rotation(fix, motion)) {
    sums.heading_rad2 += error.heading_rad * error.heading_rad;
    ++sums.headings;
  }
  if (const auto nees = nees_over_dof(fix, error, run.truth_accuracy.heading_known, motion)) {
    sums.nees += *nees;
    ++sums.nees_count;
  }
}

/// Number of reference poses with a fix within their largest gap.
std::size_t covered_poses(const ReferencedRun& run) {
  std::vector<double> times_s;
  for (const Fix& fix : run.fixes)
    if (fix.ok()) times_s.push_back(fix.time_s);
  std::ranges::sort(times_s);
  return static_cast<std::size_t>(std::ranges::count_if(run.truth, [&](const TimedPose& pose) {
    const double gap_s = run.truth_accuracy.max_gap_s;
    const auto next = std::ranges::lower_bound(times_s, pose.time_s - gap_s);
    return next != times_s.end() && *next <= pose.time_s + gap_s;
  }));
}

/// @param sums  sorted on return
ErrorFigures figures_of(ErrorSums& sums, Motion motion) {
  ErrorFigures figures;
  if (sums.position_m.empty()) return figures;
  double squares_m2 = 0.0, sum_m = 0.0;
  for (const double error_m : sums.position_m) {
    squares_m2 += error_m * error_m;
    sum_m += error_m;
  }
  const auto count = static_cast<double>(sums.position_m.size());
  figures.mean_m = sum_m / count;
  figures.rmse_m = std::sqrt(squares_m2 / count);
  std::ranges::sort(sums.position_m);
  std::ranges::sort(sums.horizontal_m);
  std::ranges::sort(sums.vertical_m);
  figures.ce50_m = quantile(sums.horizontal_m, 0.5);
  figures.ce95_m = quantile(sums.horizontal_m, 0.95);
  if (motion == Motion::kSpatial) {
    figures.ve95_m = quantile(sums.vertical_m, 0.95);
    figures.se95_m = quantile(sums.position_m, 0.95);
  }
  return figures;
}

std::optional<LatencyFigures> latency_figures(const std::vector<ReferencedRun>& runs) {
  std::vector<double> all_s;
  for (const ReferencedRun& run : runs)
    all_s.insert(all_s.end(), run.latencies_s.begin(), run.latencies_s.end());
  if (all_s.empty()) return std::nullopt;
  std::ranges::sort(all_s);
  const double sum_s = std::accumulate(all_s.begin(), all_s.end(), 0.0);
  return LatencyFigures{sum_s / static_cast<double>(all_s.size()), quantile(all_s, 0.95), all_s.back()};
}

std::optional<Pose> reference_at(const ReferencedRun& run, double time_s) {
  return reference_at(run.truth, time_s, run.truth_accuracy.max_gap_s);
}

void compare(const ReferencedRun& run, Motion motion, ErrorSums& sums) {
  for (const Fix& fix : run.fixes) {
    ++(fix.ok() ? sums.fixes : sums.no_fix);
    if (!fix.ok()) continue;
    if (const auto truth = reference_at(run, fix.time_s)) add_error(run, fix, *truth, motion, sums);
  }
  sums.reference_poses += run.truth.size();
  sums.covered += covered_poses(run);
}

RunFigures run_figures(std::string name, ErrorSums& sums, Motion motion) {
  return {.name = std::move(name),
          .fixes = sums.fixes,
          .no_fix = sums.no_fix,
          .matched = sums.position_m.size(),
          .errors = figures_of(sums, motion),
          .availability = sums.availability(),
          .coverage = sums.coverage()};
}

/// Heights between floors: in the middle of each interval without a reference pose that is as high as a room.
std::vector<double> heights_between_floors(const std::vector<ReferencedRun>& runs) {
  constexpr double kLowestRoom_m = 2.0;
  std::vector<double> heights_m, between_m;
  for (const ReferencedRun& run : runs)
    for (const TimedPose& pose : run.truth) heights_m.push_back(pose.T_map_vehicle.translation_m.z());
  std::ranges::sort(heights_m);
  for (std::size_t i = 1; i < heights_m.size(); ++i)
    if (heights_m[i] - heights_m[i - 1] > kLowestRoom_m)
      between_m.push_back(0.5 * (heights_m[i] + heights_m[i - 1]));
  return between_m;
}

/// Part of a recording with heights of the reference in [from_m, to_m). Fixes without a reference have no
/// floor.
ReferencedRun part_at(const ReferencedRun& run, double from_m, double to_m) {
  const auto is_here = [&](const Pose& pose) {
    return pose.translation_m.z() >= from_m && pose.translation_m.z() < to_m;
  };
  ReferencedRun part = run;
  std::erase_if(part.truth, [&](const TimedPose& pose) { return !is_here(pose.T_map_vehicle); });
  std::erase_if(part.fixes, [&](const Fix& fix) {
    const auto truth = reference_at(run, fix.time_s);
    return !truth || !is_here(*truth);
  });
  return part;
}

double mean_height_m(const std::vector<ReferencedRun>& parts) {
  double sum_m = 0.0, count = 0.0;
  for (const ReferencedRun& part : parts)
    for (const TimedPose& pose : part.truth) {
      sum_m += pose.T_map_vehicle.translation_m.z();
      count += 1.0;
    }
  return sum_m / count;
}

std::vector<RunFigures> figures_of_floors(const std::vector<ReferencedRun>& runs, Motion motion) {
  std::vector<double> limits_m = heights_between_floors(runs);
  if (limits_m.empty()) return {};
  limits_m.insert(limits_m.begin(), -std::numeric_limits<double>::infinity());
  limits_m.push_back(std::numeric_limits<double>::infinity());
  std::vector<RunFigures> floors;
  for (std::size_t f = 0; f + 1 < limits_m.size(); ++f) {
    std::vector<ReferencedRun> parts;
    ErrorSums sums;
    for (const ReferencedRun& run : runs) {
      parts.push_back(part_at(run, limits_m[f], limits_m[f + 1]));
      compare(parts.back(), motion, sums);
    }
    floors.push_back(run_figures(fmt::format("{:.1f} m", mean_height_m(parts)), sums, motion));
  }
  return floors;
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
  for (const ReferencedRun& run : runs) {
    ErrorSums of_run;
    compare(run, motion, of_run);
    result.runs.push_back(run_figures(run.name, of_run, motion));
    sums.add(of_run);
  }
  result.floors = figures_of_floors(runs, motion);
  result.latency = latency_figures(runs);
  result.fixes = sums.fixes;
  result.no_fix = sums.no_fix;
  result.matched = sums.position_m.size();
  result.availability = sums.availability();
  result.coverage = sums.coverage();
  if (result.matched == 0) {
    result.gates.push_back({"matched", 1.0, 0.0, false});
    return result;
  }
  result.errors = figures_of(sums, motion);
  result.position_rmse_m = result.errors.rmse_m;
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
