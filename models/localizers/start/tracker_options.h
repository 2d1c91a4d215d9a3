// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Options of the trackers of moving vehicles, smoothed (drive/tracker.h) and at run time
/// (drive/drive_tracker.h).
struct TrackerOptions {
  double rejection_sigmas = 4.0;
  double start_window_s = 2.0;  ///< shortest part of a drive in which the first pose is searched; it grows
                                ///< until the pose is unambiguous
  double max_start_window_s = 120.0;
  double range_uncertainty_m = 0.0;  ///< see EpochFixOptions
  bool protect = false;  ///< compute protection levels. The filter then runs one more filter for each
                         ///< received beacon, and switches to it if that beacon is faulty; smoothing solves
                         ///< the drive once more for each beacon (chain_protection.h, space_track.h)
  bool estimate_speed = false;  ///< estimate the speed in a filter if arrivals state no temperature
  int threads = 1;              ///< threads that work on parts of a drive during smoothing
  bool smooth = true;           ///< use the whole run (fixed-interval smoothing); false: past data only
};

}  // namespace octant
