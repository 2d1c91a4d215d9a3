// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/streamed.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "calib/adjust/priors.h"
#include "calib/adjust/reject.h"
#include "calib/calibrator.h"
#include "calib/problem/ranges.h"
#include "calib/problem/subsample.h"
#include "calib/stream/chunks/chunk_passes.h"
#include "calib/stream/chunks/chunk_subsample.h"
#include "calib/stream/drives/drive_passes.h"
#include "calib/stream/drives/drive_subsample.h"
#include "calib/stream/long_log.h"
#include "calib/stream/newton_steps.h"

namespace octant::calib {
namespace {

/// Memory in bytes for one arrival (rows, observations, tiles, marks) and for one odometry row (rows, states,
/// their systems).
constexpr std::size_t kBytesOfHeld = 220, kBytesOfHeldStep = 850;

/// Log of a source, read again in each pass: drives in segments (drives/), everything else in chunks
/// (chunks/). One pass is one step of the adjustment (newton_steps.h).
class StreamedLog : public CalibrationLog {
 public:
  /// The arguments must outlive it.
  /// @param memory_bytes  bound of the process, which limits the size of the chunks
  StreamedLog(const Site& site, ArrivalSource& source, const SolveOptions& options, ProgressMonitor& monitor,
              std::size_t memory_bytes)
      : site_(site),
        source_(source),
        options_(options),
        monitor_(monitor),
        plan_(stream_plan(memory_bytes, options.threads)),
        chunks_(state_kinds(source, site), site.beacons.size(), plan_.chunk_arrivals),
        drives_(source, site) {}

  /// Its runs have the arrivals of the sample, and finally those of evenly spaced states.
  [[nodiscard]] const Problem& problem() const override { return frame_; }
  [[nodiscard]] Problem release_problem() && { return std::move(frame_); }

  /// Reads everything once, and samples evenly spread stops and segments of drives.
  Result<Sample> next_sample() override {
    if (is_scanned_) return Sample{};  // there is only one sample
    if (!monitor_.report("first reading of the log", 0.01)) return interrupted();
    if (auto ok = scan(); !ok) return fail(ok.error());
    auto sample = part();
    if (!sample) return fail(sample.error());
    frame_ = std::move(*sample);
    return Sample{&frame_};
  }

  Result<double> place(Approach& start, double sigma) override {
    start.trajectories = {};
    begin_readings();
    const double suspect_sigmas = options_.rejection_sigmas * std::max(1.0, sigma);
    // If the noise of the part is as expected, that of the whole log will be too, and the first rejection is
    // combined with solving the states.
    const bool reject = !is_far_off(sigma);
    auto placed = readings_.place(start.estimate, suspect_sigmas, reject);
    if (!placed) return fail(placed.error());
    frame_.typical_range_m =
        placed->ranges_m.empty() ? 1.0 : std::max(median(std::move(placed->ranges_m)), 1e-3);
    states_ = placed->states;
    const double of_all = agreeing_sigma(std::move(placed->residuals));
    if (reject && is_far_off(of_all)) placed = readings_.place(start.estimate, suspect_sigmas, false);
    if (!placed) return fail(placed.error());
    first_sum_ = std::move(placed->sum);
    return of_all;
  }

  Result<DataSquares> adjust_inliers(Estimate& estimate) override {
    const auto last = newton_steps(readings_, frame_, options_, monitor_,
                                   std::exchange(first_sum_, std::nullopt), estimate);
    if (!last) return fail(last.error());
    return DataSquares{
        estimate.last.cost - prior_cost(frame_, estimate.layout, estimate.x),
        statistics_of(frame_, estimate.layout, last->counts.of_log, estimate.last.cost).redundancy,
        last->counts.poses};
  }

  void scale_noise(Estimate& estimate, const NoiseFactors& factors) override {
    estimate.noise_factor *= factors.arrivals;
    estimate.pose_factor *= factors.poses;
    if (estimate.last.data) estimate.last.data->scale(1.0 / std::pow(factors.arrivals, 2));
  }

  Result<Findings> findings(const Estimate& estimate) override {
    FindingsGatherer gatherer(frame_, estimate, states_);
    if (auto gathered = readings_.gather(estimate, gatherer); !gathered) return fail(gathered.error());
    GatheredFindings all = std::move(gatherer).findings(estimate);
    for (std::size_t run = 0; run < frame_.runs.size(); ++run)
      frame_.runs[run].arrivals = std::move(all.arrivals[run]);
    return Findings(std::move(all));
  }

 private:
  Result<void> scan() {
    is_scanned_ = true;
    auto read = source_.scan([&](std::size_t run, const std::vector<Arrival>& block) {
      chunks_.add(run, block);
      if (!has_stops_alone(run)) drives_.add(run, block);
      return true;
    });
    if (!read) return read;
    chunks_.end(source_.runs());
    drives_.end(plan_.piece_bytes);
    return {};
  }

  /// Runs with only stops are subsampled by epochs, all others by segments of time.
  [[nodiscard]] bool has_stops_alone(std::size_t run) const {
    const auto& kinds = chunks_.kinds(run);
    return std::ranges::all_of(kinds, [](StateKind k) { return k == StateKind::kStops; });
  }

  /// Includes the warnings of make_problem() for all drives; others are counted at the end.
  [[nodiscard]] Result<Problem> part() const {
    std::vector<MeasurementLog> runs;
    for (std::size_t run = 0; run < source_.runs(); ++run) {
      auto sample = has_stops_alone(run) ? subsample_of_stops(run, site_, source_, chunks_, options_.threads)
                                         : subsample_of_drives(run, site_, source_, drives_);
      if (!sample) return fail(sample.error());
      runs.push_back(std::move(*sample));
    }
    auto problem = make_problem(site_, std::move(runs), options_.threads);
    if (!problem) return problem;
    problem->warnings.clear();
    for (const DriveChain& chain : drives_.chains())
      if (chain.stateless_count > 0)
        problem->warnings.push_back(
            stateless_in_words(source_.log(chain.run), chain.stateless_line, chain.stateless_count));
    return problem;
  }

  /// Removes the data that each pass reads from the frame.
  void begin_readings() {
    frame_.trajectories.clear();
    for (std::size_t run = 0; run < frame_.runs.size(); ++run) {
      frame_.runs[run].arrivals = {};
      frame_.runs[run].bearings = source_.log(run).bearings;
    }
    const ReadingTask task{frame_,   source_,       options_,
                           monitor_, plan_.workers, chunks_.arrivals() + drives_.arrivals()};
    if (chunks_.arrivals() > 0 || drives_.pieces().empty())
      readings_.add(std::make_unique<ChunkPasses>(task, chunks_));
    if (!drives_.pieces().empty()) readings_.add(std::make_unique<DrivePasses>(task, drives_));
  }

  const Site& site_;
  ArrivalSource& source_;
  const SolveOptions& options_;
  ProgressMonitor& monitor_;
  StreamPlan plan_;
  ChunkIndex chunks_;
  DriveIndex drives_;
  bool is_scanned_ = false;
  Problem frame_;  ///< log without its arrivals
  JoinedReadings readings_;
  std::size_t states_ = 0;
  std::optional<PassSum> first_sum_;  ///< sums of the first pass, which also solved the states
};

/// Memory of the sums of a pass at sites with too many parameters for dense matrices, times the number of
/// simultaneous copies. A drive connects all beacons that it passes, a stop some dozens that it receives.
std::size_t bytes_of_sums(const Site& site, const std::vector<const MeasurementLog*>& runs, bool drives) {
  constexpr std::size_t kSums = 6;
  Problem frame;
  frame.site = site;
  for (const MeasurementLog* run : runs) frame.runs.push_back(without_lists(*run));
  const auto n = static_cast<std::size_t>(make_layout(frame, prior_state(site)).size());
  if (n <= kDenseLimit) return 0;
  return kSums * sizeof(double) * n * (drives ? n : kDenseLimit);
}

}  // namespace

std::size_t memory_of_held(std::size_t arrivals, std::size_t odometry_rows) {
  return arrivals * kBytesOfHeld + odometry_rows * kBytesOfHeldStep;
}

std::size_t least_memory_streamed(const Site& site, const std::vector<const MeasurementLog*>& runs,
                                  std::size_t arrivals, std::size_t odometry_rows) {
  constexpr std::size_t kMega = std::size_t{1} << 20, kProgram = 20 * kMega;
  constexpr std::size_t kSampledStates = 110'000, kBytesOfSampledState = 1600;
  constexpr std::size_t kOfDrives = 90 * kMega, kBytesOfStep = 115;  // rows, states, current segments
  const std::size_t sums = bytes_of_sums(site, runs, odometry_rows > 0);
  if (odometry_rows > 0) return sums + kOfDrives + odometry_rows * kBytesOfStep;
  return sums + kProgram + std::min(arrivals, kSampledStates) * kBytesOfSampledState + 7 * arrivals / 2;
}

Result<StreamedCalibration> solve_streamed(const Site& site, ArrivalSource& source,
                                           const SolveOptions& options, std::size_t memory_bytes) {
  ProgressMonitor monitor(options);
  StreamedLog log(site, source, options, monitor, memory_bytes);
  auto solution = solve_log(log, options, monitor);
  if (!solution) return fail(solution.error());
  StreamedCalibration done{std::move(log).release_problem(), std::move(*solution)};
  done.problem.trajectories.clear();
  return done;
}

}  // namespace octant::calib
