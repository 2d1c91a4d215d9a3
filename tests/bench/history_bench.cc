// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A history of ten thousand calibrations: opened and listed, and one more added.
#include <filesystem>
#include <stdexcept>

#include <benchmark/benchmark.h>

#include "io/deployment/deployment_json.h"
#include "io/history/history.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

io::Visit visit_number(int number) {
  static const io::Visit kHall = [] {
    Scenario s = hall_scenario();
    s.path.epochs = s.heldout_path.epochs = 1;
    Deployment d = must(simulate(s, 1)).truth;
    d.created = "2026-01-01T00:00:00Z";
    return must(io::visit_of(io::deployment_to_json(d), "deployment.json"));
  }();
  io::Visit visit = kHall;
  visit.digest += std::to_string(number);
  visit.happened_s += 3600LL * number;
  return visit;
}

/// Ten thousand visits to the hall in a file of its own, made once.
const std::string& ten_thousand() {
  static const std::string kPath = [] {
    const std::string path = (std::filesystem::temp_directory_path() / "octant_bench_history.db").string();
    for (const char* ending : {"", "-wal", "-shm"}) std::filesystem::remove(path + ending);
    std::vector<io::Visit> visits;
    for (int i = 0; i < 10'000; ++i) visits.push_back(visit_number(i));
    auto history = must(io::History::open(path, true));
    (void)must(history.add(visits));
    return path;
  }();
  return kPath;
}

void history_list(benchmark::State& state) {
  const std::string& path = ten_thousand();
  for (auto _ : state) {
    auto history = must(io::History::open(path, false));
    if (must(history.list()).size() < 10'000) throw std::runtime_error("visits are missing");
  }
}
BENCHMARK(history_list)->Unit(benchmark::kMillisecond);

void history_calibrations(benchmark::State& state) {
  const std::string& path = ten_thousand();
  for (auto _ : state) {
    auto history = must(io::History::open(path, false));
    benchmark::DoNotOptimize(must(history.calibrations("hall")));
  }
}
BENCHMARK(history_calibrations)->Unit(benchmark::kMillisecond);

void history_add(benchmark::State& state) {
  auto history = must(io::History::open(ten_thousand(), false));
  int number = 1'000'000;
  for (auto _ : state) (void)must(history.add({visit_number(++number)}));
}
BENCHMARK(history_add)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace octant::test
