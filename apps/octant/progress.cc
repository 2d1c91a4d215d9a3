// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

namespace octant::app {
namespace {

/// Write errors are ignored: missing progress output is no reason to stop.
void put_progress(const std::string& text) { (void)std::fwrite(text.data(), 1, text.size(), stderr); }

}  // namespace

ProgressStyle progress_style(std::string_view wanted, bool quiet) {
  if (wanted == "none") return ProgressStyle::kNone;
  if (wanted == "json") return ProgressStyle::kJson;
  if (wanted == "plain") return ProgressStyle::kPlain;
  if (quiet) return ProgressStyle::kNone;
  const char* term = std::getenv("TERM");
  const bool can_draw = isatty(STDERR_FILENO) == 1 && term != nullptr && std::string_view(term) != "dumb";
  return can_draw ? ProgressStyle::kBar : ProgressStyle::kPlain;
}

bool ProgressReporter::due(bool new_stage) {
  // Iterations of small problems take microseconds; ten updates per second are enough.
  const auto now = std::chrono::steady_clock::now();
  if (!new_stage && now - last_ < std::chrono::milliseconds(100)) return false;
  last_ = now;
  return true;
}

void ProgressReporter::show(const std::string& stage, int iteration, double cost, double fraction) {
  if (style_ == ProgressStyle::kNone) return;
  const bool new_stage = stage != stage_;
  stage_ = stage;
  fraction = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  if (style_ == ProgressStyle::kJson) return show_json(iteration, cost, fraction, new_stage);
  if (!due(new_stage)) return;
  if (style_ == ProgressStyle::kBar) {
    const int full = static_cast<int>(std::lround(24 * fraction));
    put_progress(
        fmt::format("\r\033[K[{:#<{}}{:.<{}}] {:3.0f} % {}", "", full, "", 24 - full, 100 * fraction, stage));
    drawn_ = true;
  } else if (new_stage) {
    put_progress(fmt::format("{:3.0f} % {}\n", 100 * fraction, stage));
  }
  std::fflush(stderr);
}

void ProgressReporter::show_json(int iteration, double cost, double fraction, bool new_stage) {
  using ProgressLine = nlohmann::ordered_json;
  constexpr double kDigits = 1e4;  // rounds the fraction: 0.3 instead of 0.30000000000000004
  const bool made = iteration > 0 || cost != 0.0;
  const ProgressLine line = {
      {"stage", stage_},
      {"iteration", iteration},
      {"cost", made && std::isfinite(cost) ? ProgressLine(cost) : ProgressLine(nullptr)},
      {"fraction", std::round(kDigits * fraction) / kDigits}};
  std::string text = line.dump(-1, ' ', false, ProgressLine::error_handler_t::replace) + "\n";
  if (new_stage && !pending_.empty()) put_progress(pending_);  // final step of the previous stage
  pending_.clear();
  if (due(new_stage))
    put_progress(text);
  else
    pending_ = std::move(text);
  std::fflush(stderr);
}

void ProgressReporter::finish() {
  if (drawn_) put_progress(fmt::format("\r\033[K"));
  drawn_ = false;
  if (!pending_.empty()) put_progress(pending_);
  pending_.clear();
}

}  // namespace octant::app
