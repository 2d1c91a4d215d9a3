// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A million cells and forty beacons: everything that a survey looks at, and plain dilution. survey.py holds
// NumPy against it.
#include <cmath>
#include <cstdlib>

#include <benchmark/benchmark.h>

#include "models/simulator/random.h"
#include "survey/map/survey.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

constexpr double kWidth = 100.0, kHeight = 100.0;

std::vector<Eigen::Vector3d> forty() {
  Random draw(40);
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 40; ++i)
    places.emplace_back(draw.uniform(0, kWidth), draw.uniform(0, kHeight), draw.uniform(3, 5));
  return places;
}

/// Forty beacons looking down to all sides within cones, sixty pieces of wall, one receiver.
survey::SurveyModel million_model() {
  Random draw(60);
  survey::SurveyModel model;
  model.receivers = {{"r", {0, 0, 0.3}}};
  model.unknowns = survey::unknowns_of(Motion::kPlanar, Clock::kSynchronised, model.receivers);
  model.noise.constant_m = 0.0034;
  model.noise.per_m = 1e-4;
  model.hearing.range_m = 60;
  BeamPattern cone;
  cone.half_angle_rad = 1.4;
  model.patterns = {cone};
  for (const auto& p : forty()) {
    const double turn = draw.uniform(-3.14, 3.14);
    model.beacons.push_back({"B", p, Eigen::Vector3d(std::cos(turn), std::sin(turn), -0.3).normalized(), 0});
  }
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d from(draw.uniform(0, kWidth), draw.uniform(0, kHeight));
    const double turn = draw.uniform(-3.14, 3.14), length = draw.uniform(3, 12);
    model.walls.push_back(
        {from, from + length * Eigen::Vector2d(std::cos(turn), std::sin(turn)), 0.0, i % 2 ? 2.5 : 6.0});
  }
  model.floor_m = {{0, 0}, {kWidth, 0}, {kWidth, kHeight}, {0, kHeight}};
  model.tolerance.fix_m = 0.05;
  return model;
}

void survey_million(benchmark::State& state, int failures, bool integrity) {
  const auto model = million_model();
  Scene scene;
  scene.cell_m = 0.1;
  for (auto _ : state)
    benchmark::DoNotOptimize(
        must(survey::run_survey(
                 model, scene, nullptr,
                 {.threads = static_cast<int>(state.range(0)), .failures = failures, .integrity = integrity}))
            .covered_fraction);
}
BENCHMARK_CAPTURE(survey_million, maps, 0, false)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(survey_million, integrity, 0, true)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(survey_million, one_failure, 1, true)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(survey_million, two_failures, 2, true)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// A scalar version in plain C++, as compiled without vectors.
void survey_scalar_hdop(benchmark::State& state) {
  const auto places = forty();
  std::vector<double> hdop(1000 * 1000);
  for (auto _ : state) {
    for (std::size_t i = 0; i < hdop.size(); ++i) {
      const double x = 0.1 * (static_cast<double>(i % 1000) + 0.5),
                   y = 0.1 * (static_cast<double>(i / 1000) + 0.5);
      double xx = 0, xy = 0, yy = 0;
      for (const auto& b : places) {
        const double dx = x - b.x(), dy = y - b.y(), dz = 0.3 - b.z(),
                     inverse = 1 / (dx * dx + dy * dy + dz * dz);
        xx += dx * dx * inverse, xy += dx * dy * inverse, yy += dy * dy * inverse;
      }
      hdop[i] = std::sqrt((xx + yy) / (xx * yy - xy * xy));
    }
    benchmark::DoNotOptimize(hdop.data());
  }
}
BENCHMARK(survey_scalar_hdop)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace octant::test
