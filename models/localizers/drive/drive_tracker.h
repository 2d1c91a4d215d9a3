// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/drive/tracker.h"
#include "models/run.h"

namespace octant {

/// The tracker as a robot runs it: `move` by each odometry row, `locate` at each instant of arrivals, one
/// vehicle, in the plane or in space, no cycle offset. Where it was is not asked: until the arrivals of the
/// last stretch of the drive settle one pose (as `find_start` does), and again when most arrivals contradict
/// it, there is no fix; a search is tried whenever the stretch has grown by a third. With a place it is an
/// iterated extended Kalman filter (`DriveFilterOf`), with protection levels one more a beacon
/// (`BeaconBankOf`). A fix takes microseconds; a search some tens of milliseconds, and with protection levels
/// some more. In the plane all memory is taken at construction; in space a search takes some.
class DriveTracker final : public Localizer {
 public:
  DriveTracker(const Deployment& deployment, const OdometryAccuracy& odometry,
               const TrackerOptions& options = {});
  ~DriveTracker() override;
  DriveTracker(DriveTracker&&) noexcept;
  DriveTracker& operator=(DriveTracker&&) noexcept;

  /// The vehicle is here; covariance of x, y [m], heading [rad], or in space of the pose's six
  /// (models/fix.h).
  void start(const Pose& T_map_vehicle, const PoseCovariance& covariance) noexcept;
  /// The vehicle moved by a fraction (0 to 1) of an odometry row; rows up to the instant of the next
  /// arrivals.
  void move(const OdometryStep& step, double fraction = 1.0) noexcept;
  /// Whether the place is known, and by all that came so far which it is: before `locate` the prediction.
  [[nodiscard]] bool is_placed() const;
  [[nodiscard]] Pose pose() const;
  [[nodiscard]] PoseCovariance covariance() const;

 private:
  class Core;
  template <int kDof>
  class CoreOf;
  /// Fix at the arrivals' instant, which is that of the last move: kOk, or kNoConsensus while the place is
  /// not known.
  void locate_known(const Observations& observations, Fix& fix) noexcept override;

  std::unique_ptr<Core> core_;
};

}  // namespace octant
