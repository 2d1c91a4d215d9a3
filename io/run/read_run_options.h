// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant::io {

struct ReadRunOptions {
  bool read_truth = false;  ///< open truth.tum; only verify does
  bool read_poses = true;   ///< open poses.tum
  /// Speed of a medium with constant speed [m/s]; a column distance_m may then replace tof_s. 0: it may not.
  double constant_speed_mps = 0.0;
  int threads = 1;  ///< threads that read tof.csv; the result does not depend on their number
};

}  // namespace octant::io
