// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/drive/drive_tracker.h"
#include "models/localizers/methods.h"
#include "models/run.h"
#include "models/support/result.h"
#include "models/watch/watch.h"

namespace octant {

struct FollowOptions {
  /// A method of single poses, or the tracker. kAuto: least squares, and the tracker from a vehicle's first
  /// odometry row on (planar motion, synchronised clocks).
  Method method = Method::kAuto;
  OdometryAccuracy odometry;
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
  std::size_t refused = 0;  ///< rows that run backwards in time, repeat one that waits, say no number or
                            ///< an impossible length, or are of a vehicle that is none
  std::size_t dropped = 0;  ///< arrivals that waited in vain for odometry
  std::size_t alarms = 0;
  std::size_t restarts = 0;  ///< of vehicles whose clock was set back
};

/// Whether a deployment can be followed by a method; the error says what is missing.
[[nodiscard]] Result<void> follow_fits(const Deployment& deployment, Method method);

/// Localizes as the data come, row by row in the order of time, several vehicles at once. All rows of one
/// epoch (or, without epochs, those within five milliseconds of each other) make a fix as soon as one of
/// another pose comes; with the tracker each instant of arrivals makes one, as soon as the odometry row that
/// covers it has come. Memory is bounded by the number of vehicles and most_waiting. Throws nothing after
/// construction.
class Follower {
 public:
  explicit Follower(Deployment deployment, const FollowOptions& options = {});

  /// Called for each fix, those without a pose included, and for each alarm of the watch. Within them nothing
  /// is taken: rows are refused, and nothing is flushed.
  std::function<void(const Fix&)> on_fix;
  std::function<void(const WatchAlarm&)> on_alarm;

  /// False: the row was refused, and counted. Twenty rows of a vehicle one after the other that lie behind
  /// its time, but not behind each other, are a clock that was set back (or that had jumped ahead once): the
  /// vehicle begins anew with the last of them, without odometry and a place until it has them again. Unknown
  /// beacons and receivers are left to the fix, which rejects them.
  bool hear(const Arrival& arrival);
  bool move(const OdometryStep& step);
  /// Nothing more is coming of the poses that are open: fixes them. What waits for odometry goes on waiting.
  void flush();
  /// The same of poses without an epoch alone: for a moment of quiet, which within a stop says nothing.
  void flush_pings();

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
    std::vector<Arrival> waiting;
    double last_arrival_s = -std::numeric_limits<double>::infinity();
    std::optional<double> row_s;  ///< time of the last odometry row
    double now_s = 0.0;           ///< until when the tracker has moved
    Behind arrivals_behind, odometry_behind;
    std::unique_ptr<DriveTracker> tracker;
    std::unique_ptr<Localizer> localizer;
    /// Whether arrivals wait for the rest of their pose, and not for odometry.
    [[nodiscard]] bool has_open_pose() const { return !row_s && localizer != nullptr && !waiting.empty(); }
  };
  [[nodiscard]] Lane* lane_of(VehicleId vehicle);
  [[nodiscard]] bool may_track() const;
  [[nodiscard]] std::unique_ptr<DriveTracker> make_tracker() const;
  [[nodiscard]] bool is_set_back(Lane& lane, Behind& behind, double time_s);
  void begin_anew(Lane& lane);
  void fix_pose(Lane& lane);
  void track_until(Lane& lane, const OdometryStep& step, double span_s);
  void track_instant(Lane& lane, std::span<const Arrival> arrivals);
  void report_fix(std::span<const Arrival> arrivals);
  void report_alarm(const std::optional<WatchAlarm>& alarm);

  Deployment deployment_;
  FollowOptions options_;
  std::vector<Lane> lanes_;
  std::unique_ptr<Watch> watch_;
  FollowCounts counts_;
  Fix fix_;
  bool in_sink_ = false;  ///< the rows that a sink is told of are still in use
};

}  // namespace octant
