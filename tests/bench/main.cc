// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant_bench [Google Benchmark's options]
// octant_bench --compare=OTHER [options]   this build and another one (of an earlier commit) turn by turn in
// one run; exit 1
//                                          where one of this build's medians is more than 15 % above the
//                                          other's
#include <cstdio>
#include <string_view>

#include <benchmark/benchmark.h>

#include "tests/bench/compare.h"

int main(int argc, char** argv) {
  constexpr std::string_view kCompare = "--compare=";
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (!word.starts_with(kCompare)) continue;
    octant::bench::Comparison asked;
    asked.now = argv[0];
    asked.base = word.substr(kCompare.size());
    for (int k = 1; k < argc; ++k)
      if (k != i) asked.options.emplace_back(argv[k]);
    return octant::bench::compare(asked);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
