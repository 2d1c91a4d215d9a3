// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/localizers/drive/drive_filter.h"
#include "models/physics/pose.h"
#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// A part of an odometry row.
struct MotionPart {
  OdometryObservation observation;  ///< the motion and its sigmas
  double span_s = 0.0;
  Velocity velocity = Velocity::Zero();  ///< mean velocity over the whole row
  double speed_variance = 0.0, turn_rate_variance = 0.0;
};

/// Odometry of one vehicle, with rows in any order, as motions between times.
///
/// A lost incremental row leaves a gap: the next row comes later than usual, although it covers the usual
/// time only. A row whose length shows that it includes the lost motion leaves no gap. Rows with the pose in
/// the frame of the odometry never leave gaps. No memory is allocated after construction.
class OdometryQueue {
 public:
  OdometryQueue(const OdometryAccuracy& accuracy, Motion motion, const std::optional<MotionPrior>& prior);

  /// @return false if its time has passed, or if there is a row with this time
  bool insert(const OdometryStep& row);
  /// Inserts the vehicle's pose in the frame of the odometry.
  bool insert(double time_s, const Pose& T_odometry_vehicle);
  /// Starts at a time, unless started already.
  void begin(double time_s);
  [[nodiscard]] bool has_begun() const { return begun_; }
  [[nodiscard]] bool has_rows() const { return anchored_ || !pending_.empty(); }
  [[nodiscard]] double now_s() const { return now_s_; }
  /// Returns true if odometry determines the motion up to a time, without a gap.
  [[nodiscard]] bool covers(double time_s) const;
  /// Calls step(MotionPart) for motions from odometry, and coast(span_s, since_s) for gaps.
  template <class Step, class Coast>
  void advance_to(double time_s, Step&& step, Coast&& coast);

  /// Stores a recent motion, for late arrivals.
  void remember(const OdometryObservation& motion, double span_s);
  [[nodiscard]] double oldest_s() const;
  /// Calls step(motion) for the inverse motions from now back to a time, and for those from there to now.
  template <class Step>
  void back_to(double time_s, Step&& step) const;
  template <class Step>
  void forward_from(double time_s, Step&& step) const;

  /// Velocity from the last rows, and its variances.
  [[nodiscard]] const Velocity& velocity() const { return velocity_; }
  [[nodiscard]] double speed_variance() const { return speed_variance_; }
  [[nodiscard]] double turn_rate_variance() const { return turn_rate_variance_; }
  /// Limits from the motion model of the site, or from the observed motion.
  [[nodiscard]] const MotionLimits& limits() const { return limits_; }

 private:
  struct Row {
    double time_s = 0.0;
    bool is_pose = false;
    OdometryStep step{};
    Pose T_odometry_vehicle{};
  };
  /// Motion of a row: its start and the motion until its time.
  struct RowMotion {
    double begin_s = 0.0;
    Pose T_before_after{};
    double distance_m2 = 0.0, heading_rad2 = 0.0;
  };
  struct Past {
    double begin_s = 0.0, end_s = 0.0;
    OdometryObservation motion;
  };
  bool insert(const Row& row);
  [[nodiscard]] RowMotion motion_of(const Row& row, bool anchored, double last_row_s,
                                    const std::optional<Pose>& T_last) const;
  [[nodiscard]] bool sums_up(const Pose& T, double since_s) const;
  [[nodiscard]] MotionPart part_of(const RowMotion& motion, double end_s, double from_s,
                                   double until_s) const;
  void finish(const Row& row, const RowMotion& motion);
  void observe_velocity(const RowMotion& motion, double span_s);
  void observe_interval(double interval_s);
  [[nodiscard]] static OdometryObservation part_of(const Past& past, double from_s, double until_s);

  OdometryAccuracy accuracy_;
  Motion motion_;
  bool limits_stated_;
  MotionLimits limits_;
  std::vector<Row> pending_;  ///< in order of time
  std::vector<Past> past_;
  bool begun_ = false, anchored_ = false;
  double now_s_ = 0.0;
  double last_row_s_ = -std::numeric_limits<double>::infinity();  ///< time of the last row that was used
  double known_until_s_ = -std::numeric_limits<double>::infinity();
  std::optional<Pose> T_last_;  ///< pose of the last row, if it had one
  double interval_s_ = 0.0;     ///< usual time between rows; 0: not known yet
  double spread_s_ = 0.0;       ///< usual deviation from that
  int gaps_ = 0;                ///< number of consecutive gaps
  Velocity velocity_ = Velocity::Zero();
  double speed_variance_ = 0.0, turn_rate_variance_ = 0.0;
};

inline constexpr double kCoastStep_s = 0.05;  ///< longest step in which a velocity counts as constant
inline constexpr double kMostCoastSteps = 200.0;

template <class Step, class Coast>
void OdometryQueue::advance_to(double time_s, Step&& step, Coast&& coast) {
  while (now_s_ < time_s) {
    const bool any = !pending_.empty();
    const RowMotion motion =
        any ? motion_of(pending_.front(), anchored_, last_row_s_, T_last_) : RowMotion{.begin_s = time_s};
    if (now_s_ < motion.begin_s) {
      const double until_s = std::min(time_s, motion.begin_s),
                   longest_s = std::max(kCoastStep_s, (until_s - now_s_) / kMostCoastSteps);
      while (now_s_ < until_s) {
        const double span_s = std::min(longest_s, until_s - now_s_);
        coast(span_s, now_s_ - known_until_s_);
        now_s_ = until_s - now_s_ > span_s ? now_s_ + span_s : until_s;
      }
      continue;
    }
    const Row& row = pending_.front();
    const double until_s = std::min(time_s, row.time_s);
    if (until_s > now_s_) step(part_of(motion, row.time_s, now_s_, until_s));
    now_s_ = known_until_s_ = until_s;
    if (now_s_ >= row.time_s) finish(row, motion);
  }
  // An anchor at exactly this time.
  while (!pending_.empty() && pending_.front().time_s <= now_s_)
    finish(pending_.front(), motion_of(pending_.front(), anchored_, last_row_s_, T_last_));
}

template <class Step>
void OdometryQueue::back_to(double time_s, Step&& step) const {
  for (auto past = past_.rbegin(); past != past_.rend() && past->end_s > time_s; ++past) {
    OdometryObservation part = part_of(*past, std::max(time_s, past->begin_s), past->end_s);
    part.T_before_after = part.T_before_after.inverse();
    step(part);
  }
}

template <class Step>
void OdometryQueue::forward_from(double time_s, Step&& step) const {
  for (const Past& past : past_)
    if (past.end_s > time_s) step(part_of(past, std::max(time_s, past.begin_s), past.end_s));
}

}  // namespace octant
