// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/stops/epoch_bearings.h"

#include <algorithm>

namespace octant::calib {

EpochBearings::EpochBearings(const std::vector<Bearing>& bearings) {
  rows_.reserve(bearings.size());
  for (std::size_t i = 0; i < bearings.size(); ++i)
    rows_.emplace_back(bearings[i].vehicle, bearings[i].epoch, i);
  std::sort(rows_.begin(), rows_.end());
}

std::vector<std::size_t> EpochBearings::of_epochs_in(const std::vector<Arrival>& arrivals) const {
  std::vector<std::size_t> numbers;
  if (rows_.empty()) return numbers;
  const Arrival* before = nullptr;  // rows of an epoch mostly follow each other
  for (const Arrival& a : arrivals) {
    if (before != nullptr && a.vehicle == before->vehicle && a.epoch == before->epoch) continue;
    before = &a;
    for (auto row = std::lower_bound(rows_.begin(), rows_.end(), Row(a.vehicle, a.epoch, 0));
         row != rows_.end() && std::get<0>(*row) == a.vehicle && std::get<1>(*row) == a.epoch; ++row)
      numbers.push_back(std::get<2>(*row));
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

}  // namespace octant::calib
