// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace octant::app {

enum class ProgressStyle { kNone, kBar, kPlain, kJson };

/// What --progress, --quiet and the terminal come to: "auto" is a bar on a terminal and plain lines
/// elsewhere.
[[nodiscard]] ProgressStyle progress_style(std::string_view wanted, bool quiet);

/// Shows on standard error how far a computation is: a bar that is drawn over, a line for each new stage, or
/// JSON lines.
class ProgressReporter {
 public:
  explicit ProgressReporter(ProgressStyle style) : style_(style) {}
  ~ProgressReporter() { finish(); }
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;

  /// As JSON the first and the last step of each stage are shown, and between them ten a second; cost is null
  /// where no step was made yet.
  /// @param fraction  0..1 of the whole
  void show(const std::string& stage, int iteration, double cost, double fraction);
  /// Clears the bar. Called before other talk.
  void finish();

 private:
  [[nodiscard]] bool due(bool new_stage);
  void show_json(int iteration, double cost, double fraction, bool new_stage);

  ProgressStyle style_;
  std::string stage_;
  std::string pending_;  ///< JSON of the last step that was not shown
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace octant::app
