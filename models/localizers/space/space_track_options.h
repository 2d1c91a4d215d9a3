// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

struct SpaceTrackOptions {
  double rejection_sigmas = 4.0;
  double max_gap_s = 5.0;        ///< without arrivals, after which the place is searched anew
  double speed_sigma_mps = 3.0;  ///< of each component, before anything is heard
  bool protect = false;  ///< protection levels, at the cost of a filter and a smoother more for each beacon
};

}  // namespace octant
