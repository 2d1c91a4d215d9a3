// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/error_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "calib/adjust/information.h"
#include "calib/problem/ranges.h"

namespace octant::calib {
namespace {

/// Maximum number of refinements of a size, and the significance of what remains that is worth one.
constexpr int kSizings = 4;
constexpr double kWorthSizing = 1.0;

/// Adds the remaining error to `error`.
/// @return false if there is no remaining error
bool add_what_is_left(const std::vector<CommonError>& left, CommonError& error) {
  const auto more = std::ranges::find_if(left, [&](const CommonError& e) {
    return e.kind == error.kind && e.run == error.run && e.time_s == error.time_s;
  });
  if (more == left.end()) return false;
  const double before = error.size;
  if (error.kind == CommonError::Kind::kShift) {
    const Eigen::Vector3d shift_m = error.size * error.along + more->size * more->along;
    error.size = shift_m.norm();
    error.along = shift_m / std::max(error.size, 1e-12);
  } else {
    error.size += more->size;
  }
  if (before != 0.0) error.length_m *= std::abs(error.size / before);
  return true;
}

/// Residuals of the arrivals of a run that have a state, used or rejected, in order of time.
struct TimedResidual {
  double time_s, residual_s, sigma_s;
};
std::map<std::size_t, std::vector<TimedResidual>> residuals_by_run(const Fit& fit) {
  const SharedState state = fit.state();
  std::map<std::size_t, std::vector<TimedResidual>> runs;
  for (const Trajectory& t : fit.trajectories)
    for (const ArrivalObservation& a : t.arrivals)
      if (a.rejection == Rejection::kUsed || is_outlier(a.rejection))
        runs[t.run].push_back({a.time_s, a.sigma_s * arrival_residual(t, a, state), a.sigma_s});
  for (auto& [run, residuals] : runs) std::ranges::sort(residuals, {}, &TimedResidual::time_s);
  return runs;
}

/// Sum of the squared residuals after subtracting a step, each limited to the rejection limit.
double capped_squares(std::span<const TimedResidual> residuals, double step_s, double limit) {
  double sum = 0.0;
  for (const TimedResidual& r : residuals)
    sum += std::pow(std::min(limit, std::abs(r.residual_s - step_s) / r.sigma_s), 2);
  return sum;
}

/// Finds a jump of the clock that the largest consensus rejects. Nearly all arrivals on one side of it are
/// outliers, so the score of the used arrivals does not show it. The medians on both sides give its size.
std::optional<CommonError> jump_of_outliers(std::size_t run, const std::vector<TimedResidual>& all,
                                            double limit, double nominal_mps) {
  constexpr std::size_t kCuts = 32, kFewest = 40;
  constexpr double kGain = 0.5;  // largest remaining share of the squares
  if (all.size() < kFewest) return {};
  const double as_stated = capped_squares(all, 0.0, limit);
  CommonError best{.kind = CommonError::Kind::kJump, .run = run};
  double least = kGain * as_stated;
  for (std::size_t cut = 1; cut < kCuts; ++cut) {
    const std::span<const TimedResidual> whole(all);
    const auto before = whole.first(cut * all.size() / kCuts), after = whole.subspan(before.size());
    const auto middle_s = [](std::span<const TimedResidual> part) {
      std::vector<double> values;
      for (const TimedResidual& r : part) values.push_back(r.residual_s);
      return median(std::move(values));
    };
    const double before_s = middle_s(before), after_s = middle_s(after);
    const double squares = capped_squares(before, before_s, limit) + capped_squares(after, after_s, limit);
    if (!(squares < least)) continue;
    least = squares;
    best.time_s = 0.5 * (before.back().time_s + after.front().time_s);
    best.size = after_s - before_s;
    best.length_m = std::abs(best.size) * nominal_mps;
  }
  if (best.size == 0.0) return {};
  best.sigmas = std::sqrt(as_stated - least);
  return best;
}

/// Moves a jump, for which the fit was corrected, to the arrival at which it leaves the smallest sum of
/// squares, each limited to `limit`. Arrivals between the true and the assumed time deviate by its size.
/// @return true if it moved
bool sharpen(const Fit& without, double limit, CommonError& jump) {
  const std::vector<TimedResidual> all = residuals_by_run(without)[jump.run];
  const auto cost = [limit](const TimedResidual& r, double more_s) {
    return std::pow(std::min(limit, std::abs(r.residual_s + more_s) / r.sigma_s), 2);
  };
  const auto at = static_cast<std::size_t>(
      std::ranges::lower_bound(all, jump.time_s, {}, &TimedResidual::time_s) - all.begin());
  double best = 0.0, time_s = jump.time_s;
  double sum = 0.0;
  for (std::size_t i = at; i + 1 < all.size(); ++i) {  // later jump: these arrivals precede it
    sum += cost(all[i], jump.size) - cost(all[i], 0.0);
    if (sum < best) best = sum, time_s = all[i + 1].time_s;
  }
  sum = 0.0;
  for (std::size_t i = at; i-- > 0;) {  // earlier jump
    sum += cost(all[i], -jump.size) - cost(all[i], 0.0);
    if (sum < best) best = sum, time_s = all[i].time_s;
  }
  if (best == 0.0 && at < all.size()) time_s = all[at].time_s;
  const bool has_moved = best < 0.0;
  jump.time_s = time_s;
  return has_moved;
}

}  // namespace

std::vector<CommonError> errors_of(const SolveOptions& options, const Fit& fit, double least_sigmas) {
  std::vector<Trajectory> trajectories = fit.trajectories;
  const Information information =
      information_at(fit.problem, fit.layout, trajectories, fit.x, {.threads = options.threads});
  const Covariance covariance(Eigen::MatrixXd(information.data + information.prior), Eigen::MatrixXd());
  std::vector<CommonError> errors =
      common_errors(trajectories, fit.state(), {fit.layout, covariance}, options.threads, least_sigmas);
  for (const auto& [run, residuals] : residuals_by_run(fit))
    if (const auto jump =
            jump_of_outliers(run, residuals, options.rejection_sigmas, fit.layout.nominal_speed_mps))
      errors.insert(errors.begin(), *jump);
  return errors;
}

std::optional<ErrorFit> fit_without(const SolveOptions& options, const Fit& fit, CommonError error) {
  std::optional<ErrorFit> best;
  for (int sizing = 0; sizing < kSizings; ++sizing) {
    Fit without = fit;
    take_back(error, fit.state(), without.trajectories);
    adjust_anew(options, without);
    const double cost = best ? best->fit.cost : fit.cost;
    if (!without.ok || !(without.cost < cost)) break;
    best = ErrorFit{error, 1.0, std::move(without)};
    const bool is_jump = error.kind == CommonError::Kind::kJump;
    if (is_jump && sharpen(best->fit, options.rejection_sigmas, error)) continue;
    if (is_jump) best->error.time_s = error.time_s;
    const double least_sigmas = kWorthSizing * std::max(1.0, best->fit.noise_factor);
    if (is_jump || !add_what_is_left(errors_of(options, best->fit, least_sigmas), error)) break;
  }
  if (!best) return {};
  std::vector<Trajectory> with_error = best->fit.trajectories;
  CommonError back = best->error;
  back.size = -back.size;
  take_back(back, best->fit.state(), with_error);
  best->variance = variance_of_error(options, best->fit, with_error);
  best->error.sigmas = std::sqrt(2 * (fit.cost - best->fit.cost) / best->variance);
  return best;
}

double adjust_to_noise(const SolveOptions& options, Fit& fit) {
  constexpr double kFarLess = 0.7;
  double factor = 1.0;
  for (int round = 0; round < kSizings && fit.ok && fit.noise_factor < kFarLess; ++round) {
    factor *= fit.noise_factor;
    for (Trajectory& t : fit.trajectories)
      for (ArrivalObservation& a : t.arrivals) a.sigma_s *= fit.noise_factor;
    adjust_anew(options, fit);
  }
  return factor;
}

}  // namespace octant::calib
