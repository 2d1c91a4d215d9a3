// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/drive/beacon_bank.h"
#include "models/localizers/drive/chain_calibration.h"
#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/drive/tracker.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/run.h"
#include "models/support/scratch.h"

namespace octant {

/// The tracker as a robot runs it: `move` by each odometry row, `locate` at each instant of arrivals, one
/// vehicle, planar, no cycle offset. Where it was is not asked: until the arrivals of the last stretch of the
/// drive settle one pose (as `find_start` does), and again when most arrivals contradict it, there is no fix;
/// a search is tried whenever the stretch has grown by a third. With a place it is an iterated extended
/// Kalman filter (`DriveFilter`). All memory is taken at construction. A fix takes microseconds; a search
/// some tens of milliseconds.
class DriveTracker final : public Localizer {
 public:
  DriveTracker(const Deployment& deployment, const OdometryAccuracy& odometry,
               const TrackerOptions& options = {});

  /// The vehicle is here; covariance of x, y [m], heading [rad].
  void start(const Pose& T_map_vehicle, const Eigen::Matrix3d& covariance) noexcept;
  /// The vehicle moved by a fraction (0 to 1) of an odometry row; rows up to the instant of the next
  /// arrivals.
  void move(const OdometryStep& step, double fraction = 1.0) noexcept;
  /// Whether the place is known, and by all that came so far which it is: before `locate` the prediction.
  [[nodiscard]] bool is_placed() const { return placed_; }
  [[nodiscard]] Pose pose() const { return filter_.pose(); }
  [[nodiscard]] PoseCovariance covariance() const { return filter_.covariance(); }

 private:
  /// Fix at the arrivals' instant, which is that of the last move: kOk, or kNoConsensus while the place is
  /// not known.
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  void begin_window(double time_s);
  void keep_recent_half();
  void observe_all(std::span<const Arrival> arrivals);
  /// Tries to find the place from the window, if it is time to.
  void search();
  [[nodiscard]] Segment window() const;

  EpochFixModel model_;
  CalibrationPart calibration_;
  TrackerOptions options_;
  OdometryAccuracy odometry_;
  TrajectoryModel trajectory_model_;
  DriveFilter filter_;
  BeaconBank bank_;
  NodeCalibration start_calibration_;  ///< how the place found follows the calibration
  bool placed_ = false;
  Trajectory t_;  ///< the stretch that the place is searched with; with a place: the instant alone
  double next_search_s_ = 0.0;  ///< span of the window at which to search
  OdometryStep row_;            ///< last row, and how long it took
  double row_s_ = 0.0;
  Scratch scratch_;
};

}  // namespace octant
