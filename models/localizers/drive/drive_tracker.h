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

/// The tracker for a robot: call `move` for each odometry row and `locate` for the arrivals at each time. One
/// vehicle, in the plane or in space, no cycle offset. `locate` predicts to the time of its arrivals by the
/// odometry received so far, and by the possible motion without odometry (`OdometryQueue`). Arrivals may be
/// some tenths of a second older than earlier ones.
///
/// At first the pose is unknown. It is searched in the last seconds of the drive, whenever these have grown
/// by a third, and again when the arrivals contradict it (`LossTest`) or a gap in the odometry has made it
/// too uncertain. With a pose, the tracker is an iterated extended Kalman filter (`DriveFilterOf`), with an
/// additional one for each beacon for protection levels (`BeaconBankOf`). Without a recorded temperature, the
/// speed of sound is estimated with the pose. A fix takes microseconds; a search takes some tens of
/// milliseconds, and more with protection levels. In the plane all memory is allocated at construction; in
/// space a search allocates some.
class DriveTracker final : public Localizer {
 public:
  DriveTracker(const Deployment& deployment, const OdometryAccuracy& odometry,
               const TrackerOptions& options = {});
  ~DriveTracker() override;
  DriveTracker(DriveTracker&&) noexcept;
  DriveTracker& operator=(DriveTracker&&) noexcept;

  /// Sets the pose; covariance of x, y [m], heading [rad], or in space of the six components of the pose
  /// (models/fix.h).
  void start(const Pose& T_map_vehicle, const PoseCovariance& covariance) noexcept;
  /// Continues from the state of another tracker.
  void start(const DriveTracker& other, const PoseCovariance& widened_by) noexcept;
  /// Adds an odometry row, in any order. The first is the anchor. @return false if its time has passed
  bool move(const OdometryStep& row) noexcept;
  /// Adds the vehicle's pose in the frame of the odometry, for which a lost row leaves no gap.
  bool move(double time_s, const Pose& T_odometry_vehicle) noexcept;
  /// Returns true if odometry determines the motion up to a time, without a gap.
  [[nodiscard]] bool covers(double time_s) const;
  [[nodiscard]] bool has_odometry() const;
  /// Time up to which the vehicle was moved; no value before the first row or arrival.
  [[nodiscard]] std::optional<double> now_s() const;
  /// Oldest time at which arrivals can still be used.
  [[nodiscard]] double oldest_s() const;
  /// Predicts to a time, if it is later than now.
  void advance_to(double time_s) noexcept;
  /// Sets a callback for each motion from odometry, and with null for times without odometry.
  void set_motion_sink(std::function<void(const OdometryObservation*)> sink);

  /// Predicts a fix for a time without a change of the tracker. Not ok if the pose is unknown.
  void predict(double time_s, Fix& fix) noexcept;

  /// Returns true if the pose is known and unambiguous.
  [[nodiscard]] bool is_placed() const;
  [[nodiscard]] Pose pose() const;
  [[nodiscard]] PoseCovariance covariance() const;
  /// Velocity in the vehicle's frame: along x, y, z [m/s] and about x, y, z [rad/s].
  [[nodiscard]] Eigen::Matrix<double, 6, 1> velocity() const;
  /// Estimated offset of the speed from the deployment's [m/s].
  [[nodiscard]] double speed_offset_mps() const;

 private:
  class Core;
  template <int kDof>
  class CoreOf;
  /// Fix at the time of the arrivals: kOk, or kNoConsensus if the pose is unknown or no arrival was used.
  void locate_known(const Observations& observations, Fix& fix) noexcept override;

  std::unique_ptr<Core> core_;
};

}  // namespace octant
