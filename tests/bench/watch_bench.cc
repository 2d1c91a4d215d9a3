// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Cost of the watch on a robot, for each arrival.
#include <benchmark/benchmark.h>

#include "models/localizers/least_squares/epoch_fix.h"
#include "models/watch/watch.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

struct Watched {
  Deployment deployment;
  std::vector<std::vector<Arrival>> epochs;
  std::vector<Fix> fixes;
  std::size_t arrivals = 0;
};

/// The hall's validation stops, localized; with attenuation the walk is part of the work.
Watched watched_hall(bool with_attenuation) {
  Scenario s = hall_scenario();
  s.path.epochs = 1;
  if (with_attenuation) add_attenuation(s);
  const World world = must(simulate(s, 1));
  Watched out{world.truth, {}, {}, 0};
  for (const Arrival& a : world.heldout.arrivals) {
    if (out.epochs.empty() || out.epochs.back().front().epoch != a.epoch) out.epochs.emplace_back();
    out.epochs.back().push_back(a);
  }
  LeastSquaresLocalizer localizer(world.truth);
  for (const auto& epoch : out.epochs) {
    out.fixes.push_back(localizer.Localizer::locate({.arrivals = epoch, .bearings = {}}));
    out.arrivals += epoch.size();
  }
  return out;
}

void per_arrival(benchmark::State& state, std::size_t arrivals) {
  state.counters["per_arrival"] =
      benchmark::Counter(static_cast<double>(arrivals),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void watch_epochs(benchmark::State& state) {
  const Watched hall = watched_hall(state.range(0) == 1);
  Watch watch(hall.deployment);
  for (auto _ : state)
    for (std::size_t i = 0; i < hall.epochs.size(); ++i)
      benchmark::DoNotOptimize(watch.observe_epoch(hall.epochs[i], hall.fixes[i]));
  per_arrival(state, hall.arrivals);
}
BENCHMARK(watch_epochs)->ArgName("attenuation")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

void watch_arrivals(benchmark::State& state) {
  const Watched hall = watched_hall(state.range(0) == 1);
  Watch watch(hall.deployment);
  const PoseCovariance covariance = Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
  for (auto _ : state)
    for (std::size_t i = 0; i < hall.epochs.size(); ++i) {
      watch.start(hall.fixes[i].T_map_vehicle, covariance);
      for (const Arrival& a : hall.epochs[i]) benchmark::DoNotOptimize(watch.observe_arrival(a));
    }
  per_arrival(state, hall.arrivals);
}
BENCHMARK(watch_arrivals)->ArgName("attenuation")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace octant::test
