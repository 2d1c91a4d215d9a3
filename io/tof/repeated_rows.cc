// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/repeated_rows.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace octant::io {
namespace {

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Returns true for one measurement, even if it was received twice.
bool same_measurement(const Arrival& a, const Arrival& b) {
  return a.tof_s == b.tof_s && a.time_s == b.time_s && a.beacon == b.beacon && a.receiver == b.receiver &&
         a.vehicle == b.vehicle && a.epoch == b.epoch && same(a.amplitude_v, b.amplitude_v) &&
         same(a.temperature_degC, b.temperature_degC);
}

constexpr std::size_t kFew = 32;  ///< rows of one time that are simply compared one by one

/// Order in which repeated rows are neighbours; amplitudes and temperatures are compared afterwards.
bool comes_before(const Arrival& a, const Arrival& b) {
  return std::tuple(a.tof_s, a.beacon, a.receiver, a.vehicle, a.epoch) <
         std::tuple(b.tof_s, b.beacon, b.receiver, b.vehicle, b.epoch);
}

}  // namespace

std::vector<int> RepeatedRows::drop(std::vector<Arrival>& all, std::size_t first) {
  std::vector<int> lines;
  std::size_t kept = first;     // end of what stays
  std::size_t of_time = first;  // where the rows of the present time begin among what stays
  std::multiset<Arrival, decltype(&comes_before)> many(
      &comes_before);  // the same rows, where there are many of one time
  const auto repeats = [&](const Arrival& a) {
    const auto is_it = [&a](const Arrival& b) { return same_measurement(a, b); };
    if (std::ranges::any_of(latest_, is_it)) return true;
    if (kept - of_time <= kFew)
      return std::any_of(all.begin() + static_cast<std::ptrdiff_t>(of_time),
                         all.begin() + static_cast<std::ptrdiff_t>(kept), is_it);
    if (many.empty())
      many.insert(all.begin() + static_cast<std::ptrdiff_t>(of_time),
                  all.begin() + static_cast<std::ptrdiff_t>(kept));
    const auto [low, high] = many.equal_range(a);
    return std::any_of(low, high, is_it);
  };
  for (std::size_t i = first; i < all.size(); ++i) {
    const Arrival& a = all[i];
    if (kept > of_time && all[kept - 1].time_s != a.time_s) {
      of_time = kept;
      many.clear();
    }
    if (!latest_.empty() && latest_.front().time_s != a.time_s) latest_.clear();
    if (repeats(a)) {
      lines.push_back(a.line);
      continue;
    }
    if (!many.empty()) many.insert(a);
    if (kept != i) all[kept] = a;
    ++kept;
  }
  all.resize(kept);
  latest_.insert(latest_.end(), all.begin() + static_cast<std::ptrdiff_t>(of_time), all.end());
  return lines;
}

}  // namespace octant::io
