// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Calibration as a whole and in parts, compared with the plain adjustment by arrivals in one run.
#include <map>

#include <benchmark/benchmark.h>

#include "calib/calibrate.h"
#include "tests/calib/referee.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

Scenario stops(int epochs) {
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  s.heldout_path.epochs = 1;
  return s;
}

const calib::Problem& problem_for(const char* kind, int size) {
  static std::map<std::pair<std::string, int>, calib::Problem> kept;
  const auto key = std::make_pair(std::string(kind), size);
  if (const auto found = kept.find(key); found != kept.end()) return found->second;
  Scenario s = stops(size);
  if (key.first == "echoes") s.echo_fraction = 0.3;
  if (key.first == "cycle_offset") {
    s.site.timing.clock = Clock::kCycleOffset;
    s.site.timing.delay_per = {};
    s.true_delay_s.reset();
  }
  if (key.first == "attenuation") {
    add_attenuation(s);
    s.log_amplitude = true;
  }
  if (key.first == "drive") s = drive_scenario(size);
  if (key.first == "motion_prior") {
    s = drive_scenario(size);
    s.site.vehicles[0].motion = MotionPrior{};
  }
  World world = must(simulate(s, 1));
  if (key.first == "motion_prior") world.run.odometry.clear();
  return kept.emplace(key, must(calib::make_problem(world.site, {world.run}))).first->second;
}

std::size_t arrivals_of(const calib::Problem& problem) {
  std::size_t count = 0;
  for (const MeasurementLog& run : problem.runs) count += run.arrivals.size();
  return count;
}

void solve(benchmark::State& state, const char* kind) {
  const calib::Problem& problem = problem_for(kind, static_cast<int>(state.range(0)));
  calib::SolveOptions options;
  options.threads = 1;
  for (auto _ : state) benchmark::DoNotOptimize(calib::solve(problem, options).final_cost);
  const auto arrivals = static_cast<double>(arrivals_of(problem));
  state.counters["arrivals"] = arrivals;
  state.counters["per_arrival"] = benchmark::Counter(
      arrivals, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(solve, stops, "stops")->Arg(100)->Arg(1000)->Arg(5000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, cycle_offset, "cycle_offset")->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, echoes, "echoes")->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, attenuation, "attenuation")->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, drive, "drive")->Arg(120)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, motion_prior, "motion_prior")->Arg(120)->Unit(benchmark::kMillisecond);

/// One Ceres residual for each arrival, automatic derivatives, started at the tiles' optimum: only its cost
/// for each iteration remains.
void per_arrival_ceres(benchmark::State& state) {
  const calib::Problem& problem = problem_for("stops", static_cast<int>(state.range(0)));
  const calib::Solution solution = calib::solve(problem);
  for (auto _ : state) benchmark::DoNotOptimize(referee(problem, solution).cost);
}
BENCHMARK(per_arrival_ceres)->Arg(100)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace octant::test
