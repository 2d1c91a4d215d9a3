// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Reads a long tof.csv, including the digest. tests/bench/reading.py compares it with another reader.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "io/run/run_folder.h"
#include "io/run/run_stream.h"
#include "io/text/atomic_file.h"
#include "models/simulator/random.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

constexpr int kBeacons = 40, kReceivers = 8, kEpochs = 100'000, kArrivalsAnEpoch = 17;

NameTable names() {
  NameTable table{.beacons = {}, .vehicles = {"robot"}, .receivers = {}};
  for (int b = 0; b < kBeacons; ++b) table.beacons.push_back(fmt::format("B{}", b));
  for (int r = 0; r < kReceivers; ++r) table.receivers.push_back({fmt::format("r{}", r), VehicleId(0)});
  return table;
}

/// A month of stops: 1.7 million rows with the digits that loggers write.
std::string long_log() {
  std::string text = "time_s,epoch,beacon,receiver,tof_s\n";
  for (int e = 0; e < kEpochs; ++e) {
    for (int a = 0; a < kArrivalsAnEpoch; ++a) {
      const int mix = (e * 7919 + a * 104729) & 0xFFFFF;
      text += fmt::format("{:.6f},{},B{},r{},{:.8f}\n", 10.0 + 5.0 * e + 0.037 * a, e, mix % kBeacons,
                          mix / 64 % kReceivers, 0.003 + 1e-7 * (mix % 400'000));
    }
  }
  return text;
}

/// The folder OCTANT_BENCH_RUN, created if it is missing, for readers of the same file; otherwise a temporary
/// one.
const std::string& run_folder() {
  struct Folder {
    std::string path;
    bool kept = false;
    ~Folder() {
      std::error_code ignored;
      if (!kept) std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder = [] {
    const char* wanted = std::getenv("OCTANT_BENCH_RUN");
    Folder f{
        wanted != nullptr
            ? wanted
            : (std::filesystem::temp_directory_path() / fmt::format("octant_bench.{}", ::getpid())).string(),
        wanted != nullptr};
    std::filesystem::create_directories(f.path);
    if (!std::filesystem::exists(f.path + "/tof.csv") && !io::write_file(f.path + "/tof.csv", long_log()))
      throw std::runtime_error("cannot write " + f.path);
    return f;
  }();
  return folder.path;
}

void count_bytes(benchmark::State& state) {
  state.SetBytesProcessed(
      static_cast<std::int64_t>(state.iterations() * std::filesystem::file_size(run_folder() + "/tof.csv")));
}

void read_whole(benchmark::State& state) {
  const NameTable table = names();
  (void)run_folder();
  for (auto _ : state) {
    auto log = must(io::read_run(run_folder(), table, {}, {.threads = static_cast<int>(state.range(0))}));
    benchmark::DoNotOptimize(log.arrivals.data());
    state.PauseTiming();
    log = {};
    state.ResumeTiming();
  }
  count_bytes(state);
}

void read_blocks(benchmark::State& state) {
  const NameTable table = names();
  std::vector<Arrival> block;
  (void)run_folder();
  for (auto _ : state) {
    auto stream =
        must(io::RunStream::open(run_folder(), table, {}, {.threads = static_cast<int>(state.range(0))}));
    while (must(stream.next(block))) benchmark::DoNotOptimize(block.data());
  }
  count_bytes(state);
}

BENCHMARK(read_whole)
    ->Name("read/whole/threads")
    ->RangeMultiplier(2)
    ->Range(1, 8)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(read_blocks)
    ->Name("read/blocks/threads")
    ->RangeMultiplier(2)
    ->Range(1, 8)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace octant::test
