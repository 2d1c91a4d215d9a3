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
  /// A method of single poses, or the tracker. kAuto: least squares, and the tracker from a vehicle's first
  /// odometry row on, or where the deployment states its motion (synchronised clocks).
  Method method = Method::kAuto;
  OdometryAccuracy odometry;
  double lateness_s = 0.2;  ///< arrivals and odometry may come in any order within that time
  std::size_t most_waiting =
      4096;            ///< arrivals of a vehicle that may wait for the rest of their pose or for odometry
  bool watch = false;  ///< beacons and receivers, too (watch.h)
  WatchOptions watching;
};

/// What became of the rows.
struct FollowCounts {
  std::size_t arrivals = 0, odometry_rows = 0;  ///< taken
  std::size_t fixes = 0, no_fix = 0;
  std::size_t used = 0, rejected = 0;  ///< arrivals, by the fixes
  std::size_t refused = 0;  ///< rows that repeat another, say no number or an impossible length, or are of a
                            ///< vehicle that is none
  std::size_t late = 0;     ///< rows that came later than the lateness allows
  std::size_t dropped = 0;  ///< arrivals from before the first odometry row, or beyond most_waiting
  std::size_t alarms = 0;
  std::size_t restarts = 0;  ///< of vehicles whose clock was set back
};

/// Whether a deployment can be followed by a method; the error says what is missing.
[[nodiscard]] Result<void> follow_fits(const Deployment& deployment, Method method);

/// The options of the tracker as a robot runs it.
[[nodiscard]] TrackerOptions live_tracking();

/// Localizes as the data come, several vehicles at once. Rows may come in any order within the lateness. A
/// stream that is in order is not delayed: an arrival is used as soon as odometry covers its time. Once rows
/// have come d seconds behind others, arrivals wait for d seconds of the stream. Odometry that is missing is
/// waited for until the lateness has passed. All rows of one epoch (or, without epochs, those within five
/// milliseconds of each other) make a fix as soon as one of another pose comes; with the tracker each instant
/// of arrivals makes one. Where the arrivals state no temperature the speed of sound is estimated. Memory is
/// bounded by the number of vehicles and most_waiting. Throws nothing after construction.
class Follower {
 public:
  explicit Follower(Deployment deployment, const FollowOptions& options = {});

  /// Called for each fix, those without a pose included, and for each alarm of the watch. Within them nothing
  /// is taken: rows are refused, and nothing is flushed.
  std::function<void(const Fix&)> on_fix;
  std::function<void(const WatchAlarm&)> on_alarm;
  /// Called when the arrivals of single poses tell another speed than the deployment.
  std::function<void(const RunSpeed&)> on_speed;

  /// False: the row was refused or came too late, and is counted. Twenty rows of a vehicle one after the
  /// other that come too late, but in order, are a clock that was set back (or that had jumped ahead once):
  /// the vehicle begins anew with the last of them, without odometry and a place until it has them again.
  /// Unknown beacons and receivers are left to the fix, which rejects them.
  bool hear(const Arrival& arrival);
  bool move(const OdometryStep& step);
  /// The vehicle's pose in odometry's own frame.
  bool move(const OdometryPose& pose);
  /// Nothing more is coming of what has been received: fixes all that waits.
  void flush();
  /// The same of poses without an epoch that wait for no odometry: for a moment of quiet, which within a stop
  /// says nothing.
  void flush_pings();
  /// Where a vehicle is at an instant by all that was received: the tracker's state predicted to it. Not ok
  /// where the vehicle is not tracked.
  void predict(VehicleId vehicle, double time_s, Fix& fix);

  /// Takes over from a follower by an earlier deployment: vehicles of the same name go on from where they
  /// were. What waits there is lost: flush it first.
  void carry_on(const Follower& before);

  [[nodiscard]] const Deployment& deployment() const { return deployment_; }
  [[nodiscard]] const FollowCounts& counts() const { return counts_; }

 private:
  /// Rows that lie behind a vehicle's time, the last ones, as far as they are in order.
  struct Behind {
    std::size_t rows = 0;
    double last_s = 0.0;
  };
  struct Lane {
    std::vector<Arrival> waiting;  ///< in the order of time
    std::vector<Arrival> recent;   ///< the last ones that were used, against repetitions
    std::size_t oldest_recent = 0;
    double newest_arrival_s = -std::numeric_limits<double>::infinity();
    double newest_row_s = -std::numeric_limits<double>::infinity();
    double fixed_until_s = -std::numeric_limits<double>::infinity();  ///< of poses that wait for no odometry
    double hold_s = 0.0;  ///< as far as arrivals have come out of order
    Behind arrivals_behind, odometry_behind;
    bool is_tracked = false;
    std::unique_ptr<DriveTracker> tracker;
    std::unique_ptr<Localizer> localizer;
    std::unique_ptr<Watch> watch;
    [[nodiscard]] double newest_s() const { return std::max(newest_arrival_s, newest_row_s); }
    /// The instant up to which arrivals were used.
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
  /// Arrivals without those of beacons and receivers that the watch reported.
  [[nodiscard]] std::span<const Arrival> still_in_use(const Lane& lane, std::span<const Arrival> arrivals);
  void report_alarm(const Lane& lane, const std::optional<WatchAlarm>& alarm);

  Deployment deployment_;
  FollowOptions options_;
  std::vector<Lane> lanes_;
  std::unique_ptr<LiveSpeed> speed_;  ///< of single poses
  double speed_offset_mps_ = 0.0;     ///< that these are fixed with
  std::vector<Arrival> in_use_;  ///< arrivals without those of beacons and receivers that the watch reported
  FollowCounts counts_;
  Fix fix_;
  bool in_sink_ = false;  ///< the rows that a sink is told of are still in use
};

}  // namespace octant
