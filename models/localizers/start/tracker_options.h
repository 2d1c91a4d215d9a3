// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Options of the trackers of moving vehicles, smoothed (drive/tracker.h) and at run time
/// (drive/drive_tracker.h).
struct TrackerOptions {
  double rejection_sigmas = 4.0;
  double start_window_s =
      2.0;  ///< shortest stretch from which the first pose is searched; grows until it is unambiguous
  double max_start_window_s = 120.0;
  double range_uncertainty_m = 0.0;  ///< as in EpochFixOptions
  bool protect = false;  ///< protection levels. Of a filter: as many filters more as beacons are heard, and
                         ///< one whose beacon is at fault takes over; of a smoothed drive: as many solutions
                         ///< more (chain_protection.h; space_track.h)
  bool estimate_speed = false;  ///< of a filter: the speed is unknown where arrivals state no temperature
  int threads = 1;              ///< on stretches of a drive that is smoothed
  bool smooth = true;  ///< use the whole run (fixed-interval smoothing); false: only what came before
};

}  // namespace octant
