// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/state_bearings.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace octant::calib {

StateBearings::StateBearings(const std::vector<Bearing>& bearings, std::vector<StateKind> kinds)
    : bearings_(bearings), kinds_(std::move(kinds)) {
  for (std::size_t i = 0; i < bearings.size(); ++i)
    if (kinds_[bearings[i].vehicle.index()] == StateKind::kStops)
      rows_.emplace_back(bearings[i].vehicle, bearings[i].epoch, i);
  std::ranges::sort(rows_);
}

std::vector<std::size_t> StateBearings::of_states_in(const std::vector<Arrival>& arrivals) const {
  std::vector<std::size_t> numbers;
  if (bearings_.empty()) return numbers;
  const Arrival* before = nullptr;  // rows of an epoch mostly follow each other
  for (const Arrival& a : arrivals) {
    if (before != nullptr && a.vehicle == before->vehicle && a.epoch == before->epoch) continue;
    before = &a;
    for (auto row = std::ranges::lower_bound(rows_, Row(a.vehicle, a.epoch, 0));
         row != rows_.end() && std::get<0>(*row) == a.vehicle && std::get<1>(*row) == a.epoch; ++row)
      numbers.push_back(std::get<2>(*row));
  }
  for (std::size_t v = 0; v < kinds_.size(); ++v)
    if (kinds_[v] != StateKind::kStops) add_near(VehicleId(v), arrivals, numbers);
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

/// Bearings within the time of a vehicle's arrivals, or all if its states are one chain.
void StateBearings::add_near(VehicleId vehicle, const std::vector<Arrival>& arrivals,
                             std::vector<std::size_t>& numbers) const {
  double from_s = INFINITY, until_s = -INFINITY;
  for (const Arrival& a : arrivals) {
    if (a.vehicle != vehicle) continue;
    from_s = std::min(from_s, a.time_s - kNearInstant_s);
    until_s = std::max(until_s, a.time_s + kNearInstant_s);
  }
  if (from_s > until_s) return;
  if (kinds_[vehicle.index()] == StateKind::kChainedStops) from_s = -INFINITY, until_s = INFINITY;
  const auto first = std::ranges::lower_bound(bearings_, from_s, {}, &Bearing::time_s);
  for (auto b = first; b != bearings_.end() && b->time_s <= until_s; ++b)
    if (b->vehicle == vehicle) numbers.push_back(static_cast<std::size_t>(b - bearings_.begin()));
}

}  // namespace octant::calib
