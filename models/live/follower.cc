// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/live/follower.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "models/localizers/space/space_track.h"
#include "models/support/largest.h"

namespace octant {
namespace {

/// Rows behind a vehicle's time, one after the other, that are no disorder any more but another time.
constexpr std::size_t kSetBackRows = 20;

bool of_one_pose(const Arrival& a, const Arrival& b) {
  if (a.epoch != b.epoch) return false;
  return a.epoch != kNoEpoch || b.time_s - a.time_s <= kSamePing_s;
}

/// Marks that a sink is being called, until it has returned or thrown.
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

/// As in files: a row that comes twice is one measurement.
bool is_repeated(const Arrival& a, const std::vector<Arrival>& in_order_of_time) {
  for (auto b = in_order_of_time.rbegin(); b != in_order_of_time.rend() && b->time_s == a.time_s; ++b)
    if (b->beacon == a.beacon && b->receiver == a.receiver && b->epoch == a.epoch && b->tof_s == a.tof_s &&
        is_same(b->amplitude_v, a.amplitude_v) && is_same(b->temperature_degC, a.temperature_degC))
      return true;
  return false;
}

bool can_be_tracked(const Deployment& d) { return d.timing.clock == Clock::kSynchronised; }

/// By as much the place may be another one by another calibration: sigmas of 5 cm and 0.01 rad, squared.
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

Follower::Follower(Deployment deployment, const FollowOptions& options)
    : deployment_(std::move(deployment)), options_(options), lanes_(deployment_.vehicles.size()) {
  const bool by_tracker = options_.method == Method::kTracker;
  for (Lane& lane : lanes_) {
    lane.waiting.reserve(options_.most_waiting);
    if (!by_tracker) {
      const Method method = options_.method == Method::kAuto ? Method::kLeastSquares : options_.method;
      lane.localizer = make_localizer(method, deployment_);
    }
    if (may_track()) lane.tracker = make_tracker();
  }
  if (options_.watch) watch_ = std::make_unique<Watch>(deployment_, options_.watching);
}

std::unique_ptr<DriveTracker> Follower::make_tracker() const {
  TrackerOptions options;
  options.protect = true;  // a robot that drives by these fixes asks how far they may be off
  return std::make_unique<DriveTracker>(deployment_, options_.odometry, options);
}

bool Follower::may_track() const {
  return options_.method == Method::kTracker ||
         (options_.method == Method::kAuto && can_be_tracked(deployment_));
}

Follower::Lane* Follower::lane_of(VehicleId vehicle) {
  return vehicle.valid() && vehicle.index() < lanes_.size() ? &lanes_[vehicle.index()] : nullptr;
}

bool Follower::hear(const Arrival& arrival) {
  Lane* lane = lane_of(arrival.vehicle);
  if (in_sink_ || lane == nullptr || !std::isfinite(arrival.time_s) ||
      (arrival.time_s < lane->last_arrival_s && !is_set_back(*lane, lane->arrivals_behind, arrival.time_s))) {
    ++counts_.refused;
    return false;
  }
  lane->arrivals_behind = {};
  if (is_repeated(arrival, lane->waiting)) {
    ++counts_.refused;
    return false;
  }
  ++counts_.arrivals;
  lane->last_arrival_s = arrival.time_s;
  if (lane->row_s || lane->localizer == nullptr) {  // tracked: until its odometry comes
    if (lane->waiting.size() >= options_.most_waiting) {
      lane->waiting.erase(lane->waiting.begin());
      ++counts_.dropped;
    }
  } else if (!lane->waiting.empty() &&
             (!of_one_pose(lane->waiting.back(), arrival) || lane->waiting.size() >= options_.most_waiting)) {
    fix_pose(*lane);
  }
  lane->waiting.push_back(arrival);
  return true;
}

/// Whether a row behind the vehicle's time is the last that it takes to believe it; then all begins anew.
bool Follower::is_set_back(Lane& lane, Behind& behind, double time_s) {
  behind = {behind.rows > 0 && time_s >= behind.last_s ? behind.rows + 1 : 1, time_s};
  if (behind.rows < kSetBackRows) return false;
  begin_anew(lane);
  return true;
}

void Follower::begin_anew(Lane& lane) {
  ++counts_.restarts;
  if (lane.has_open_pose()) fix_pose(lane);
  counts_.dropped += lane.waiting.size();
  lane.waiting.clear();
  lane.last_arrival_s = -std::numeric_limits<double>::infinity();
  lane.row_s.reset();
  lane.arrivals_behind = lane.odometry_behind = {};
  if (lane.tracker) lane.tracker = make_tracker();
}

bool Follower::move(const OdometryStep& step) {
  Lane* lane = lane_of(step.vehicle);
  const double longest_m = std::max({std::abs(step.dx_m), std::abs(step.dy_m), std::abs(step.dz_m)});
  const bool is_possible = std::isfinite(step.time_s) && step.is_finite() && longest_m <= kLargestLength_m;
  if (in_sink_ || lane == nullptr || !is_possible ||
      (lane->row_s && step.time_s <= *lane->row_s &&
       !is_set_back(*lane, lane->odometry_behind, step.time_s))) {
    ++counts_.refused;
    return false;
  }
  lane->odometry_behind = {};
  ++counts_.odometry_rows;
  if (lane->tracker == nullptr) return true;  // of no use to the method
  if (!lane->row_s) {                         // the anchor: what it says is no motion
    if (lane->has_open_pose()) fix_pose(*lane);
    lane->row_s = lane->now_s = step.time_s;
    return true;
  }
  track_until(*lane, step, step.time_s - *lane->row_s);
  lane->row_s = step.time_s;
  return true;
}

void Follower::flush() {
  if (in_sink_) return;
  for (Lane& lane : lanes_)
    if (lane.has_open_pose()) fix_pose(lane);
}

void Follower::flush_pings() {
  if (in_sink_) return;
  for (Lane& lane : lanes_)
    if (lane.has_open_pose() && lane.waiting.back().epoch == kNoEpoch) fix_pose(lane);
}

void Follower::carry_on(const Follower& before) {
  counts_ = before.counts_;
  const NameTable names = names_of(before.deployment_);
  for (std::size_t v = 0; v < lanes_.size(); ++v) {
    const auto at = std::ranges::find(names.vehicles, deployment_.vehicles[v].name);
    if (at == names.vehicles.end()) continue;
    const Lane& old = before.lanes_[static_cast<std::size_t>(at - names.vehicles.begin())];
    Lane& lane = lanes_[v];
    lane.last_arrival_s = old.last_arrival_s;
    if (!old.row_s || lane.tracker == nullptr) continue;
    lane.row_s = old.row_s;
    lane.now_s = old.now_s;
    if (!old.tracker->is_placed()) continue;
    if (before.deployment_.motion != deployment_.motion) continue;
    lane.tracker->start(old.tracker->pose(),
                        old.tracker->covariance() + between_calibrations(deployment_.motion));
  }
}

void Follower::fix_pose(Lane& lane) {
  lane.localizer->locate(Observations{lane.waiting, {}}, fix_);
  if (fix_.rejections.empty())
    fix_.time_s = lane.waiting.front().time_s;  // nothing to fix: no instant either
  report_fix(lane.waiting);
  if (watch_ && fix_.ok()) report_alarm(watch_->observe_epoch(lane.waiting, fix_));
  lane.waiting.clear();
}

/// Moves the tracker along a row, and fixes it at each instant of arrivals on the way.
void Follower::track_until(Lane& lane, const OdometryStep& step, double span_s) {
  std::size_t first = 0;
  const auto move_to = [&](double time_s) {
    if (time_s > lane.now_s) lane.tracker->move(step, (time_s - lane.now_s) / span_s);
    lane.now_s = std::max(lane.now_s, time_s);
  };
  while (first < lane.waiting.size() && lane.waiting[first].time_s <= step.time_s) {
    std::size_t last = first;
    while (last < lane.waiting.size() && lane.waiting[last].time_s == lane.waiting[first].time_s) ++last;
    if (lane.waiting[first].time_s < lane.now_s) {  // from before the anchor
      counts_.dropped += last - first;
    } else {
      move_to(lane.waiting[first].time_s);
      track_instant(lane, std::span(lane.waiting).subspan(first, last - first));
    }
    first = last;
  }
  lane.waiting.erase(lane.waiting.begin(), lane.waiting.begin() + static_cast<std::ptrdiff_t>(first));
  move_to(step.time_s);
}

void Follower::track_instant(Lane& lane, std::span<const Arrival> arrivals) {
  if (watch_ && lane.tracker->is_placed())
    for (const Arrival& a : arrivals)
      report_alarm(watch_->observe_arrival(a, lane.tracker->pose(), lane.tracker->covariance()));
  lane.tracker->locate(Observations{arrivals, {}}, fix_);
  fix_.time_s = arrivals.front().time_s;
  report_fix(arrivals);
}

void Follower::report_alarm(const std::optional<WatchAlarm>& alarm) {
  if (!alarm) return;
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
