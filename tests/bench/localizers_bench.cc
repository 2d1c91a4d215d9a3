// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A fix by each method, on the world after its paper (datasets/).
#include <map>

#include <benchmark/benchmark.h>

#include "io/scenario_yaml.h"
#include "models/localizers/methods.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

const World& world_of(const std::string& folder) {
  static std::map<std::string, World> worlds;
  const auto found = worlds.find(folder);
  if (found != worlds.end()) return found->second;
  return worlds.emplace(folder, must(simulate(must(io::read_scenario(OCTANT_SOURCE_DIR "/datasets/" + folder + "/scenario.yaml")), 1))).first->second;
}

void fix(benchmark::State& state, const char* folder, Method method) {
  const World& world = world_of(folder);
  std::size_t fixes = 0;
  for (auto _ : state) fixes = must(locate_run(method, world.truth, world.heldout)).size();
  state.counters["fixes"] = static_cast<double>(fixes);
  state.counters["per_fix"] = benchmark::Counter(static_cast<double>(fixes), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(fix, hall_least_squares, "hall", Method::kLeastSquares)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, kleeman, "kleeman", Method::kKleeman)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, kleeman_least_squares, "kleeman", Method::kLeastSquares)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, head_tail, "head_tail", Method::kHeadTail)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, head_tail_least_squares, "head_tail", Method::kLeastSquares)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, one_beacon, "greenhouse", Method::kOneBeacon)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, rail, "greenhouse", Method::kRail)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, reflectors, "reflectors", Method::kReflectors)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix, binaural, "binaural", Method::kBinaural)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace octant::test
