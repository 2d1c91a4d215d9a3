// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/localizers/drive/odometry_track.h"
#include "models/localizers/line_map/line_map.h"
#include "models/localizers/line_map/scan_lines.h"
#include "models/run.h"
#include "models/support/scratch.h"

namespace octant {

/// Correction of odometry against a stored line map (Smieszek, section 2: segments of each scan compared with
/// the map). An iterated extended Kalman filter: odometry carries the pose from scan to scan (eq. 1); each
/// segment of a scan that is a wall of the map corrects it square to that wall and in heading. What no wall
/// tells, the way along a corridor above all, stays with odometry, and its covariance says so. Where a scan
/// may be matched in several ways, each is followed until later scans decide. The covariance of a fix is the
/// filter's and, besides, that of the walls it was corrected by, whose error stays the same from scan to
/// scan. The sensor's frame is the vehicle's. Planar. All memory is taken at construction: a scan of up to a
/// few thousand beams is located without more, once the fix has held one of as many segments.
class LineMapLocalizer {
 public:
  explicit LineMapLocalizer(LineMap map, LineMapOptions options = {});

  /// The vehicle is at this pose; accuracy of it and of the odometry that follows.
  void start(const Pose& T_map_vehicle, const PoseAccuracy& start_accuracy,
             const OdometryAccuracy& odometry_accuracy) noexcept;
  /// The vehicle moved by a fraction (0 to 1) of an odometry row.
  void move(const OdometryStep& step, double fraction = 1.0) noexcept;
  /// Fix at a scan, from where `start` and `move` have brought the vehicle. `arrivals_used` is the number of
  /// segments that corrected it, 0 for odometry alone; kAmbiguous while another pose explains the scans as
  /// well, kNoConsensus where the latest scans show something else than the map, kPoorGeometry where the
  /// position's sigma is beyond max_sigma_m or nothing was said of the start.
  void locate(const Scan& scan, Fix& fix) noexcept;

  /// One fix a scan, in order, from the start on (scans before it are left out).
  /// @param start at start.time_s, with its accuracy
  [[nodiscard]] std::vector<Fix> locate(std::span<const Scan> scans, std::span<const OdometryStep> odometry,
                                        const OdometryAccuracy& accuracy, const TimedPose& start,
                                        const PoseAccuracy& start_accuracy);
  /// The same for a run that `line_map_fits`, from its first measured pose; later ones are not looked at.
  [[nodiscard]] std::vector<Fix> locate(const MeasurementLog& log);

  [[nodiscard]] const LineMap& map() const { return map_; }

 private:
  /// A pose that is followed, and how far it is from explaining all scans so far.
  struct Track {
    OdometryState state;
    Eigen::Matrix3d of_map =
        Eigen::Matrix3d::Zero();  ///< covariance of what the walls' own errors put the pose off
    double cost = 0.0;            ///< minus twice the log likelihood, less the best track's
  };
  void correct(const Scan& scan, Fix& fix);
  void report(Fix& fix) const;

  LineMap map_;
  LineMapOptions options_;
  OdometryAccuracy odometry_accuracy_;
  std::vector<Track> tracks_;
  std::vector<int> walls_;      ///< all of the map, for map_support()
  double on_wall_share_ = 1.0;  ///< of the latest scans' points at the best track's pose
  bool first_scan_ = true;
  Scratch scratch_;
};

}  // namespace octant
