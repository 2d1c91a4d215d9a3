// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

struct SpaceTrackOptions {
  double rejection_sigmas = 4.0;
  double max_gap_s = 5.0;        ///< longest time without arrivals; afterwards the position is searched again
  double speed_sigma_mps = 3.0;  ///< initial sigma of each component of the velocity
  bool protect =
      false;  ///< compute protection levels, at the cost of an additional filter and smoother for each beacon
};

}  // namespace octant
