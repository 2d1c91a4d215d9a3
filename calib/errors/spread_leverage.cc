// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/spread_leverage.h"

#include <algorithm>

#include "models/support/parallel.h"
#include "models/trajectory/stretches.h"

namespace octant::calib {
namespace {

std::vector<SweptRow> joined(const std::vector<std::vector<SweptRow>>& parts) {
  std::vector<SweptRow> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace

SweptRow swept_row(const RowLeverage& l) {
  return {l.row.kind, l.row.index, l.row.residual, l.leverage, l.shift_m};
}

bool has_long_chain(const Trajectory& t) { return t.segments.size() == 1 && is_long_chain(t.segments[0]); }

std::vector<SweptRow> sweep_spread_stops(const LeverageSweep& of_all, const Trajectory& t,
                                         const SharedState& state, std::size_t stride, int threads) {
  const std::size_t stretch = 256 * stride;
  std::vector<std::vector<SweptRow>> rows(chunk_count(t.segments.size(), stretch));
  for_each_chunk(t.segments.size(), stretch, threads,
                 [&](std::size_t chunk, std::size_t first, std::size_t last) {
                   LeverageSweep sweep = of_all;
                   sweep.sweep(t, state, first, last, stride,
                               [&](const RowLeverage& l) { rows[chunk].push_back(swept_row(l)); });
                 });
  return joined(rows);
}

std::vector<SweptRow> sweep_spread_stretches(const LeverageSweep& of_all, const Trajectory& t,
                                             const SharedState& state, std::size_t stride, int threads) {
  constexpr std::size_t kMarginArrivals = 150, kLeastMargin = 48;
  const Segment& whole = t.segments[0];
  const std::size_t margin =
      std::max(kLeastMargin, kMarginArrivals * t.nodes.size() / std::max<std::size_t>(t.arrivals.size(), 1));
  const std::size_t pitch = kStretchNodes * stride, count = chunk_count(t.nodes.size(), pitch);
  std::vector<std::vector<SweptRow>> rows(count);
  for_each_parallel(count, threads, [&](std::size_t i) {
    const std::size_t first = whole.first_node + i * pitch;
    const std::size_t last = std::min(whole.last_node, first + kStretchNodes);
    const std::size_t from = first - std::min(first - whole.first_node, margin);
    Trajectory some =
        pick_segments(t, {stretch_of(t, whole, from, std::min(whole.last_node, last + margin))});
    LeverageSweep sweep = of_all;
    const std::size_t first_arrival = first_of_node(t.arrivals, from, 0, t.arrivals.size()),
                      first_bearing = first_of_node(t.bearings, from, 0, t.bearings.size());
    sweep.sweep(some, state, 0, 1, 1, [&](const RowLeverage& l) {
      if (const std::size_t node = l.row.node + from; node < first || node >= last) return;
      SweptRow row = swept_row(l);
      if (row.kind == RowKind::kTof || row.kind == RowKind::kAmplitude) row.index += first_arrival;
      if (row.kind == RowKind::kBearing) row.index += first_bearing;
      rows[i].push_back(row);
    });
  });
  return joined(rows);
}

}  // namespace octant::calib
