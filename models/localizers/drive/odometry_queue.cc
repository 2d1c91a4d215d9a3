// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/odometry_queue.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "models/physics/plane.h"
#include "models/trajectory/odometry_noise.h"

namespace octant {
namespace {

constexpr std::size_t kMostPending = 1024, kMostPast = 512;
/// Limits for sites without a motion model: at least walking pace, reached within a second.
constexpr double kLeastSpeed_mps = 0.5, kLeastTurnRate_radps = 0.5, kToFullSpeed_s = 1.0;
constexpr double kGapShare = 1.5;        ///< multiple of the usual interval beyond which a row may be missing
constexpr double kGapSpreads = 4.0;      ///< and multiple of its usual deviation
constexpr double kForgetInterval = 0.1;  ///< weight of each row in the averages
constexpr int kGapsOfANewRate = 10;      ///< consecutive gaps after which the rate of rows has changed

MotionLimits limits_of(const std::optional<MotionPrior>& prior) {
  if (!prior) return {kLeastSpeed_mps, kToFullSpeed_s, kLeastTurnRate_radps, kToFullSpeed_s};
  return {prior->speed_mps, prior->speed_mps / prior->acceleration_mps2, prior->turn_rate_rad_per_s,
          prior->turn_rate_rad_per_s / prior->turn_acceleration_rad_per_s2};
}

Velocity velocity_of(const Pose& T, double span_s) {
  Velocity velocity;
  velocity << T.translation_m, log_rotation(T.rotation);
  return velocity / span_s;
}

}  // namespace

OdometryQueue::OdometryQueue(const OdometryAccuracy& accuracy, Motion motion,
                             const std::optional<MotionPrior>& prior)
    : accuracy_(accuracy),
      motion_(motion),
      limits_stated_(prior.has_value()),
      limits_(limits_of(prior)),
      speed_variance_(square(limits_.speed_mps)),
      turn_rate_variance_(square(limits_.turn_rate_radps)) {
  pending_.reserve(kMostPending);
  past_.reserve(kMostPast);
}

bool OdometryQueue::insert(const OdometryStep& row) {
  Row next{.time_s = row.time_s, .step = row};
  if (motion_ == Motion::kPlanar) {
    next.step.dz_m = next.step.turn_x_rad = next.step.turn_y_rad = 0.0;
  }
  return insert(next);
}

bool OdometryQueue::insert(double time_s, const Pose& T_odometry_vehicle) {
  Row next{.time_s = time_s, .is_pose = true, .T_odometry_vehicle = T_odometry_vehicle};
  if (motion_ == Motion::kPlanar) {
    const Eigen::Vector3d& p = T_odometry_vehicle.translation_m;
    next.T_odometry_vehicle = Pose::planar(p.x(), p.y(), T_odometry_vehicle.heading_rad());
  }
  return insert(next);
}

bool OdometryQueue::insert(const Row& row) {
  if (!begun_) begin(row.time_s);
  if (row.time_s <= last_row_s_ || row.time_s < now_s_ || pending_.size() == kMostPending) return false;
  const auto at = std::ranges::lower_bound(pending_, row.time_s, {}, &Row::time_s);
  if (at != pending_.end() && at->time_s == row.time_s) return false;
  pending_.insert(at, row);
  return true;
}

void OdometryQueue::begin(double time_s) {
  begun_ = true;
  now_s_ = time_s;
}

/// Returns true if a late row is as long as the present velocity yields in all that time.
bool OdometryQueue::sums_up(const Pose& T, double since_s) const {
  const Velocity moved = velocity_of(T, 1.0);
  const auto misfit = [&](double span_s) {
    const Velocity off = moved - span_s * velocity_;
    return off.head<3>().squaredNorm() / square(limits_.speed_mps) +
           off.tail<3>().squaredNorm() / square(limits_.turn_rate_radps);
  };
  return misfit(since_s) < misfit(interval_s_);
}

OdometryQueue::RowMotion OdometryQueue::motion_of(const Row& row, bool anchored, double last_row_s,
                                                  const std::optional<Pose>& T_last) const {
  RowMotion motion{.begin_s = row.time_s};
  if (!anchored || (row.is_pose && !T_last)) return motion;  // the anchor has no motion
  const double since_s = row.time_s - last_row_s;
  OdometryStep step = row.step;
  if (row.is_pose) step.set_pose(T_last->inverse() * row.T_odometry_vehicle);
  const OdometryVariance variance = estimation_variance_of(step, accuracy_);
  motion.T_before_after = step.pose();
  motion.distance_m2 = variance.distance_m2;
  motion.heading_rad2 = variance.heading_rad2;
  const bool is_late = interval_s_ > 0.0 && since_s > kGapShare * interval_s_ + kGapSpreads * spread_s_;
  const bool is_gap = is_late && !row.is_pose && !sums_up(motion.T_before_after, since_s);
  motion.begin_s = row.time_s - (is_gap ? interval_s_ : since_s);
  return motion;
}

bool OdometryQueue::covers(double time_s) const {
  bool anchored = anchored_;
  double last_row_s = last_row_s_, until_s = now_s_;
  std::optional<Pose> T_last = T_last_;
  for (const Row& row : pending_) {
    if (until_s >= time_s) return true;
    if (anchored && motion_of(row, anchored, last_row_s, T_last).begin_s > until_s + 1e-9) return false;
    anchored = true;
    last_row_s = until_s = row.time_s;
    T_last = row.is_pose ? std::optional(row.T_odometry_vehicle) : std::nullopt;
  }
  return until_s >= time_s;
}

MotionPart OdometryQueue::part_of(const RowMotion& motion, double end_s, double from_s,
                                  double until_s) const {
  const double whole_s = end_s - motion.begin_s, from = (from_s - motion.begin_s) / whole_s,
               until = (until_s - motion.begin_s) / whole_s;
  MotionPart part;
  part.span_s = until_s - from_s;
  part.observation.T_before_after = interpolate(Pose{}, motion.T_before_after, from).inverse() *
                                    interpolate(Pose{}, motion.T_before_after, until);
  part.observation.distance_sigma_m = std::sqrt((until - from) * motion.distance_m2);
  part.observation.heading_sigma_rad = std::sqrt((until - from) * motion.heading_rad2);
  part.velocity = velocity_of(motion.T_before_after, whole_s);
  const double by_s2 = square(whole_s);
  part.speed_variance = motion.distance_m2 / by_s2 + square(limits_.speed_mps / limits_.speed_time_s) * by_s2;
  part.turn_rate_variance =
      motion.heading_rad2 / by_s2 + square(limits_.turn_rate_radps / limits_.turn_time_s) * by_s2;
  return part;
}

void OdometryQueue::finish(const Row& passed, const RowMotion& motion) {
  if (anchored_) observe_interval(passed.time_s - last_row_s_);
  if (passed.time_s > motion.begin_s) observe_velocity(motion, passed.time_s - motion.begin_s);
  anchored_ = true;
  last_row_s_ = passed.time_s;
  known_until_s_ = std::max(known_until_s_, last_row_s_);
  T_last_ = passed.is_pose ? std::optional(passed.T_odometry_vehicle) : std::nullopt;
  pending_.erase(pending_.begin());
}

void OdometryQueue::observe_interval(double interval_s) {
  const bool is_gap = interval_s_ > 0.0 && interval_s > kGapShare * interval_s_ + kGapSpreads * spread_s_;
  gaps_ = is_gap ? gaps_ + 1 : 0;
  if (interval_s_ == 0.0 || gaps_ >= kGapsOfANewRate) {
    interval_s_ = interval_s;
    spread_s_ = 0.0;
    gaps_ = 0;
  } else if (!is_gap) {
    spread_s_ += kForgetInterval * (std::abs(interval_s - interval_s_) - spread_s_);
    interval_s_ += kForgetInterval * (interval_s - interval_s_);
  }
}

void OdometryQueue::observe_velocity(const RowMotion& motion, double span_s) {
  const Velocity measured = velocity_of(motion.T_before_after, span_s);
  const auto update = [&](double row_variance, double limit, double time_s, double& variance) {
    variance = std::min(variance + square(limit / time_s * span_s), square(limit));
    const double gain = variance / (variance + row_variance / square(span_s));
    variance *= 1.0 - gain;
    return gain;
  };
  const double by_speed =
                   update(motion.distance_m2, limits_.speed_mps, limits_.speed_time_s, speed_variance_),
               by_turn = update(motion.heading_rad2, limits_.turn_rate_radps, limits_.turn_time_s,
                                turn_rate_variance_);
  velocity_.head<3>() += by_speed * (measured - velocity_).head<3>();
  velocity_.tail<3>() += by_turn * (measured - velocity_).tail<3>();
  if (limits_stated_) return;
  limits_.speed_mps = std::max(limits_.speed_mps, velocity_.head<3>().norm());
  limits_.turn_rate_radps = std::max(limits_.turn_rate_radps, velocity_.tail<3>().norm());
}

void OdometryQueue::remember(const OdometryObservation& motion, double span_s) {
  if (past_.size() == kMostPast) past_.erase(past_.begin(), past_.begin() + kMostPast / 2);
  past_.push_back({now_s_, now_s_ + span_s, motion});
}

double OdometryQueue::oldest_s() const { return past_.empty() ? now_s_ : past_.front().begin_s; }

OdometryObservation OdometryQueue::part_of(const Past& past, double from_s, double until_s) {
  const double whole_s = past.end_s - past.begin_s, from = (from_s - past.begin_s) / whole_s,
               until = (until_s - past.begin_s) / whole_s;
  OdometryObservation part = past.motion;
  part.T_before_after = interpolate(Pose{}, past.motion.T_before_after, from).inverse() *
                        interpolate(Pose{}, past.motion.T_before_after, until);
  part.distance_sigma_m *= std::sqrt(until - from);
  part.heading_sigma_rad *= std::sqrt(until - from);
  return part;
}

}  // namespace octant
