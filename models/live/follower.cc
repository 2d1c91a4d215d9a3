// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/follower.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "models/localizers/space/space_track.h"
#include "models/support/largest.h"

namespace octant {
namespace {

/// Number of consecutive late rows from which the clock of a vehicle was set back.
constexpr std::size_t kSetBackRows = 20;

bool of_one_pose(const Arrival& a, const Arrival& b) {
  if (a.epoch != b.epoch) return false;
  return a.epoch != kNoEpoch || b.time_s - a.time_s <= kSamePing_s;
}

/// Marks that a callback is running, until it has returned or thrown.
class InSink {
 public:
  explicit InSink(bool& mark) : mark_(mark) { mark_ = true; }
  ~InSink() { mark_ = false; }
  InSink(const InSink&) = delete;
  InSink& operator=(const InSink&) = delete;

 private:
  bool& mark_;
};

bool is_same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Returns true for a repeated row, which counts as one measurement, as in files.
bool is_same_row(const Arrival& a, const Arrival& b) {
  return a.time_s == b.time_s && a.beacon == b.beacon && a.receiver == b.receiver && a.epoch == b.epoch &&
         a.tof_s == b.tof_s && is_same(a.amplitude_v, b.amplitude_v) &&
         is_same(a.temperature_degC, b.temperature_degC);
}

/// Number of arrivals with which repetitions are compared.
constexpr std::size_t kRecentArrivals = 256;
/// Age at which odometry is used without an arrival.
constexpr double kLongestQueue_s = 5.0;

bool is_possible_row(const OdometryStep& step) {
  const double longest_m = std::max({std::abs(step.dx_m), std::abs(step.dy_m), std::abs(step.dz_m)});
  return step.is_finite() && longest_m <= kLargestLength_m;
}
bool is_possible_row(const OdometryPose& pose) {
  const Eigen::Vector3d& p = pose.T_odometry_vehicle.translation_m;
  return p.allFinite() && pose.T_odometry_vehicle.rotation.coeffs().allFinite() &&
         p.cwiseAbs().maxCoeff() <= kLargestLength_m;
}
bool give(DriveTracker& tracker, const OdometryStep& step) { return tracker.move(step); }
bool give(DriveTracker& tracker, const OdometryPose& pose) {
  return tracker.move(pose.time_s, pose.T_odometry_vehicle);
}

bool can_be_tracked(const Deployment& d) { return d.timing.clock == Clock::kSynchronised; }

bool has_same_members(const Deployment& a, const Deployment& b) {
  const auto same = [](const auto& p, const auto& q) {
    return p.name == q.name && p.position_m == q.position_m && p.delay_s == q.delay_s;
  };
  return std::ranges::equal(a.beacons, b.beacons, same) && std::ranges::equal(a.receivers, b.receivers, same);
}

/// Covariance of a pose between two calibrations: sigmas of 5 cm and 0.01 rad.
PoseCovariance between_calibrations(Motion motion) {
  const int dof = pose_dof(motion), shifts = first_turn(motion);
  PoseCovariance some = PoseCovariance::Zero(dof, dof);
  some.diagonal().head(shifts).setConstant(2.5e-3);
  some.diagonal().tail(dof - shifts).setConstant(1e-4);
  return some;
}

}  // namespace

Result<void> follow_fits(const Deployment& deployment, Method method) {
  if (method == Method::kReflectors || method == Method::kLineMap)
    return fail({.code = Errc::kUsage,
                 .found = std::string(to_string(method)) + " needs bearings or scans",
                 .expected = "a method of arrivals",
                 .advice = "leave the method to auto"});
  if (method == Method::kTracker)
    return can_be_tracked(deployment)
               ? Result<void>{}
               : Result<void>(fail({.code = Errc::kUsage,
                                    .found = "the tracker follows by synchronised clocks",
                                    .advice = "leave the method to auto"}));
  MeasurementLog any;
  any.has_epochs = true;
  any.arrivals.resize(1);
  return method == Method::kAuto ? Result<void>{} : method_fits(method, deployment, any);
}

TrackerOptions live_tracking() {
  TrackerOptions options;
  options.protect = true;  // a robot that drives by these fixes needs bounds on their error
  options.estimate_speed = true;
  options.start_window_s = 0.3;  // in a shorter time few beacons are received
  return options;
}

Follower::Follower(Deployment deployment, const FollowOptions& options)
    : deployment_(std::move(deployment)), options_(options), lanes_(deployment_.vehicles.size()) {
  for (std::size_t v = 0; v < lanes_.size(); ++v) {
    Lane& lane = lanes_[v];
    lane.waiting.reserve(options_.most_waiting + 1);
    lane.recent.reserve(kRecentArrivals);
    if (options_.method != Method::kTracker) lane.localizer = make_localizer_at(deployment_);
    if (may_track()) lane.tracker = make_tracker();
    lane.is_tracked = options_.method == Method::kTracker;
    if (options_.watch) lane.watch = std::make_unique<Watch>(deployment_, options_.watching, VehicleId(v));
    watch_motion(lane);
  }
  in_use_.reserve(options_.most_waiting);
  const bool by_least_squares = options_.method == Method::kAuto || options_.method == Method::kLeastSquares;
  // Poses of several vehicles do not end at the same time.
  if (by_least_squares && lanes_.size() == 1 && deployment_.medium.model != MediumModel::kConstant)
    speed_ = std::make_unique<LiveSpeed>(deployment_);
}

std::unique_ptr<Localizer> Follower::make_localizer_at(const Deployment& deployment) const {
  return make_localizer(options_.method == Method::kAuto ? Method::kLeastSquares : options_.method,
                        deployment);
}

std::unique_ptr<DriveTracker> Follower::make_tracker() const {
  return std::make_unique<DriveTracker>(deployment_, options_.odometry, live_tracking());
}

bool Follower::may_track() const {
  return options_.method == Method::kTracker ||
         (options_.method == Method::kAuto && can_be_tracked(deployment_));
}

Follower::Lane* Follower::lane_of(VehicleId vehicle) {
  return vehicle.valid() && vehicle.index() < lanes_.size() ? &lanes_[vehicle.index()] : nullptr;
}

double Follower::Lane::used_until_s() const {
  if (!is_tracked) return fixed_until_s;
  return tracker->now_s().value_or(-std::numeric_limits<double>::infinity());
}

bool Follower::refuse() {
  ++counts_.refused;
  return false;
}

/// Returns true if a row is too late, except for the row with which a vehicle restarts after a set-back.
bool Follower::is_too_late(Lane& lane, Behind& behind, double time_s, double newest_s) {
  if (time_s >= newest_s - options_.lateness_s) {
    behind = {};
    return false;
  }
  behind = {behind.rows > 0 && time_s >= behind.last_s ? behind.rows + 1 : 1, time_s};
  if (behind.rows >= kSetBackRows) {
    begin_anew(lane);
    return false;
  }
  ++counts_.late;
  return true;
}

bool Follower::is_repeated(const Lane& lane, const Arrival& arrival) const {
  const auto same = [&](const Arrival& other) { return is_same_row(other, arrival); };
  const auto first = std::ranges::lower_bound(lane.waiting, arrival.time_s, {}, &Arrival::time_s);
  const auto last = std::ranges::upper_bound(lane.waiting, arrival.time_s, {}, &Arrival::time_s);
  return std::any_of(first, last, same) || std::ranges::any_of(lane.recent, same);
}

bool Follower::hear(const Arrival& arrival) {
  Lane* lane = lane_of(arrival.vehicle);
  if (in_sink_ || lane == nullptr || !std::isfinite(arrival.time_s)) return refuse();
  if (is_too_late(*lane, lane->arrivals_behind, arrival.time_s, lane->newest_arrival_s)) return false;
  if (is_repeated(*lane, arrival)) return refuse();
  if (lane->tracker && !lane->is_tracked && arrival.epoch == kNoEpoch &&
      deployment_.vehicles[arrival.vehicle.index()].motion)
    begin_tracking(*lane);
  const double behind_s = lane->used_until_s() - arrival.time_s;
  if (behind_s > options_.lateness_s) {
    ++counts_.dropped;
    return false;
  }
  if (behind_s > 0.0) lane->hold_s = std::max(lane->hold_s, behind_s);
  ++counts_.arrivals;
  lane->newest_arrival_s = std::max(lane->newest_arrival_s, arrival.time_s);
  if (speed_ && !lane->is_tracked) speed_->hear(arrival);
  wait(*lane, arrival);
  process(*lane);
  return true;
}

void Follower::wait(Lane& lane, const Arrival& arrival) {
  const auto at = std::ranges::upper_bound(lane.waiting, arrival.time_s, {}, &Arrival::time_s);
  lane.waiting.insert(at, arrival);
  if (lane.waiting.size() <= options_.most_waiting) return;
  if (!lane.is_tracked) return process(lane, true);
  lane.waiting.erase(lane.waiting.begin());
  ++counts_.dropped;
}

/// Removes the first arrivals from the queue.
void Follower::use_up(Lane& lane, std::size_t count) {
  const auto last = lane.waiting.begin() + static_cast<std::ptrdiff_t>(count);
  for (auto a = lane.waiting.begin(); a != last; ++a) {
    if (lane.recent.size() < kRecentArrivals) {
      lane.recent.push_back(*a);
    } else {
      lane.recent[lane.oldest_recent] = *a;
      lane.oldest_recent = (lane.oldest_recent + 1) % kRecentArrivals;
    }
  }
  lane.waiting.erase(lane.waiting.begin(), last);
}

void Follower::begin_anew(Lane& lane) {
  ++counts_.restarts;
  process(lane, true);
  counts_.dropped += lane.waiting.size();
  lane.waiting.clear();
  lane.recent.clear();
  lane.oldest_recent = 0;
  lane.newest_arrival_s = lane.newest_row_s = lane.fixed_until_s = -std::numeric_limits<double>::infinity();
  lane.hold_s = 0.0;
  lane.arrivals_behind = lane.odometry_behind = {};
  lane.is_tracked = options_.method == Method::kTracker;
  if (lane.tracker) lane.tracker = make_tracker();
  watch_motion(lane);
}

void Follower::begin_tracking(Lane& lane) {
  process(lane, true);
  lane.is_tracked = true;
}

bool Follower::move(const OdometryStep& step) { return insert_row(step); }
bool Follower::move(const OdometryPose& pose) { return insert_row(pose); }

template <class Row>
bool Follower::insert_row(const Row& row) {
  Lane* lane = lane_of(row.vehicle);
  if (in_sink_ || lane == nullptr || !std::isfinite(row.time_s) || !is_possible_row(row)) return refuse();
  if (is_too_late(*lane, lane->odometry_behind, row.time_s, lane->newest_row_s)) return false;
  if (lane->tracker != nullptr) {  // otherwise the method does not use it
    if (!lane->is_tracked) begin_tracking(*lane);
    if (!give(*lane->tracker, row)) return refuse();
  }
  ++counts_.odometry_rows;
  lane->newest_row_s = std::max(lane->newest_row_s, row.time_s);
  process(*lane);
  return true;
}

void Follower::flush() {
  if (in_sink_) return;
  for (Lane& lane : lanes_) process(lane, true);
}

void Follower::flush_pings() {
  if (in_sink_) return;
  for (Lane& lane : lanes_)
    if (!lane.is_tracked && !lane.waiting.empty() && lane.waiting.back().epoch == kNoEpoch)
      process(lane, true);
}

void Follower::carry_on(const Follower& before) {
  counts_ = before.counts_;
  const NameTable names = names_of(before.deployment_);
  for (std::size_t v = 0; v < lanes_.size(); ++v) {
    const auto at = std::ranges::find(names.vehicles, deployment_.vehicles[v].name);
    if (at == names.vehicles.end()) continue;
    const Lane& old = before.lanes_[static_cast<std::size_t>(at - names.vehicles.begin())];
    Lane& lane = lanes_[v];
    lane.newest_arrival_s = old.newest_arrival_s;
    lane.newest_row_s = old.newest_row_s;
    lane.hold_s = old.hold_s;
    if (lane.watch && old.watch && has_same_members(before.deployment_, deployment_))
      *lane.watch = *old.watch;
    if (!old.is_tracked || lane.tracker == nullptr || before.deployment_.motion != deployment_.motion)
      continue;
    lane.is_tracked = true;
    lane.tracker->start(*old.tracker, between_calibrations(deployment_.motion));
  }
}

/// Uses the arrivals that are due. @param all  no more arrivals will come
void Follower::process(Lane& lane, bool all) {
  if (lane.is_tracked) {
    process_instants(lane, all);
  } else {
    process_poses(lane, all);
  }
}

/// Fixes complete poses: an arrival of another pose has come, and the time for late ones has passed.
void Follower::process_poses(Lane& lane, bool all) {
  while (!lane.waiting.empty()) {
    std::size_t count = 1;
    while (count < lane.waiting.size() && of_one_pose(lane.waiting[count - 1], lane.waiting[count])) ++count;
    const bool is_complete =
        count < lane.waiting.size() && lane.newest_arrival_s >= lane.waiting[count - 1].time_s + lane.hold_s;
    if (!all && !is_complete) return;
    if (speed_) follow_speed(lane);
    lane.fixed_until_s = std::max(lane.fixed_until_s, lane.waiting[count - 1].time_s);
    fix_pose(lane, std::span(lane.waiting).first(count));
    use_up(lane, count);
  }
}

void Follower::process_instants(Lane& lane, bool all) {
  DriveTracker& tracker = *lane.tracker;
  while (!lane.waiting.empty()) {
    const double time_s = lane.waiting.front().time_s;
    std::size_t count = 1;
    while (count < lane.waiting.size() && lane.waiting[count].time_s == time_s) ++count;
    const bool has_waited = lane.newest_s() > time_s + options_.lateness_s;
    const bool is_covered = !tracker.has_odometry() || tracker.covers(time_s);
    if (!all && !has_waited && !(is_covered && lane.newest_arrival_s >= time_s + lane.hold_s)) return;
    track_instant(lane, std::span(lane.waiting).first(count));
    use_up(lane, count);
  }
  if (tracker.now_s() && lane.newest_row_s - *tracker.now_s() > kLongestQueue_s)
    tracker.advance_to(lane.newest_row_s - kLongestQueue_s);
}

/// Estimates the speed of sound from the arrivals if the temperature is unknown, as for a recording.
void Follower::follow_speed(Lane& lane) {
  const auto found = speed_->new_estimate();
  if (!found) return;
  const double wanted_mps = found->differs() ? found->offset_mps : 0.0;
  if (std::abs(wanted_mps - speed_offset_mps_) <= found->sigma_mps) return;
  speed_offset_mps_ = wanted_mps;
  lane.localizer =
      make_localizer_at(found->differs() ? at_speed(speed_->calibrated(), *found) : speed_->calibrated());
  const InSink mark(in_sink_);
  if (on_speed) on_speed(*found);
}

void Follower::predict(VehicleId vehicle, double time_s, Fix& fix) {
  clear(fix);
  fix.vehicle = vehicle;
  fix.time_s = time_s;
  fix.status = FixStatus::kNoConsensus;
  const Lane* lane = lane_of(vehicle);
  if (lane == nullptr || !lane->is_tracked || !std::isfinite(time_s)) return;
  lane->tracker->predict(time_s, fix);
}

void Follower::fix_pose(Lane& lane, std::span<const Arrival> arrivals) {
  const auto in_use = still_in_use(lane, arrivals);
  lane.localizer->locate(Observations{in_use, {}}, fix_);
  // Without arrivals to fix the localizer sets no time
  if (fix_.rejections.empty()) fix_.time_s = arrivals.front().time_s;
  report_fix(arrivals);
  if (lane.watch) report_alarm(lane, lane.watch->observe_epoch(in_use, fix_));
}

void Follower::track_instant(Lane& lane, std::span<const Arrival> arrivals) {
  lane.tracker->advance_to(arrivals.front().time_s);
  const bool is_newest = lane.tracker->now_s().value_or(0.0) <= arrivals.front().time_s;
  if (lane.watch && is_newest)
    for (const Arrival& a : arrivals) report_alarm(lane, lane.watch->observe_arrival(a));
  const auto in_use = still_in_use(lane, arrivals);
  if (in_use.empty()) return;
  lane.tracker->locate(Observations{in_use, {}}, fix_);
  fix_.time_s = arrivals.front().time_s;
  if (lane.watch && is_newest && !lane.watch->is_following() && lane.tracker->is_placed())
    lane.watch->start(lane.tracker->pose(), lane.tracker->covariance());
  report_fix(arrivals);
}

void Follower::report_alarm(const Lane& lane, const std::optional<WatchAlarm>& alarm) {
  if (!alarm) return;
  for (Lane& other : lanes_)
    if (&other != &lane && other.watch && lane.watch->is_out(alarm->beacon))
      other.watch->leave_out(alarm->beacon);
  ++counts_.alarms;
  const InSink mark(in_sink_);
  if (on_alarm) on_alarm(*alarm);
}

void Follower::report_fix(std::span<const Arrival> arrivals) {
  fix_.vehicle = arrivals.front().vehicle;
  fix_.epoch = arrivals.front().epoch;
  ++(fix_.ok() ? counts_.fixes : counts_.no_fix);
  const auto used = static_cast<std::size_t>(std::max(fix_.ok() ? fix_.arrivals_used : 0, 0));
  counts_.used += std::min(used, arrivals.size());
  counts_.rejected += arrivals.size() - std::min(used, arrivals.size());
  const InSink mark(in_sink_);
  if (on_fix) on_fix(fix_);
}

}  // namespace octant
