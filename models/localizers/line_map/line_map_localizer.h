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

/// Corrects odometry by comparison with a line map (Smieszek, section 2: the segments of each scan are
/// compared with the map). An iterated extended Kalman filter for planar motion: odometry predicts the pose
/// from scan to scan (eq. 1), and each segment that matches a wall corrects it perpendicular to that wall and
/// in heading. Directions that no wall determines, such as the one along a corridor, follow odometry, with a
/// covariance that grows accordingly.
///
/// If a scan can be matched in several ways, each of them is tracked until later scans decide. The covariance
/// of a fix is that of the filter plus that of the walls used, whose errors are constant from scan to scan.
/// The frame of the sensor is that of the vehicle. All memory is allocated at construction: a scan of up to a
/// few thousand beams needs no more, once a fix with as many segments has been returned.
class LineMapLocalizer {
 public:
  explicit LineMapLocalizer(LineMap map, LineMapOptions options = {});

  /// Sets the pose of the vehicle, its accuracy, and that of the following odometry.
  void start(const Pose& T_map_vehicle, const PoseAccuracy& start_accuracy,
             const OdometryAccuracy& odometry_accuracy) noexcept;
  /// Moves the vehicle by a fraction (0 to 1) of an odometry row.
  void move(const OdometryStep& step, double fraction = 1.0) noexcept;
  /// Fix at a scan, starting from the pose that `start` and `move` have set. `arrivals_used` is the number of
  /// segments that corrected it, 0 for odometry alone. The status is kAmbiguous while another pose explains
  /// the scans equally well, kNoConsensus if the latest scans disagree with the map, and kPoorGeometry if the
  /// sigma of the position exceeds max_sigma_m or no start was given.
  void locate(const Scan& scan, Fix& fix) noexcept;

  /// One fix for each scan in order, from the start on; earlier scans are ignored.
  /// @param start pose at start.time_s, with its accuracy
  [[nodiscard]] std::vector<Fix> locate(std::span<const Scan> scans, std::span<const OdometryStep> odometry,
                                        const OdometryAccuracy& accuracy, const TimedPose& start,
                                        const PoseAccuracy& start_accuracy);
  /// Locates a run that passes `line_map_fits`, starting at its first measured pose; later poses are not
  /// used.
  [[nodiscard]] std::vector<Fix> locate(const MeasurementLog& log);

  [[nodiscard]] const LineMap& map() const { return map_; }

 private:
  /// A tracked pose with the cost of all scans so far.
  struct Track {
    OdometryState state;
    Eigen::Matrix3d of_map =
        Eigen::Matrix3d::Zero();  ///< covariance of the pose error that the errors of the walls cause
    double cost = 0.0;            ///< minus twice the log likelihood, relative to the best track
  };
  void correct(const Scan& scan, Fix& fix);
  void report(Fix& fix) const;

  LineMap map_;
  LineMapOptions options_;
  OdometryAccuracy odometry_accuracy_;
  std::vector<Track> tracks_;
  std::vector<int> walls_;      ///< all walls of the map, for map_support()
  double on_wall_share_ = 1.0;  ///< share of the latest scans' points at the pose of the best track
  bool first_scan_ = true;
  Scratch scratch_;
};

}  // namespace octant
