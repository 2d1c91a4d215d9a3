// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "models/ids.h"

namespace octant {

/// Time within which the arrivals of a ping come. Receivers of a vehicle are a few metres apart at most.
inline constexpr double kPing_s = 0.02;

/// The arrivals of one beacon within some milliseconds. They may share an echo.
struct Ping {
  BeaconId beacon;
  double begin_s = 0.0;
  [[nodiscard]] bool includes(BeaconId other, double time_s) const {
    return other == beacon && std::abs(time_s - begin_s) <= kPing_s;
  }
};

}  // namespace octant
