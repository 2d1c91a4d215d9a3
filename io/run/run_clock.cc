// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_clock.h"

#include <algorithm>

#include <fmt/format.h>

#include "io/text/text.h"

namespace octant::io {
namespace {

/// Moves the rows before `split_s` by a period, and behind the others.
template <class Row>
void move_first_half(std::vector<Row>& rows, double split_s, double period_s) {
  for (Row& row : rows)
    if (row.time_s < split_s) row.time_s += period_s;
  std::ranges::stable_sort(rows, {}, &Row::time_s);
}

struct LongestGaps {
  std::size_t behind = 0;  ///< row after the longest gap
  double longest_s = 0.0, second_s = 0.0;
};

LongestGaps longest_gaps(const std::vector<Arrival>& arrivals) {
  LongestGaps gaps;
  for (std::size_t i = 1; i < arrivals.size(); ++i) {
    const double gap_s = arrivals[i].time_s - arrivals[i - 1].time_s;
    gaps.second_s = std::max(gaps.second_s, std::min(gap_s, gaps.longest_s));
    if (gap_s <= gaps.longest_s) continue;
    gaps.longest_s = gap_s;
    gaps.behind = i;
  }
  return gaps;
}

}  // namespace

void restore_sorted_restart(MeasurementLog& log, const std::string& file) {
  if (log.arrivals.empty()) return;
  const double first_s = log.arrivals.front().time_s, last_s = log.arrivals.back().time_s;
  const auto clock = restarted_clock(last_s, first_s);
  if (!clock) return;
  const LongestGaps gaps = longest_gaps(log.arrivals);
  const double across_s = first_s + clock->period_s - last_s;
  const bool continuous = gaps.second_s <= kLongestGapOfPeriod * clock->period_s;
  if (gaps.longest_s < 0.5 * clock->period_s || !continuous || across_s > 2.0 * gaps.second_s) return;
  const Arrival& before = log.arrivals[gaps.behind - 1];
  const Arrival& after = log.arrivals[gaps.behind];
  log.warnings.push_back(
      fmt::format("{}:{}: the time jumps from {} to {}, and goes on from the last row to the first one where "
                  "{} starts again: "
                  "the rows were sorted after they had been recorded. The {} rows before the jump are used "
                  "as the later ones, "
                  "by adding {} s",
                  file, after.line, exact(before.time_s), exact(after.time_s), clock->kind, gaps.behind,
                  exact(clock->period_s)));
  const double split_s = after.time_s;
  move_first_half(log.arrivals, split_s, clock->period_s);
  move_first_half(log.bearings, split_s, clock->period_s);
  move_first_half(log.scans, split_s, clock->period_s);
  move_first_half(log.odometry, split_s, clock->period_s);
  move_first_half(log.poses, split_s, clock->period_s);
  move_first_half(log.truth, split_s, clock->period_s);
}

}  // namespace octant::io
