// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/live/live_speed.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/drive/drive_tracker.h"
#include "models/localizers/methods.h"
#include "models/odometry_pose.h"
#include "models/run.h"
#include "models/support/result.h"
#include "models/watch/watch.h"

namespace octant {

struct FollowOptions {
  /// A method for single poses, or the tracker. kAuto: least squares; the tracker from a vehicle's first
  /// odometry row on, or if the deployment has a motion model (synchronised clocks).
  Method method = Method::kAuto;
  OdometryAccuracy odometry;
  double lateness_s = 0.2;  ///< arrivals and odometry may arrive in any order within this time
  std::size_t most_waiting =
      4096;  ///< maximum number of arrivals of a vehicle that wait for the rest of their pose or for odometry
  bool watch = false;  ///< also monitors beacons and receivers (watch.h)
  WatchOptions watching;
};

/// Numbers of rows by outcome.
struct FollowCounts {
  std::size_t arrivals = 0, odometry_rows = 0;  ///< accepted
  std::size_t fixes = 0, no_fix = 0;
  std::size_t used = 0, rejected = 0;  ///< arrivals in fixes
  /// Rows that repeat another one, have an impossible value, or name an unknown vehicle
  std::size_t refused = 0;
  std::size_t late = 0;     ///< rows later than the lateness allows
  std::size_t dropped = 0;  ///< arrivals before the first odometry row, or beyond most_waiting
  std::size_t alarms = 0;
  std::size_t restarts = 0;  ///< restarts of vehicles whose clock was set back
};

/// Checks that a method can be used with a deployment; the error names what is missing.
[[nodiscard]] Result<void> follow_fits(const Deployment& deployment, Method method);

/// Options of the tracker on a robot.
[[nodiscard]] TrackerOptions live_tracking();

/// Localizes several vehicles from live data. Rows may arrive in any order within the lateness. A stream in
/// order is not delayed: an arrival is used as soon as odometry covers its time. After rows have arrived d
/// seconds late, arrivals wait for d seconds of the stream. Missing odometry is awaited until the lateness
/// has passed.
///
/// All rows of one epoch (or, without epochs, within five milliseconds of each other) form a fix as soon as a
/// row of another pose arrives. With the tracker, the arrivals at each time form a fix. If the arrivals have
/// no temperature, the speed of sound is estimated. Memory is bounded by the number of vehicles and
/// most_waiting. Throws no exceptions after construction.
class Follower {
 public:
  explicit Follower(Deployment deployment, const FollowOptions& options = {});

  /// Called for each fix, also those without a pose, and for each alarm of the watch. During these calls rows
  /// are refused, and flush() has no effect.
  std::function<void(const Fix&)> on_fix;
  std::function<void(const WatchAlarm&)> on_alarm;
  /// Called when the arrivals of single poses determine another speed than the deployment's.
  std::function<void(const RunSpeed&)> on_speed;

  /// Adds a row. After twenty consecutive rows of a vehicle that are too late, but in order, its clock is
  /// assumed to have been set back (or to have jumped ahead before). The vehicle then restarts with the last
  /// of these rows, without odometry and pose. The localizer rejects unknown beacons and receivers.
  /// @return false if the row was refused or is too late; it is counted
  bool hear(const Arrival& arrival);
  bool move(const OdometryStep& step);
  /// Adds the vehicle's pose in the frame of the odometry.
  bool move(const OdometryPose& pose);
  /// Fixes all waiting arrivals, because no more rows of their poses will arrive.
  void flush();
  /// Fixes waiting poses without an epoch that need no odometry. For a pause of the stream, which within a
  /// stop has no meaning.
  void flush_pings();
  /// Predicts the pose of a vehicle at a time from the tracker's state. Not ok if the vehicle is not tracked.
  void predict(VehicleId vehicle, double time_s, Fix& fix);

  /// Continues from a follower with an earlier deployment: vehicles of the same name keep their state. Rows
  /// that wait there are lost, so flush it first.
  void carry_on(const Follower& before);

  [[nodiscard]] const Deployment& deployment() const { return deployment_; }
  [[nodiscard]] const FollowCounts& counts() const { return counts_; }

 private:
  /// Consecutive rows that are late for a vehicle's time and in order.
  struct Behind {
    std::size_t rows = 0;
    double last_s = 0.0;
  };
  struct Lane {
    std::vector<Arrival> waiting;  ///< in order of time
    std::vector<Arrival> recent;   ///< last used arrivals, to detect repetitions
    std::size_t oldest_recent = 0;
    double newest_arrival_s = -std::numeric_limits<double>::infinity();
    double newest_row_s = -std::numeric_limits<double>::infinity();
    double fixed_until_s = -std::numeric_limits<double>::infinity();  ///< for poses that need no odometry
    double hold_s = 0.0;                                              ///< largest delay of an arrival so far
    Behind arrivals_behind, odometry_behind;
    bool is_tracked = false;
    std::unique_ptr<DriveTracker> tracker;
    std::unique_ptr<Localizer> localizer;
    std::unique_ptr<Watch> watch;
    [[nodiscard]] double newest_s() const { return std::max(newest_arrival_s, newest_row_s); }
    /// Time up to which arrivals were used.
    [[nodiscard]] double used_until_s() const;
  };
  [[nodiscard]] Lane* lane_of(VehicleId vehicle);
  [[nodiscard]] bool may_track() const;
  [[nodiscard]] std::unique_ptr<DriveTracker> make_tracker() const;
  [[nodiscard]] std::unique_ptr<Localizer> make_localizer_at(const Deployment& deployment) const;
  [[nodiscard]] bool is_too_late(Lane& lane, Behind& behind, double time_s, double newest_s);
  [[nodiscard]] bool is_repeated(const Lane& lane, const Arrival& arrival) const;
  bool refuse();
  template <class Row>
  bool insert_row(const Row& row);
  void begin_anew(Lane& lane);
  void begin_tracking(Lane& lane);
  void watch_motion(Lane& lane);
  void wait(Lane& lane, const Arrival& arrival);
  void use_up(Lane& lane, std::size_t count);
  void process(Lane& lane, bool all = false);
  void process_poses(Lane& lane, bool all);
  void process_instants(Lane& lane, bool all);
  void follow_speed(Lane& lane);
  void fix_pose(Lane& lane, std::span<const Arrival> arrivals);
  void track_instant(Lane& lane, std::span<const Arrival> arrivals);
  void report_fix(std::span<const Arrival> arrivals);
  /// Returns the arrivals except those of beacons and receivers that the watch reported.
  [[nodiscard]] std::span<const Arrival> still_in_use(const Lane& lane, std::span<const Arrival> arrivals);
  void report_alarm(const Lane& lane, const std::optional<WatchAlarm>& alarm);

  Deployment deployment_;
  FollowOptions options_;
  std::vector<Lane> lanes_;
  std::unique_ptr<LiveSpeed> speed_;  ///< for single poses
  double speed_offset_mps_ = 0.0;     ///< speed offset used for these
  std::vector<Arrival> in_use_;  ///< arrivals without those of beacons and receivers that the watch reported
  FollowCounts counts_;
  Fix fix_;
  bool in_sink_ = false;  ///< a callback is running, and its rows are still in use
};

}  // namespace octant
