// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/range_gates.h"

#include <cmath>

namespace octant {
namespace {

/// Distance of the later of two signals behind the earlier one; infinite if it cannot be an echo of it.
double distance_behind_m(const GatedArrival& earlier, const GatedArrival& later, double speed_mps) {
  if (later.heard_s > earlier.heard_s) return speed_mps * (later.heard_s - earlier.heard_s);
  const double behind_m = later.range_m - earlier.range_m;
  return behind_m > 0 ? behind_m : std::numeric_limits<double>::infinity();
}

}  // namespace

void reject_out_of_range(std::span<const GatedArrival> arrivals, const RangeGates& gates,
                         std::span<Rejection> rejections) {
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    if (rejections[i] != Rejection::kUsed) continue;
    if (!(arrivals[i].range_m >= gates.min_m && arrivals[i].range_m <= gates.max_m))
      rejections[i] = Rejection::kOutOfRange;
  }
}

void reject_reflections(std::span<const GatedArrival> arrivals, double min_m, double speed_mps,
                        std::span<Rejection> rejections) {
  if (!(min_m > 0)) return;
  const auto same_path = [](const GatedArrival& a, const GatedArrival& b) {
    return a.beacon == b.beacon && a.receiver == b.receiver;
  };
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    if (rejections[i] != Rejection::kUsed) continue;
    const GatedArrival& later = arrivals[i];
    const auto is_echo_of = [&](std::size_t j) {
      const bool counts = rejections[j] == Rejection::kUsed || rejections[j] == Rejection::kReflection;
      return counts && same_path(arrivals[j], later) &&
             distance_behind_m(arrivals[j], later, speed_mps) < min_m;
    };
    bool echo = false;
    for (std::size_t j = i; j-- > 0 && !echo && speed_mps * (later.heard_s - arrivals[j].heard_s) < min_m;)
      echo = is_echo_of(j);
    // Rows with equal times are unordered, so the earlier signal may come later in the list.
    for (std::size_t j = i + 1; j < arrivals.size() && !echo && arrivals[j].heard_s == later.heard_s; ++j)
      echo = is_echo_of(j);
    if (echo) rejections[i] = Rejection::kReflection;
  }
}

void apply_range_gates(std::span<const GatedArrival> arrivals, const RangeGates& gates, double speed_mps,
                       std::span<Rejection> rejections) {
  reject_out_of_range(arrivals, gates, rejections);
  reject_reflections(arrivals, gates.min_m, speed_mps, rejections);
}

}  // namespace octant
