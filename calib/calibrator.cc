// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/calibrator.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "calib/adjust/reject.h"
#include "calib/solution/diagnosis_budget.h"
#include "calib/start/refusals.h"
#include "calib/verdict/diagnose.h"
#include "calib/verdict/weights.h"

namespace octant::calib {
namespace {

class Calibrator {
 public:
  Calibrator(CalibrationLog& log, const SolveOptions& options, ProgressMonitor& monitor)
      : log_(log), options_(options), monitor_(monitor) {}

  Result<Solution> run() {
    Result<Solution> solution = calibrated();
    if (!solution && solution.error().code == Errc::kInterrupted) solution = interrupted_solution();
    if (!solution) return solution;
    solution->iterations = monitor_.iterations;
    solution->seconds = std::chrono::duration<double>(Clock::now() - began_).count();
    if (solution->diagnosis.fit_s == 0.0) solution->diagnosis.fit_s = thread_time_s() - began_s_;
    return solution;
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// The method, step by step.
  Result<Solution> calibrated() {
    // Initial values, then graduated non-convexity (Yang, Antonante, Tzoumas, Carlone 2020, algorithm 1), of
    // an evenly spread part of a long log.
    auto found = start();
    if (!found) return fail(found.error());
    if (!found->ok) return unsolved(std::move(*found));
    // The states of the whole log, and the noise from their residuals (truncated variance, reject.h).
    const auto sigma = place_all(std::move(*found));
    if (!sigma) return fail(sigma.error());
    // Least squares on the inliers with this noise. The states are eliminated by variable projection (Golub,
    // Pereyra 1973) and their Schur complement (Triggs et al. 2000, section 6.1).
    if (auto ok = adjust_with_noise_as_found(*sigma); !ok) return fail(ok.error());
    // The covariance is the inverse of the reduced normal matrix. The verdict follows from it.
    if (!monitor_.report("covariance and verdict", 0.92)) return interrupted();
    auto all = log_.findings(estimate_);
    if (!all) return fail(all.error());
    warnings_.insert(warnings_.end(), all->warnings.begin(), all->warnings.end());
    Solution solution;
    solution.warnings = std::move(warnings_);
    solution.contradictions = log_.problem().contradictions;
    const std::string shadowed = conclude(log_.problem(), options_, estimate_, std::move(*all), solution);
    // The solution is complete. The search for contradictions has a time limit of its own.
    solution.diagnosis.fit_s = thread_time_s() - began_s_;
    diagnose(log_.problem(), options_, estimate_, solution);
    if (!solution.contradictions.empty()) return solution;
    if (auto ok = weigh_priors(solution); !ok) return fail(ok.error());
    add_warnings(log_.problem(), options_, estimate_, shadowed, solution);
    return solution;
  }

  /// Adjusts again with the weight of the priors under the errors as found, if it matters.
  Result<void> weigh_priors(Solution& solution) {
    if (solution.status != SolveStatus::kConverged) return {};
    double growth = growth_against_priors(estimate_.layout, solution);
    follow_first_rank(estimate_.x, growth);
    if (growth == 1.0) return {};
    if (!monitor_.report("weight of the priors", 0.97)) return interrupted();
    Estimate weighted = with_weighted_priors(estimate_, growth);
    log_.resume(solution.trajectories);
    if (auto ok = log_.adjust_inliers(weighted); !ok) return fail(ok.error());
    if (!weighted.last.converged) return {};
    auto all = log_.findings(weighted);
    if (!all) return fail(all.error());
    Solution again;
    static_cast<void>(conclude(log_.problem(), options_, weighted, std::move(*all), again));
    adopt_if_better(estimate_.layout, growth, std::move(again), solution);
    return {};
  }

  Result<Approach> start() {
    Approach found;
    for (;;) {
      const auto sample = log_.next_sample();
      if (!sample) return fail(sample.error());
      if (sample->problem == nullptr) return found;
      is_complete_ = sample->is_complete;
      // Each rank solves a small part itself, because communication would take longer.
      SolveOptions options = options_;
      if (!is_complete_) options.ranks = nullptr;
      ProgressMonitor monitor(options);
      found = approach(*sample->problem, options, monitor);
      monitor_.iterations += monitor.iterations;
      if (found.ok) return found;
    }
  }

  Result<Solution> unsolved(Approach found) {
    Solution solution = std::move(found.why_not);
    solution.warnings = log_.problem().warnings;
    solution.warnings.insert(solution.warnings.end(), found.warnings.begin(), found.warnings.end());
    const auto& contradictions = log_.problem().contradictions;
    solution.contradictions.insert(solution.contradictions.begin(), contradictions.begin(),
                                   contradictions.end());
    solution.trajectories = std::move(found.trajectories);
    return solution;
  }

  /// @return sigma of the residuals that agree
  Result<double> place_all(Approach found) {
    warnings_ = log_.problem().warnings;
    warnings_.insert(warnings_.end(), found.warnings.begin(), found.warnings.end());
    double sigma = agreeing_sigma(found.trajectories, found.estimate.state());
    if (!is_complete_) {
      follow_first_rank(found.estimate.x, sigma);
      if (!monitor_.report("states of the whole log", 0.68)) return interrupted();
    }
    auto of_all = log_.place(found, sigma);
    estimate_ = std::move(found.estimate);
    return of_all;
  }

  /// Adopts the result of the first rank; on other processors the last digits may differ.
  void follow_first_rank(Eigen::VectorXd& x, double& sigma) const {
    if (options_.ranks == nullptr) return;
    std::vector<double> numbers(static_cast<std::size_t>(x.size()) + 1, 0.0);
    if (options_.ranks->index() == 0) {
      std::ranges::copy(x, numbers.begin());
      numbers.back() = sigma;
    }
    options_.ranks->sum(numbers);
    std::copy(numbers.begin(), numbers.end() - 1, x.begin());
    sigma = numbers.back();
  }

  Result<DataSquares> adjust_with_noise_as_found(double sigma) {
    // Measured poses absorb a part of the errors of the arrivals, so the residuals contain little of them.
    const auto& runs = log_.problem().runs;
    const bool are_posed =
        std::ranges::any_of(runs, [](const MeasurementLog& run) { return !run.poses.empty(); });
    if (is_far_off(sigma) && (sigma > 1 || !are_posed)) log_.scale_noise(estimate_, {.arrivals = sigma});
    return adjust_and_scale_noise(
        [this] { return log_.adjust_inliers(estimate_); },
        [this](const NoiseFactors& factors) { log_.scale_noise(estimate_, factors); });
  }

  CalibrationLog& log_;
  const SolveOptions& options_;
  ProgressMonitor& monitor_;
  Clock::time_point began_ = Clock::now();
  double began_s_ = thread_time_s();
  bool is_complete_ = false;  ///< the start used the complete log
  Estimate estimate_;
  std::vector<std::string> warnings_;
};

}  // namespace

Result<Solution> solve_log(CalibrationLog& log, const SolveOptions& options, ProgressMonitor& monitor) {
  return Calibrator(log, options, monitor).run();
}

}  // namespace octant::calib
