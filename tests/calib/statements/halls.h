// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "tests/calib/calib_support.h"

namespace octant::test {

inline Scenario sixty_stops() {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  return s;
}

inline std::string all_in_words(const calib::Solution& solution) {
  std::string text;
  for (const Contradiction& c : solution.contradictions) text += in_words(c) + "\n";
  return text;
}

/// Arrivals of one world, and from some time on those of another one for which `other` holds.
template <class Other>
void take_over(const World& later, Other&& other, World& world) {
  std::map<std::pair<double, std::pair<std::size_t, std::size_t>>, double> times;
  for (const Arrival& a : later.run.arrivals)
    times[{std::round(a.time_s * 10), {a.beacon.index(), a.receiver.index()}}] = a.tof_s;
  for (Arrival& a : world.run.arrivals) {
    const auto found = times.find({std::round(a.time_s * 10), {a.beacon.index(), a.receiver.index()}});
    if (other(a) && found != times.end()) a.tof_s = found->second;
  }
}

}  // namespace octant::test
