// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "calib/adjust/adjust.h"
#include "calib/adjust/priors.h"
#include "calib/adjust/reject.h"
#include "calib/calibrate.h"
#include "calib/errors/statistics.h"
#include "calib/problem/flips.h"
#include "calib/start/approach.h"
#include "calib/stream/long_log.h"
#include "calib/verdict/conclude.h"

namespace octant::calib {

const char* to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::kConverged: return "ok";
    case SolveStatus::kNotConverged: return "not_converged";
    case SolveStatus::kUndetermined: return "undetermined";
    case SolveStatus::kInterrupted: return "interrupted";
  }
  return "not_converged";
}

namespace {

/// Where a beacon is hardly known the last adjustment creeps along a bent valley, and comes to rest all the
/// same.
constexpr int kIterationsToRest = 4;

/// The course of one calibration, stage by stage.
class Calibrator {
 public:
  /// @param own_trajectories  the problem's, if they may be taken
  Calibrator(const Problem& problem, const SolveOptions& options,
             std::vector<Trajectory>* own_trajectories = nullptr)
      : problem_(problem),
        options_(options),
        own_trajectories_(own_trajectories),
        began_(Clock::now()),
        course_(options) {
    solution_.warnings = problem.warnings;
    solution_.contradictions = problem.contradictions;
  }

  Solution run() {
    if (!approach_by_part() && !approach_all()) return finished(std::move(solution_));
    if (!settle_noise()) return finished(interrupted_solution());
    course_.report("covariance and verdict", 0.95);
    conclude(problem_, options_, it_, findings(), trajectories_, solution_);
    return finished(std::move(solution_));
  }

 private:
  using Clock = std::chrono::steady_clock;

  bool approach_all() {
    Approach all = approach(problem_, options_, course_);
    take(all);
    trajectories_ = std::move(all.trajectories);
    start_headings_rad_ = std::move(all.start_headings_rad);
    if (all.ok) return true;
    all.why_not.warnings = std::move(solution_.warnings);
    all.why_not.contradictions.insert(all.why_not.contradictions.begin(), solution_.contradictions.begin(),
                                      solution_.contradictions.end());
    solution_ = std::move(all.why_not);
    return false;
  }

  /// The same for a long log by way of an evenly spread part of it: the shared parameters then are good to a
  /// fraction of the noise, and each state follows from them alone.
  bool approach_by_part() {
    if (!is_long(problem_)) return false;
    const Result<Problem> part = part_of(problem_, options_.threads);
    if (!part) return false;
    Approach of_part = approach(*part, options_, course_);
    if (!of_part.ok || !course_.report("states of the whole log", 0.68)) return false;
    take(of_part);
    if (own_trajectories_ != nullptr) {
      trajectories_ = std::move(*own_trajectories_);
    } else {
      trajectories_ = problem_.trajectories;
    }
    const SharedState state = it_.state();
    const double noise = std::max(1.0, agreeing_sigma(of_part.trajectories, state));
    place_all(problem_, it_.layout, state, it_.beacon_usable, options_.rejection_sigmas * noise,
              options_.workers(), trajectories_);
    start_headings_rad_ = epoch_headings_rad(trajectories_);
    return true;
  }

  void take(Approach& found) {
    it_ = std::move(found.estimate);
    solution_.warnings.insert(solution_.warnings.end(), found.warnings.begin(), found.warnings.end());
  }

  bool adjust_again() {
    AdjustOptions to_rest = course_.adjust_options(0.0, 1e-12);
    to_rest.max_iterations *= kIterationsToRest;
    it_.last = adjust(problem_, it_.layout, trajectories_, it_.x, to_rest);
    return !it_.last.interrupted;
  }

  /// Plain squares on the arrivals that agree; the noise as found where the stated one is off.
  bool settle_noise() {
    const double factor = agreeing_sigma(trajectories_, it_.state());
    if (is_far_off(factor)) scale_noise(factor);  // small departures wait for the chi-square test
    NoiseSearch noise;
    for (int round = 0; round < kNoiseRounds; ++round) {
      if (!reject_and_adjust()) return false;
      statistics_ =
          statistics_of(problem_, it_.layout, trajectories_, it_.state(), it_.last.cost, options_.threads);
      // A prior that is contradicted is no noise of the arrivals: only what the recordings say counts.
      const double off =
          noise.step(it_.last.cost - prior_cost(problem_, it_.layout, it_.x), statistics_->redundancy);
      if (off == 1.0) break;
      scale_noise(off);
    }
    return true;
  }

  void scale_noise(double factor) {
    const double before_s = problem_.site.noise.tof_sigma_s * it_.noise_factor;
    it_.noise_factor *= factor;
    it_.last.data_information.reset();
    statistics_.reset();
    rescale_noise(trajectories_, before_s, factor * before_s);
  }

  bool reject_and_adjust() {
    for (int round = 0; round < kRejectionRounds; ++round) {
      if (!course_.report("adjustment of the arrivals that agree", std::min(0.9, 0.7 + 0.03 * round)))
        return false;
      const std::size_t changed =
          mark_rejected(trajectories_, it_.state(), options_.rejection_sigmas, options_.threads);
      if (round > 0 && changed == 0) break;
      it_.last.data_information.reset();
      if (!adjust_again()) return false;
    }
    return true;
  }

  Findings findings() {
    Findings f;
    const SharedState state = it_.state();
    f.statistics = statistics_ ? *statistics_
                               : statistics_of(problem_, it_.layout, trajectories_, state, it_.last.cost,
                                               options_.threads);
    f.whiteness = whiteness_of(trajectories_, state, options_.threads);
    f.flips = report_flips(problem_, trajectories_, start_headings_rad_);
    f.left_out = left_out_of(problem_, trajectories_, state);
    return f;
  }

  Solution finished(Solution solution) {
    solution.trajectories = std::move(trajectories_);
    solution.iterations = course_.iterations;
    solution.seconds = std::chrono::duration<double>(Clock::now() - began_).count();
    return solution;
  }

  const Problem& problem_;
  const SolveOptions& options_;
  std::vector<Trajectory>* own_trajectories_;
  Clock::time_point began_;
  Course course_;
  Estimate it_;
  std::vector<Trajectory> trajectories_;
  std::vector<std::vector<double>> start_headings_rad_;
  std::optional<CalibrationStatistics> statistics_;  ///< at the last states and marks
  Solution solution_;
};

}  // namespace

Solution solve(const Problem& problem, const SolveOptions& options) {
  return Calibrator(problem, options).run();
}

Solution solve_in_place(Problem& problem, const SolveOptions& options) {
  return Calibrator(problem, options, &problem.trajectories).run();
}

}  // namespace octant::calib
