// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/newton_steps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calib/adjust/adjust.h"
#include "calib/adjust/priors.h"
#include "calib/stream/quadratic_sum.h"

namespace octant::calib {
namespace {

constexpr int kMostPasses = 40;
/// Relative difference below which the costs of two passes are equal.
constexpr double kSameCost = 1e-11;
/// Smallest relative change of the cost by a step.
constexpr double kNoStep = 1e-12;
constexpr double kFirstDamping = 1e-3;

class NewtonSteps {
 public:
  NewtonSteps(LogReadings& readings, const Problem& frame, const SolveOptions& options,
              ProgressMonitor& monitor, Estimate& estimate)
      : readings_(readings), frame_(frame), options_(options), monitor_(monitor), estimate_(estimate) {}

  Result<PassSum> run(std::optional<PassSum> first) {
    double cost = INFINITY, damping = 0.0;
    Eigen::VectorXd x;  // where `sum` is of
    PassSum sum;
    bool careful = false;
    RejectionPolicy policy = RejectionPolicy::kFirst;
    int rejection_rounds = 0;
    for (int pass = 0; pass < kMostPasses; ++pass) {
      if (!monitor_.report_inliers(pass)) return interrupted();
      Result<PassSum> next = first ? Result<PassSum>(std::move(*first)) : readings_.pass(estimate_, policy);
      if (!next) return next;
      first.reset();
      ++monitor_.iterations;
      const double prior = prior_cost(frame_, estimate_.layout, estimate_.x);
      if (next->counts.cost_before + prior > cost * (1 + kSameCost) && policy != RejectionPolicy::kFirst &&
          damping < 1e6) {
        if (careful) {  // from where it was, a shorter step
          damping = std::max(kFirstDamping, 10 * damping);
          estimate_.x = stepped(sum.system, x, damping).x;
        } else {
          estimate_.x = x;
          cost = INFINITY;
        }
        careful = true;
        policy = RejectionPolicy::kKept;
        continue;
      }
      readings_.accept();
      sum = std::move(*next);
      x = estimate_.x;
      cost = sum.system.cost() + prior;
      damping = damping < kFirstDamping ? 0.0 : damping / 10;
      rejection_rounds += policy != RejectionPolicy::kKept;
      const NewtonStep step = stepped(sum.system, x, damping);
      const double gain = damping > 0 ? stepped(sum.system, x, 0.0).gain : step.gain;
      const bool has_converged = gain <= kNoStep * cost;
      if (has_converged && (sum.counts.changed == 0 || rejection_rounds >= kRejectionRounds) &&
          policy != RejectionPolicy::kKept)
        return ended(std::move(sum), cost, true);
      const bool may_reject = rejection_rounds < kRejectionRounds && (!careful || has_converged);
      if (has_converged && !may_reject) return ended(std::move(sum), cost, true);
      policy = !may_reject     ? RejectionPolicy::kKept
               : has_converged ? RejectionPolicy::kFirst
                               : RejectionPolicy::kConverged;
      if (!has_converged) estimate_.x = step.x;
    }
    return ended(std::move(sum), cost, false);
  }

 private:
  Result<PassSum> ended(PassSum sum, double cost, bool converged) {
    estimate_.last = {};
    estimate_.last.converged = converged;
    estimate_.last.cost = cost;
    estimate_.last.iterations = monitor_.iterations;
    estimate_.last.message =
        converged ? "no step changes the cost any more"
                  : fmt::format("the estimate still changed after {} passes over the log", kMostPasses);
    estimate_.last.data = sum.system;
    return sum;
  }

  /// A step to the optimum of the quadratic model of the observations, with priors, bounds and taped
  /// distances.
  struct NewtonStep {
    Eigen::VectorXd x;
    double gain = 0.0;
  };
  [[nodiscard]] NewtonStep stepped(const SystemParts& data, const Eigen::VectorXd& from,
                                   double damping) const {
    NewtonStep step{from, 0.0};
    QuadraticSum sum(data, from, damping, &step.x);
    AdjustOptions options;
    options.max_iterations = options_.max_iterations;
    options.workers.threads = options_.threads;
    options.function_tolerance = 1e-16;
    const AdjustResult result = adjust(frame_, estimate_.layout, sum, step.x, options);
    step.gain = data.cost() + prior_cost(frame_, estimate_.layout, from) - result.cost;
    return step;
  }

  LogReadings& readings_;
  const Problem& frame_;
  const SolveOptions& options_;
  ProgressMonitor& monitor_;
  Estimate& estimate_;
};

}  // namespace

Result<PassSum> newton_steps(LogReadings& readings, const Problem& frame, const SolveOptions& options,
                             ProgressMonitor& monitor, std::optional<PassSum> first, Estimate& estimate) {
  return NewtonSteps(readings, frame, options, monitor, estimate).run(std::move(first));
}

}  // namespace octant::calib
