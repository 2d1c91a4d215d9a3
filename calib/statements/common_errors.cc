// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/common_errors.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "calib/problem/ranges.h"
#include "calib/statements/measured_path.h"
#include "calib/statements/receiver_pattern.h"
#include "calib/statements/score_test.h"

namespace octant::calib {
namespace {

using Kind = CommonError::Kind;
using Span = std::pair<double, double>;

/// Maximum number of arrivals examined in a long recording.
constexpr std::size_t kArrivalsExamined = 20'000;
/// Number of times within a recording at which a jump is tested.
constexpr Eigen::Index kJumps = 32;
/// Number of groups of equally many consecutive measured poses. Shifts are tested between groups.
constexpr Eigen::Index kPoseGroups = 12;
/// Signals faster than this are not sound, so their speed does not depend on the temperature.
constexpr double kFasterThanSound_mps = 1e5;
/// Largest amplitude of the receivers' pattern as a share of their distance from the middle of the array.
constexpr double kLargestPattern = 0.5;

/// Time span and boundaries of the arrivals and measured poses of a run.
struct Times {
  Span span_s{INFINITY, -INFINITY};
  std::vector<double> jump_s;  ///< boundaries between groups of equally many arrivals
  /// Start times of the groups of poses except the first; empty if there are too few poses
  std::vector<double> group_s;
};

/// Boundaries that split the sorted times into groups of equal size.
std::vector<double> cuts(const std::vector<double>& sorted, Eigen::Index pieces) {
  std::vector<double> at;
  for (std::size_t j = 1; j < static_cast<std::size_t>(pieces); ++j) {
    const std::size_t k = std::max<std::size_t>(j * sorted.size() / static_cast<std::size_t>(pieces), 1);
    at.push_back(0.5 * (sorted[k - 1] + sorted[std::min(k, sorted.size() - 1)]));
  }
  return at;
}

Times times_of(const std::vector<Trajectory>& trajectories) {
  std::vector<double> arrivals, poses;
  for (const Trajectory& t : trajectories) {
    for (const ArrivalObservation& a : t.arrivals) arrivals.push_back(a.time_s);
    for (const PoseObservation& p : t.poses) poses.push_back(time_of(t, p));
  }
  Times times;
  if (arrivals.empty()) return times;
  std::ranges::sort(arrivals);
  times.span_s = {arrivals.front(), arrivals.back()};
  times.jump_s = cuts(arrivals, kJumps + 1);
  std::ranges::sort(poses);
  if (poses.size() >= 2 * static_cast<std::size_t>(kPoseGroups)) times.group_s = cuts(poses, kPoseGroups);
  return times;
}

/// Odometry matters little if there are measured poses, and exact poses would determine the curvature of the
/// path between odometry rows.
bool is_led_by_odometry(const Trajectory& t) {
  return t.motion == Motion::kPlanar && t.poses.empty() && !t.odometry.empty();
}

/// Errors tested in a run, in column order: distance and turns of the odometry; pattern of the receivers;
/// change of the medium; drift and jumps of the clock; shifts of each group of measured poses in x, y, z;
/// time lag of these poses.
class Patterns {
 public:
  static constexpr Eigen::Index kPattern = 2, kOfAllRuns = 3, kBesidePoses = kOfAllRuns + 2 + kJumps,
                                kOfPoses = 3 * kPoseGroups + 1, kLag = kBesidePoses + 3 * kPoseGroups;

  Patterns(Times times, const SharedState& state) : times_(std::move(times)), state_(state) {}

  bool operator()(const Trajectory& t, const ObservationRow& row, Eigen::RowVectorXd& by) {
    if (row.kind == RowKind::kPose) return of_pose(t, row, by);
    if (row.kind == RowKind::kOdometry && is_led_by_odometry(t)) {
      of_step(t.odometry[row.index], row.residual, by);
      return true;
    }
    if (row.kind != RowKind::kTof || !(times_.span_s.second > times_.span_s.first)) return false;
    const ArrivalObservation& a = t.arrivals[row.index];
    const double share = share_of_span(times_.span_s, a.time_s);
    if (!receivers_ || receivers_->trajectory() != &t) {
      receivers_.emplace(t, state_);
      least_lever_m_ = std::min(least_lever_m_, receivers_->least_lever_m());
    }
    by[kPattern] = receivers_->delay_s(a) / a.sigma_s;
    by[kOfAllRuns] = -a.tof_s * share / a.sigma_s;
    by[kOfAllRuns + 1] = share / a.sigma_s;
    for (Eigen::Index j = 0; j < kJumps; ++j)
      if (a.time_s >= times_.jump_s[static_cast<std::size_t>(j)]) by[kOfAllRuns + 2 + j] = 1.0 / a.sigma_s;
    return true;
  }

  /// Root-mean-square speed of the vehicle from its measured poses, if these belong to a drive.
  [[nodiscard]] double rms_speed_mps() const { return std::sqrt(speed2_sum_ / std::max(1.0, speeds_)); }

  /// Distance of the innermost receiver from the middle of its array.
  [[nodiscard]] double least_lever_m() const { return least_lever_m_; }

  /// Error of a column behind those that all runs have in common.
  [[nodiscard]] CommonError error_of(Eigen::Index column, std::size_t run) const {
    const Eigen::Index what = column - kOfAllRuns;
    if (what < 2) return {.kind = what == 0 ? Kind::kSpeed : Kind::kDrift, .run = run};
    return {.kind = Kind::kJump, .run = run, .time_s = times_.jump_s[static_cast<std::size_t>(what - 2)]};
  }

 private:
  /// Requires that the rows of a pose follow each other, position first.
  bool of_pose(const Trajectory& t, const ObservationRow& row, Eigen::RowVectorXd& by) {
    const PoseObservation& p = t.poses[row.index];
    if (times_.group_s.empty() || !std::isfinite(p.position_sigma_m)) return false;
    const bool is_planar = t.motion == Motion::kPlanar;
    const int turns = static_cast<int>(std::isfinite(p.heading_sigma_rad)) +
                      (is_planar ? 0 : 2 * static_cast<int>(std::isfinite(p.attitude_sigma_rad))),
              axes = is_planar ? 2 : 3;
    if (pose_ != &p) pose_rows_ = 0;
    pose_ = &p;
    const int axis = pose_rows_++ % (axes + turns);
    if (axis >= axes) return false;
    const auto group = std::ranges::upper_bound(times_.group_s, time_of(t, p)) - times_.group_s.begin();
    by[kBesidePoses + 3 * group + axis] = 1.0 / p.position_sigma_m;
    if (!t.moving || t.poses.size() < 2) return true;
    if (!path_ || path_->trajectory() != &t) path_.emplace(t);
    const double along_mps = path_->velocity_at(time_of(t, p))[axis];
    by[kLag] = -along_mps / p.position_sigma_m;
    speed2_sum_ += along_mps * along_mps;
    speeds_ += 1.0 / axes;
    return true;
  }

  /// Requires that the rows of a step follow each other: x, y, heading. A scale error is proportional to the
  /// adjusted step. The measured step contains its own noise, with which it is correlated (errors in
  /// variables), and on a straight drive most of the turns are noise.
  void of_step(const OdometryObservation& o, double residual, Eigen::RowVectorXd& by) {
    const int component = odometry_rows_++ % 3;
    if (component < 2) {
      by[0] = o.T_before_after.translation_m[component] / o.distance_sigma_m - residual;
    } else {
      by[1] = o.T_before_after.heading_rad() / o.heading_sigma_rad - residual;
    }
  }

  Times times_;
  const SharedState& state_;
  std::optional<ReceiverPattern> receivers_;
  double least_lever_m_ = INFINITY;
  int odometry_rows_ = 0, pose_rows_ = 0;
  const PoseObservation* pose_ = nullptr;  ///< pose of the current rows
  std::optional<MeasuredPath> path_;
  double speed2_sum_ = 0.0, speeds_ = 0.0;
};

/// The most significant shift of all measured poses from some group on. Errors of nearby poses may be
/// correlated, so the significance is reduced if the groups scatter about the shift more than white errors
/// would.
CommonError shift_of_poses(const ScoreTest& test, const Times& times, std::size_t run, int axes,
                           const AdjustedParameters& parameters) {
  constexpr double kSeen = 1e-3;  // share of the largest information of any group
  CommonError best{.kind = Kind::kShift, .run = run};
  const Eigen::Index errors = test.gradient().size();
  Eigen::MatrixXd groups = Eigen::MatrixXd::Zero(errors, axes * kPoseGroups);
  for (Eigen::Index k = 0; k < groups.cols(); ++k)
    groups(Patterns::kBesidePoses + 3 * (k / axes) + k % axes, k) = 1.0;
  const Eigen::ArrayXd variance = test.information(groups, groups, parameters.covariance).diagonal();
  const auto is_seen = (variance > kSeen * variance.maxCoeff()).eval();
  const double freedoms = std::max(1.0, static_cast<double>(is_seen.count() - axes));
  for (Eigen::Index from = 1; from < kPoseGroups; ++from) {
    Eigen::MatrixXd later = Eigen::MatrixXd::Zero(errors, axes);
    for (Eigen::Index k = from * axes; k < groups.cols(); ++k) later.col(k % axes) += groups.col(k);
    const ScoreTest::Finding found = test.of(later, parameters);
    const Eigen::ArrayXd left =
        groups.transpose() * test.gradient() -
        test.information(groups, later, parameters.covariance, parameters.share) * found.size;
    const double scatter = is_seen.select(left.square() / variance, 0.0).sum() / freedoms,
                 sigmas = found.sigmas / std::sqrt(std::max(1.0, scatter));
    if (!(sigmas > best.sigmas)) continue;
    best.sigmas = sigmas;
    best.time_s = times.group_s[static_cast<std::size_t>(from - 1)];
    best.size = found.size.norm();
    best.along.setZero();
    best.along.head(axes) = found.size / best.size;
  }
  return best;
}

double median_path_m(const std::vector<Trajectory>& trajectories) {
  std::vector<double> paths_m;
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals)
      paths_m.push_back(a.tof_s * t.nominal_speed_mps / a.legs());
  return median(std::move(paths_m));
}

/// Trajectories by run, with one of every `stride` segments.
std::map<std::size_t, std::vector<Trajectory>> some_of_each(const std::vector<Trajectory>& trajectories,
                                                            std::size_t stride) {
  std::map<std::size_t, std::vector<Trajectory>> some;
  for (const Trajectory& t : trajectories) some[t.run].push_back(some_segments(t, stride));
  return some;
}

/// Finds all significant errors of each run, and errors of devices, which are common to all runs.
class ErrorSearch {
 public:
  ErrorSearch(const SharedState& state, const AdjustedParameters& parameters, int threads,
              double least_sigmas)
      : state_(state), parameters_(parameters), threads_(threads), least_sigmas_(least_sigmas) {}

  std::vector<CommonError> run(const std::vector<Trajectory>& trajectories) {
    std::size_t arrivals = 0;
    for (const Trajectory& t : trajectories) arrivals += t.arrivals.size();
    const std::size_t stride = arrivals / kArrivalsExamined + 1;
    parameters_.share /= static_cast<double>(stride);
    const bool are_posed =
        std::ranges::any_of(trajectories, [](const Trajectory& t) { return !t.poses.empty(); });
    ScoreTest of_all(parameters_.layout.size(),
                     Patterns::kBesidePoses + (are_posed ? Patterns::kOfPoses : 0));
    std::size_t driven_run = 0;
    for (const auto& [run, of_run] : some_of_each(trajectories, stride)) {
      look_at(run, of_run, of_all);
      if (std::ranges::any_of(of_run, is_led_by_odometry)) driven_run = run;
    }
    add({.kind = Kind::kWay, .run = driven_run}, of_all.of_error(0, parameters_));
    add({.kind = Kind::kTurns, .run = driven_run}, of_all.of_error(1, parameters_));
    // An amplitude of twice the lever would be the pattern of receivers that are exchanged or turned round.
    const ScoreTest::Finding pattern = of_all.of_error(Patterns::kPattern, parameters_);
    if (std::abs(pattern.size[0]) < kLargestPattern * least_lever_m_) add({.kind = Kind::kPattern}, pattern);
    return std::move(found_);
  }

 private:
  void look_at(std::size_t run, const std::vector<Trajectory>& trajectories, ScoreTest& of_all) {
    const Times times = times_of(trajectories);
    Patterns patterns(times, state_);
    const ScoreTest test = score_test(trajectories, state_, parameters_.layout, of_all.gradient().size(),
                                      std::ref(patterns), threads_);
    of_all.add(test);  // only the first errors are common to all runs
    least_lever_m_ = std::min(least_lever_m_, patterns.least_lever_m());
    if (times.jump_s.empty()) return;  // no arrivals
    const Trajectory& first = trajectories.front();
    typical_range_m_ = median_path_m(trajectories);
    const bool is_sound = first.nominal_speed_mps < kFasterThanSound_mps;
    for (Eigen::Index column = Patterns::kOfAllRuns; column < Patterns::kBesidePoses; ++column)
      if (const CommonError error = patterns.error_of(column, run); is_sound || error.kind != Kind::kSpeed)
        add(error, test.of_error(column, parameters_));
    if (times.group_s.empty()) return;
    if (const double speed_mps = patterns.rms_speed_mps(); speed_mps > 0.0) {
      speed_mps_ = speed_mps;
      add({.kind = Kind::kLag, .run = run}, test.of_error(Patterns::kLag, parameters_));
    }
    CommonError shift =
        shift_of_poses(test, times, run, first.motion == Motion::kPlanar ? 2 : 3, parameters_);
    shift.length_m = shift.size;
    if (shift.sigmas > least_sigmas_) found_.push_back(shift);
  }

  /// Size of an error as a length, in ranges or positions.
  [[nodiscard]] double length_m(const CommonError& error) const {
    const double nominal_mps = parameters_.layout.nominal_speed_mps, size = std::abs(error.size);
    switch (error.kind) {
      case Kind::kDrift:
      case Kind::kJump: return size * nominal_mps;
      case Kind::kSpeed: return size * typical_range_m_;
      case Kind::kLag: return size * speed_mps_;
      default: return size;  // odometry: error of each metre of path
    }
  }

  void add(CommonError error, const ScoreTest::Finding& finding) {
    error.size = finding.size[0];
    error.sigmas = finding.sigmas;
    error.length_m = length_m(error);
    if (std::abs(error.sigmas) > least_sigmas_) found_.push_back(error);
  }

  const SharedState& state_;
  AdjustedParameters parameters_;
  int threads_;
  double least_sigmas_;
  double typical_range_m_ = 0.0, speed_mps_ = 0.0;  ///< values of the current run
  double least_lever_m_ = INFINITY;
  std::vector<CommonError> found_;
};

}  // namespace

std::vector<CommonError> common_errors(const std::vector<Trajectory>& trajectories, const SharedState& state,
                                       const AdjustedParameters& parameters, int threads,
                                       double least_sigmas) {
  std::vector<CommonError> all = ErrorSearch(state, parameters, threads, least_sigmas).run(trajectories);
  std::ranges::stable_sort(all, std::ranges::greater{}, [](const auto& e) { return std::abs(e.sigmas); });
  std::vector<CommonError> errors;
  for (CommonError& e : all) {
    const auto of_kind = [&](const CommonError& other) {
      return other.kind == e.kind && (is_of_all_runs(e) || other.run == e.run);
    };
    if (std::ranges::any_of(errors, of_kind)) continue;
    e.sigmas = std::abs(e.sigmas);
    errors.push_back(e);
  }
  return errors;
}

}  // namespace octant::calib
