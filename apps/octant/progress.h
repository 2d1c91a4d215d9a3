// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace octant::app {

enum class ProgressStyle { kNone, kBar, kPlain, kJson };

/// Style that results from --progress, --quiet and the terminal: "auto" is a bar on a terminal and plain
/// lines elsewhere.
[[nodiscard]] ProgressStyle progress_style(std::string_view wanted, bool quiet);

/// Shows the progress of a computation on standard error: a bar, one line for each stage, or JSON lines.
class ProgressReporter {
 public:
  explicit ProgressReporter(ProgressStyle style) : style_(style) {}
  ~ProgressReporter() { finish(); }
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;

  /// In JSON style the first and last step of each stage are shown, and at most ten steps per second between
  /// them. The cost is null before the first step.
  /// @param fraction  completed share of the whole, 0 to 1
  void show(const std::string& stage, int iteration, double cost, double fraction);
  /// Clears the bar. Call it before other output.
  void finish();

 private:
  [[nodiscard]] bool due(bool new_stage);
  void show_json(int iteration, double cost, double fraction, bool new_stage);

  ProgressStyle style_;
  std::string stage_;
  std::string pending_;  ///< JSON of the latest step, not shown yet
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace octant::app
