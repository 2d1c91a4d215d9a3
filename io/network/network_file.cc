// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/network/network_file.h"

#include <algorithm>
#include <numbers>

namespace octant::io {

void set_axes(NetworkFile& file, const std::string& axes, bool clockwise) {
  const bool right_handed = std::ranges::find(kSurveyAxes, axes) - kSurveyAxes.begin() < 4;
  file.axes = axes;
  file.clockwise = clockwise;
  file.angle_sign = right_handed == clockwise ? -1.0 : 1.0;
  file.north_rad = axes[0] == 'n'   ? 0.0
                   : axes[0] == 's' ? std::numbers::pi
                   : axes[1] == 'n' ? 0.5 * std::numbers::pi
                                    : -0.5 * std::numbers::pi;
}

}  // namespace octant::io
