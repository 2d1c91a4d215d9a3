// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/start/tracker_options.h"
#include "models/run.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// The tracker as a robot runs it: `move` for each odometry row, `locate` for each instant of arrivals, one
/// vehicle, in the plane or in space, no cycle offset. `locate` predicts to the instant of its arrivals by
/// the odometry received so far, and by the possible motion where there is none (`OdometryQueue`). Arrivals
/// may be some tenths of a second older than those before them.
///
/// The place is unknown at first. It is searched in the last seconds of the drive, whenever these have grown
/// by a third, and again as soon as the arrivals contradict it (`LossTest`) or a gap in the odometry has left
/// it too uncertain. With a place the tracker is an iterated extended Kalman filter (`DriveFilterOf`), with
/// protection levels one more a beacon (`BeaconBankOf`). Where no temperature is stated the speed of sound is
/// estimated with the pose. A fix takes microseconds; a search some tens of milliseconds, and with protection
/// levels some more. In the plane all memory is taken at construction; in space a search takes some.
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
  /// Goes on from where another tracker is.
  void start(const DriveTracker& other, const PoseCovariance& widened_by) noexcept;
  /// An odometry row, in any order. The first is the anchor. @return false: its time has passed
  bool move(const OdometryStep& row) noexcept;
  /// The vehicle's pose in odometry's own frame: a row that is lost leaves no gap then.
  bool move(double time_s, const Pose& T_odometry_vehicle) noexcept;
  /// Whether odometry tells the motion up to an instant, without a gap.
  [[nodiscard]] bool covers(double time_s) const;
  [[nodiscard]] bool has_odometry() const;
  /// The instant up to which the vehicle was moved; nothing before the first row or arrival.
  [[nodiscard]] std::optional<double> now_s() const;
  /// The oldest instant at which arrivals can still be used.
  [[nodiscard]] double oldest_s() const;
  /// Predicts to an instant, where that is later than now.
  void advance_to(double time_s) noexcept;
  /// Called while time advances: for each motion that odometry tells, and with null where it tells none.
  void set_motion_sink(std::function<void(const OdometryObservation*)> sink);

  /// The state predicted to an instant, which leaves the tracker as it is. Not ok where the place is not
  /// known.
  void predict(double time_s, Fix& fix) noexcept;

  /// Whether the place is known, and by all that came so far which it is.
  [[nodiscard]] bool is_placed() const;
  [[nodiscard]] Pose pose() const;
  [[nodiscard]] PoseCovariance covariance() const;
  /// In the vehicle's frame: along x, y, z [m/s] and about x, y, z [rad/s].
  [[nodiscard]] Eigen::Matrix<double, 6, 1> velocity() const;
  /// By how much the signal is faster than the deployment states [m/s], as far as the arrivals tell.
  [[nodiscard]] double speed_offset_mps() const;

 private:
  class Core;
  template <int kDof>
  class CoreOf;
  /// Fix at the arrivals' instant: kOk, or kNoConsensus while the place is not known, and where no arrival
  /// could be used.
  void locate_known(const Observations& observations, Fix& fix) noexcept override;

  std::unique_ptr<Core> core_;
};

}  // namespace octant
