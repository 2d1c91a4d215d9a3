// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace octant::calib {

/// Something about a log or a site that a person should look at.
struct Finding {
  std::string
      kind;  ///< for machines: "silent_beacon", "unit", "two_way", "receiver_label", "clock_step", "gap", ...
  std::string text;  ///< for people, one sentence
};

/// All times jump by the same amount between two instants.
struct ClockStep {
  double time_s = 0.0;  ///< the first instant after it
  double step_s = 0.0;  ///< by which later times of flight are longer
  std::size_t beacons = 0;
};

}  // namespace octant::calib
