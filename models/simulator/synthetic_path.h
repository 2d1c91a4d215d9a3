// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "models/physics/pose.h"
#include "models/simulator/random.h"
#include "models/simulator/scenario.h"

namespace octant {

/// As clocks of recordings tell it.
[[nodiscard]] inline double to_microsecond(double time_s) { return std::round(time_s * 1e6) / 1e6; }

/// Where the simulated vehicle truly is: at rest, one pose an epoch, or under way, sampled finely.
struct TruePath {
  bool moving = false;
  double start_s = 0.0;
  double period_s = 1.0;  ///< from one epoch, or one sample of a drive, to the next
  std::vector<Pose> poses;

  /// Pose at a time: that of its epoch, or between the samples of a drive.
  [[nodiscard]] Pose at(double time_s) const;
  /// End of a drive.
  [[nodiscard]] double end_s() const { return start_s + period_s * static_cast<double>(poses.size() - 1); }
};

/// The path of a run. Spatial motion adds a little tilt and heave to the planar one.
[[nodiscard]] TruePath make_path(const Scenario& scenario, const Scenario::Path& path, Random& draws);

}  // namespace octant
