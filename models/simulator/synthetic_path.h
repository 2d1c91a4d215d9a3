// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "models/physics/pose.h"
#include "models/simulator/random.h"
#include "models/simulator/scenario.h"

namespace octant {

/// Rounds a time to the resolution of clocks in recordings.
[[nodiscard]] inline double to_microsecond(double time_s) { return std::round(time_s * 1e6) / 1e6; }

/// True path of the simulated vehicle: one pose for each epoch, or finely sampled for a drive.
struct TruePath {
  bool moving = false;
  double start_s = 0.0;
  double period_s = 1.0;  ///< time between epochs, or between samples of a drive
  std::vector<Pose> poses;

  /// Pose at a time: that of its epoch, or interpolated between the samples of a drive.
  [[nodiscard]] Pose at(double time_s) const;
  /// Time of the end of a drive.
  [[nodiscard]] double end_s() const { return start_s + period_s * static_cast<double>(poses.size() - 1); }
};

/// Generates the path of a run. Spatial motion adds small tilt and heave to the planar path.
[[nodiscard]] TruePath make_path(const Scenario& scenario, const Scenario::Path& path, Random& draws);

}  // namespace octant
