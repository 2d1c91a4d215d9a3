// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/streamed.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "calib/adjust/adjust.h"
#include "calib/adjust/priors.h"
#include "calib/adjust/quadratic_sum.h"
#include "calib/adjust/reject.h"
#include "calib/problem/ranges.h"
#include "calib/problem/thin.h"
#include "calib/start/approach.h"
#include "calib/stream/streamed_log.h"
#include "calib/verdict/conclude.h"

namespace octant::calib {
namespace {

/// Rows, observations, tiles and marks of one arrival; rows, states and their systems of one odometry row.
constexpr std::size_t kBytesOfWhole = 220, kBytesOfWholeStep = 850;
constexpr int kMostPasses = 40;
/// Costs of two readings are the same to this share.
constexpr double kSameCost = 1e-11;
/// A step that would change the cost by a smaller share is none.
constexpr double kNoStep = 1e-12;
constexpr double kFirstDamping = 1e-3;

class StreamedCalibrator {
 public:
  StreamedCalibrator(const Site& site, ArrivalSource& source, const SolveOptions& options,
                     std::size_t memory_bytes)
      : site_(site),
        source_(source),
        options_(options),
        alone_(options),
        plan_(stream_plan(memory_bytes, options.threads)),
        course_(alone_) {
    alone_.ranks = nullptr;
  }

  Result<StreamedCalibration> run() {
    if (!course_.report("first reading of the log", 0.01)) return finished(interrupted_solution());
    StreamedLog log(site_, source_, plan_);
    if (auto ok = log.scan(); !ok) return fail(ok.error());
    auto part = log.part(options_.threads);
    if (!part) return fail(part.error());
    // So small that each rank is sooner done with it than it would hear of the others.
    Approach found = approach(*part, alone_, course_);
    warnings_ = log.warnings(*part);
    warnings_.insert(warnings_.end(), found.warnings.begin(), found.warnings.end());
    it_ = std::move(found.estimate);
    part_sigma_ = found.ok ? agreeing_sigma(found.trajectories, it_.state()) : 1.0;
    frame_ = std::move(*part);
    frame_.trajectories.clear();
    if (found.ok) follow_first_rank();
    if (!found.ok) {
      found.why_not.trajectories = std::move(found.trajectories);
      return finished(std::move(found.why_not));
    }
    for (std::size_t run = 0; run < frame_.runs.size(); ++run) {
      frame_.runs[run].arrivals = {};
      frame_.runs[run].bearings = source_.log(run).bearings;
    }
    found = {};

    log.begin(frame_, options_, plan_.workers, course_);
    const auto settled = settle_noise(log);
    if (!settled) return stopped(settled.error());
    if (!course_.report("covariance and verdict", 0.92)) return finished(interrupted_solution());
    FindingsGatherer gatherer(frame_, it_, log.states());
    if (auto told = log.tell(it_, gatherer); !told) return stopped(told.error());
    LogFindings gathered = std::move(gatherer).findings(it_);
    for (std::size_t run = 0; run < frame_.runs.size(); ++run)
      frame_.runs[run].arrivals = std::move(gathered.arrivals[run]);
    Solution solution;
    solution.warnings = warnings_;
    solution.warnings.insert(solution.warnings.end(), gathered.warnings.begin(), gathered.warnings.end());
    solution.contradictions = frame_.contradictions;
    conclude(frame_, options_, it_, std::move(gathered.findings), gathered.trajectories, solution);
    solution.trajectories = std::move(gathered.trajectories);
    return finished(std::move(solution));
  }

 private:
  using Clock = std::chrono::steady_clock;

  Result<StreamedCalibration> finished(Solution solution) {
    if (solution.status == SolveStatus::kUndetermined && solution.warnings.empty())
      solution.warnings = warnings_;
    solution.iterations = course_.iterations;
    solution.seconds = std::chrono::duration<double>(Clock::now() - began_).count();
    return StreamedCalibration{std::move(frame_), std::move(solution)};
  }

  Result<StreamedCalibration> stopped(const Error& error) {
    if (error.code != Errc::kInterrupted) return fail(error);
    return finished(interrupted_solution());
  }

  /// Ranks on different processors may have found what differs in the last digits.
  void follow_first_rank() {
    if (options_.ranks == nullptr) return;
    std::vector<double> numbers(static_cast<std::size_t>(it_.x.size()) + 1, 0.0);
    if (options_.ranks->index() == 0) {
      std::copy(it_.x.begin(), it_.x.end(), numbers.begin());
      numbers.back() = part_sigma_;
    }
    options_.ranks->sum(numbers);
    std::copy(numbers.begin(), numbers.end() - 1, it_.x.begin());
    part_sigma_ = numbers.back();
  }

  /// Plain squares on the arrivals that agree; the noise as found where the stated one is off.
  Result<void> settle_noise(LogReadings& log) {
    if (!course_.report("states of the whole log", 0.68)) return interrupted();
    const double suspect_sigmas = options_.rejection_sigmas * std::max(1.0, part_sigma_);
    // Where the part's noise is as stated, the whole's will be, and the first rejection goes in one with the
    // placing.
    bool marked = !is_far_off(part_sigma_);
    auto placed = log.place(it_, suspect_sigmas, marked);
    if (!placed) return fail(placed.error());
    frame_.typical_range_m =
        placed->ranges_m.empty() ? 1.0 : std::max(median(std::move(placed->ranges_m)), 1e-3);
    const double factor = agreeing_sigma(std::move(placed->residuals));
    if (is_far_off(factor)) {
      if (marked) placed = log.place(it_, suspect_sigmas, false);
      if (!placed) return fail(placed.error());
      marked = false;
      it_.noise_factor *= factor;
    }
    std::optional<PassSum> first;
    if (marked) first = std::move(placed->sum);  // if there is one
    NoiseSearch noise;
    for (int round = 0; round < kNoiseRounds; ++round) {
      const auto settled = reject_and_adjust(log, std::exchange(first, std::nullopt));
      if (!settled) return fail(settled.error());
      const double prior = prior_cost(frame_, it_.layout, it_.x);
      const double off =
          noise.step(it_.last.cost - prior,
                     statistics_of(frame_, it_.layout, settled->counts.of_log, it_.last.cost).redundancy);
      if (off == 1.0) break;
      it_.noise_factor *= off;
      *it_.last.data_information /= off * off;
    }
    return {};
  }

  /// Newton's method on the sums of the passes, with arrivals rejected and readmitted at each. A step that
  /// makes things worse is taken back, and from then on marks change only where the adjustment has settled.
  /// @param first  at the present estimate, if it is known
  Result<PassSum> reject_and_adjust(LogReadings& log, std::optional<PassSum> first) {
    double cost = INFINITY, damping = 0.0;
    Eigen::VectorXd x;  // where `sum` is of
    PassSum sum;
    bool careful = false;
    MarkPolicy marks = MarkPolicy::kFirst;
    int marked = 0;
    for (int pass = 0; pass < kMostPasses; ++pass) {
      if (!course_.report("adjustment of the arrivals that agree", std::min(0.9, 0.7 + 0.03 * pass)))
        return interrupted();
      Result<PassSum> next = first ? Result<PassSum>(std::move(*first)) : log.pass(it_, marks);
      if (!next) return next;
      first.reset();
      ++course_.iterations;
      const double prior = prior_cost(frame_, it_.layout, it_.x);
      if (next->counts.cost_before + prior > cost * (1 + kSameCost) && marks != MarkPolicy::kFirst &&
          damping < 1e6) {
        if (careful) {  // from where it was, a shorter step
          damping = std::max(kFirstDamping, 10 * damping);
          it_.x = stepped(sum.system, x, damping).x;
        } else {
          it_.x = x;
          cost = INFINITY;
        }
        careful = true;
        marks = MarkPolicy::kKept;
        continue;
      }
      log.accept();
      sum = std::move(*next);
      x = it_.x;
      cost = sum.system.cost + prior;
      damping = damping < kFirstDamping ? 0.0 : damping / 10;
      marked += marks != MarkPolicy::kKept;
      const Step step = stepped(sum.system, x, damping);
      const double gain = damping > 0 ? stepped(sum.system, x, 0.0).gain : step.gain;
      const bool settled = gain <= kNoStep * cost;
      if (settled && (sum.counts.changed == 0 || marked >= kRejectionRounds) && marks != MarkPolicy::kKept)
        return ended(std::move(sum), cost, true);
      const bool may_mark = marked < kRejectionRounds && (!careful || settled);
      if (settled && !may_mark) return ended(std::move(sum), cost, true);
      marks = !may_mark ? MarkPolicy::kKept : settled ? MarkPolicy::kFirst : MarkPolicy::kSettled;
      if (!settled) it_.x = step.x;
    }
    return ended(std::move(sum), cost, false);
  }

  Result<PassSum> ended(PassSum sum, double cost, bool converged) {
    it_.last = {};
    it_.last.converged = converged;
    it_.last.cost = cost;
    it_.last.iterations = course_.iterations;
    it_.last.message = converged ? "no step changes the cost any more"
                                 : fmt::format("no rest after {} readings of the log", kMostPasses);
    it_.last.data_information = sum.system.H;
    return sum;
  }

  /// To the optimum of what the observations look like from a point, priors, bounds and taped distances as
  /// they are.
  struct Step {
    Eigen::VectorXd x;
    double gain = 0.0;
  };
  [[nodiscard]] Step stepped(const ReducedSystem& system, const Eigen::VectorXd& from, double damping) const {
    Step step{from, 0.0};
    QuadraticSum sum(system, from, damping, &step.x);
    AdjustOptions options;
    options.max_iterations = options_.max_iterations;
    options.function_tolerance = 1e-16;
    const AdjustResult result = adjust(frame_, it_.layout, sum, step.x, options);
    step.gain = system.cost + prior_cost(frame_, it_.layout, from) - result.cost;
    return step;
  }

  static tl::unexpected<Error> interrupted() {
    return fail({.code = Errc::kInterrupted, .found = "interrupted"});
  }

  const Site& site_;
  ArrivalSource& source_;
  const SolveOptions& options_;
  SolveOptions alone_;  ///< without ranks
  StreamPlan plan_;
  Clock::time_point began_ = Clock::now();
  Course course_;
  Problem frame_;  ///< the log without its arrivals
  Estimate it_;
  double part_sigma_ = 1.0;
  std::vector<std::string> warnings_;
};

}  // namespace

std::size_t memory_of_whole(std::size_t arrivals, std::size_t odometry_rows) {
  return arrivals * kBytesOfWhole + odometry_rows * kBytesOfWholeStep;
}

std::size_t least_memory_streamed(std::size_t arrivals, std::size_t odometry_rows) {
  constexpr std::size_t kMega = std::size_t{1} << 20, kProgram = 20 * kMega;
  constexpr std::size_t kLookedAt = 110'000, kBytesLookedAt = 1600;
  constexpr std::size_t kOfDrives = 90 * kMega, kBytesOfStep = 115;  // rows, states, stretches looked at
  if (odometry_rows > 0) return kOfDrives + odometry_rows * kBytesOfStep;
  return kProgram + std::min(arrivals, kLookedAt) * kBytesLookedAt + 7 * arrivals / 2;
}

namespace {

/// Why a drive cannot be.
std::optional<std::string> why_no_streamed_drive(const Site& site, const MeasurementLog& run) {
  for (std::size_t v = 0; v < site.vehicles.size(); ++v) {
    const auto rows = std::count_if(run.odometry.begin(), run.odometry.end(),
                                    [v](const OdometryStep& s) { return s.vehicle.index() == v; });
    if (rows < 2) return fmt::format("{} has no odometry of {}", run.path, site.vehicles[v].name);
  }
  return {};
}

/// Why stops cannot be.
std::optional<std::string> why_no_streamed_stops(const MeasurementLog& run) {
  if (!run.has_epochs) return fmt::format("{} has neither epochs nor odometry", run.path);
  if (!run.odometry.empty()) return fmt::format("{} has stops with odometry between them", run.path);
  return {};
}

}  // namespace

std::optional<std::string> why_not_streamed(const Site& site, const std::vector<const MeasurementLog*>& runs,
                                            int dense_limit) {
  Problem frame;
  frame.site = site;
  for (const MeasurementLog* run : runs) {
    if (auto why = is_drive(*run) ? why_no_streamed_drive(site, *run) : why_no_streamed_stops(*run))
      return why;
    frame.runs.push_back(without_lists(*run));
  }
  if (const int size =
          make_layout(frame, prior_state(site), std::vector<bool>(site.beacons.size(), false)).size();
      size > dense_limit)
    return fmt::format("there are {} parameters, more than {}", size, dense_limit);
  return {};
}

Result<StreamedCalibration> solve_streamed(const Site& site, ArrivalSource& source,
                                           const SolveOptions& options, std::size_t memory_bytes) {
  return StreamedCalibrator(site, source, options, memory_bytes).run();
}

}  // namespace octant::calib
