// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/compare.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace octant::bench {
namespace {

constexpr int kTurns = 5;
constexpr double kSlower = 1.15;

/// Seconds of the processor by benchmark.
using Times = std::map<std::string, std::vector<double>>;

std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::optional<std::string> output_of(const std::string& command) {
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return std::nullopt;
  std::string out;
  std::array<char, 4096> part;
  while (const std::size_t count = fread(part.data(), 1, part.size(), pipe)) out.append(part.data(), count);
  return pclose(pipe) == 0 ? std::optional(out) : std::nullopt;
}

/// Runs one program, and adds its times.
bool run(const std::string& program, const std::vector<std::string>& options, Times& times) {
  std::string command = quoted(program);
  for (const std::string& option : options) command += " " + quoted(option);
  const auto text = output_of(command + " --benchmark_format=json");
  if (!text) return false;
  const auto report = nlohmann::json::parse(*text, nullptr, false);
  if (report.is_discarded()) return false;
  const std::map<std::string, double> seconds = {{"ns", 1e-9}, {"us", 1e-6}, {"ms", 1e-3}, {"s", 1.0}};
  for (const auto& b : report.at("benchmarks"))
    if (b.value("run_type", "") == "iteration" && !b.value("error_occurred", false))
      times[b.at("name")].push_back(b.at("cpu_time").get<double>() * seconds.at(b.at("time_unit")));
  return true;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

}  // namespace

int compare(const Comparison& asked) {
  Times now, base;
  for (int turn = 0; turn < kTurns; ++turn)
    for (const auto& [program, times] : {std::pair(asked.base, &base), std::pair(asked.now, &now)})
      if (!run(program, asked.options, *times)) {
        fmt::print(stderr, "error: {} does not run with these options\n", program);
        return 2;
      }
  int slower = 0, compared = 0;
  fmt::print("{:50s} {:>12s} {:>12s} {:>7s}\n", "benchmark", "before [s]", "now [s]", "ratio");
  for (const auto& [name, times] : now) {
    const auto before = base.find(name);
    if (before == base.end()) continue;
    const double a = median(before->second), b = median(times);
    const bool is_slower = b > kSlower * a;
    fmt::print("{:50s} {:12.4g} {:12.4g} {:7.3f}{}\n", name, a, b, b / a, is_slower ? "  SLOWER" : "");
    ++compared;
    slower += is_slower;
  }
  fmt::print("{} benchmarks, {} slower by more than 15 %\n", compared, slower);
  if (compared == 0) {
    fmt::print(stderr, "error: the two programs have no benchmark of one name\n");
    return 2;
  }
  return slower > 0 ? 1 : 0;
}

}  // namespace octant::bench
