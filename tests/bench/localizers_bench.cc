// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A fix by each method, on the world after its paper (datasets/).
#include <map>

#include <benchmark/benchmark.h>

#include "io/site/scenario_yaml.h"
#include "models/localizers/drive/drive_tracker.h"
#include "models/localizers/drive/odometry_track.h"
#include "models/localizers/line_map/line_map_localizer.h"
#include "models/localizers/methods.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

const World& world_of(const std::string& folder) {
  static std::map<std::string, World> worlds;
  const auto found = worlds.find(folder);
  if (found != worlds.end()) return found->second;
  return worlds
      .emplace(folder,
               must(simulate(
                   must(io::read_scenario(OCTANT_SOURCE_DIR "/datasets/" + folder + "/scenario.yaml")), 1)))
      .first->second;
}

void fix(benchmark::State& state, const char* folder, Method method) {
  const World& world = world_of(folder);
  std::size_t fixes = 0;
  for (auto _ : state) fixes = must(locate_run(method, world.truth, world.heldout)).size();
  state.counters["fixes"] = static_cast<double>(fixes);
  state.counters["per_fix"] =
      benchmark::Counter(static_cast<double>(fixes),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(fix, hall_least_squares, "hall", Method::kLeastSquares)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, kleeman, "kleeman", Method::kKleeman)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, kleeman_least_squares, "kleeman", Method::kLeastSquares)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, head_tail, "head_tail", Method::kHeadTail)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, head_tail_least_squares, "head_tail", Method::kLeastSquares)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, one_beacon, "greenhouse", Method::kOneBeacon)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, rail, "greenhouse", Method::kRail)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, reflectors, "reflectors", Method::kReflectors)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, binaural, "binaural", Method::kBinaural)->Unit(benchmark::kMillisecond);

/// The tracker as a robot runs it: every odometry row and every instant of arrivals of a drive, the search
/// for the start included.
void drive_tracker(benchmark::State& state) {
  static const World world = must(simulate(drive_scenario(60.0), 1));
  std::size_t fixes = 0;
  for (auto _ : state) {
    state.PauseTiming();
    DriveTracker tracker(world.truth, world.heldout.odometry_accuracy);
    const std::vector<OdometryStep>& rows = world.heldout.odometry;
    std::size_t row = 0;
    Fix fix;
    fixes = 0;
    state.ResumeTiming();
    const auto& arrivals = world.heldout.arrivals;
    for (std::size_t first = 0, last = 0; first < arrivals.size(); first = last, ++fixes) {
      while (last < arrivals.size() && arrivals[last].time_s == arrivals[first].time_s) ++last;
      while (row < rows.size() && (row == 0 || rows[row - 1].time_s < arrivals[first].time_s))
        benchmark::DoNotOptimize(tracker.move(rows[row++]));
      tracker.locate(Observations{std::span(arrivals).subspan(first, last - first), {}}, fix);
    }
  }
  state.counters["fixes"] = static_cast<double>(fixes);
  state.counters["per_fix"] =
      benchmark::Counter(static_cast<double>(fixes),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(drive_tracker)->Unit(benchmark::kMillisecond);

void line_map(benchmark::State& state) {
  const World& world = world_of("driveway");
  const auto map = build_line_map(world.run);
  if (!map || !line_map_fits(*map, world.heldout))
    return state.SkipWithError("no map, or a run that cannot be located on it");
  LineMapLocalizer localizer(*map);
  std::size_t scans = 0;
  for (auto _ : state) scans = localizer.locate(world.heldout).size();
  state.counters["scans"] = static_cast<double>(scans);
  state.counters["per_fix"] =
      benchmark::Counter(static_cast<double>(scans),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(line_map)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace octant::test
