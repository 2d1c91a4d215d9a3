// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/live_state.h"

#include <algorithm>
#include <cmath>

#include "io/live/live_fixes.h"

namespace octant::app {
namespace {

constexpr std::size_t kMostTrackPoints = 1000, kMostSamples = 600, kMostAlarms = 100;
constexpr double kTrackStep_m = 0.1;

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

}  // namespace

LiveState::LiveState(NameTable names, double lateness_s, bool watch)
    : names_(std::move(names)), receptions_(names_.beacons.size()) {
  options_.lateness_s = lateness_s;
  options_.watch = watch;
}

void LiveState::set_names(const NameTable& names) {
  names_ = names;
  receptions_.resize(names_.beacons.size());
  if (!follower_) return;
  beacon_of_.resize(names_.beacons.size());
  receiver_of_.resize(names_.receivers.size());
  vehicle_of_.resize(names_.vehicles.size());
}

void LiveState::add(const io::LiveRow& row) {
  if (const auto* arrival = std::get_if<Arrival>(&row)) {
    Reception& reception = receptions_[arrival->beacon.index()];
    ++reception.arrivals;
    reception.last = Clock::now();
    newest_s_ = arrival->time_s;
    if (std::isfinite(arrival->temperature_degC)) temperature_degC_ = arrival->temperature_degC;
    if (!follower_) return;
    Arrival mapped = *arrival;
    mapped.beacon = beacon_of_[arrival->beacon.index()];
    mapped.receiver = receiver_of_[arrival->receiver.index()];
    mapped.vehicle = vehicle_of_[arrival->vehicle.index()];
    if (mapped.beacon.valid() && mapped.receiver.valid()) follower_->hear(mapped);
  } else if (!follower_) {
    return;
  } else if (const auto* step = std::get_if<OdometryStep>(&row)) {
    OdometryStep mapped = *step;
    mapped.vehicle = vehicle_of_[step->vehicle.index()];
    if (mapped.vehicle.valid()) follower_->move(mapped);
  } else if (const auto* pose = std::get_if<OdometryPose>(&row)) {
    OdometryPose mapped = *pose;
    mapped.vehicle = vehicle_of_[pose->vehicle.index()];
    if (mapped.vehicle.valid()) follower_->move(mapped);
  } else if (std::holds_alternative<io::LiveFlush>(row)) {
    flush();
  }
}

void LiveState::flush() {
  if (follower_) follower_->flush();
}

void LiveState::use(const Deployment& deployment) {
  if (!follow_fits(deployment, options_.method)) return;
  auto next = std::make_unique<Follower>(deployment, options_);
  next->on_fix = [this](const Fix& fix) { take(fix); };
  next->on_alarm = [this, names = names_of(deployment)](const WatchAlarm& alarm) {
    alarms_.push_back(Json::parse(io::alarm_as_json(alarm, names)));
    if (alarms_.size() > kMostAlarms) alarms_.pop_front();
  };
  if (follower_) {
    follower_->flush();
    next->carry_on(*follower_);
  }
  const NameTable names = names_of(deployment);
  beacon_of_.clear();
  receiver_of_.clear();
  vehicle_of_.clear();
  for (const std::string& name : names_.beacons) beacon_of_.push_back(names.find_beacon(name));
  for (const std::string& name : names_.vehicles) vehicle_of_.push_back(names.find_vehicle(name));
  for (const auto& r : names_.receivers) {
    const VehicleId vehicle = vehicle_of_[r.vehicle.index()];
    receiver_of_.push_back(vehicle.valid() ? names.find_receiver(vehicle, r.name) : ReceiverId());
  }
  follower_ = std::move(next);
}

void LiveState::take(const Fix& fix) {
  fix.ok() ? ++ok_ : ++no_fix_;
  if (!fix.ok()) return;
  fix_ = fix;
  fixed_at_ = Clock::now();
  const Eigen::Vector3d& p = fix.T_map_vehicle.translation_m;
  if (!track_.empty() && std::hypot(p.x() - track_.back()[0], p.y() - track_.back()[1]) < kTrackStep_m)
    return;
  track_.push_back({p.x(), p.y()});
  if (track_.size() > kMostTrackPoints) track_.pop_front();
}

void LiveState::tick() {
  const auto now = Clock::now();
  const double passed_s = std::chrono::duration<double>(now - last_tick_).count();
  if (!(passed_s > 0)) return;
  last_tick_ = now;
  Sample sample{.time_s = newest_s_, .per_s = 0.0, .rms_sigmas = {}, .protection_m = {}};
  for (Reception& r : receptions_) {
    r.per_s = static_cast<double>(r.arrivals - r.at_last_tick) / passed_s;
    r.at_last_tick = r.arrivals;
    sample.per_s += r.per_s;
  }
  if (fix_ && now - fixed_at_ < std::chrono::seconds(2)) {
    if (fix_->arrivals_used > 0) sample.rms_sigmas = std::sqrt(2.0 * fix_->cost / fix_->arrivals_used);
    if (fix_->protection_level_m > 0) sample.protection_m = fix_->protection_level_m;
  }
  history_.push_back(sample);
  if (history_.size() > kMostSamples) history_.pop_front();
}

void LiveState::add_to(Json& state) const {
  const auto now = Clock::now();
  const auto seconds_since = [now](Clock::time_point then) {
    return std::chrono::duration<double>(now - then).count();
  };
  Json beacons = Json::array(), history = Json::array();
  for (std::size_t b = 0; b < receptions_.size(); ++b)
    beacons.push_back(
        {{"id", names_.beacons[b]},
         {"arrivals", receptions_[b].arrivals},
         {"rate_hz", receptions_[b].per_s},
         {"last_s", receptions_[b].arrivals > 0 ? Json(seconds_since(receptions_[b].last)) : Json(nullptr)}});
  state["beacons"] = std::move(beacons);
  state["vehicle"] = nullptr;
  if (fix_) {
    const auto C = covariance_in_map(fix_->covariance, fix_->T_map_vehicle);
    state["vehicle"] = {{"x_m", fix_->T_map_vehicle.translation_m.x()},
                        {"y_m", fix_->T_map_vehicle.translation_m.y()},
                        {"heading_rad", fix_->T_map_vehicle.heading_rad()},
                        {"covariance_xy_m2", {C(0, 0), C(0, 1), C(1, 1)}},
                        {"protection_level_m", fix_->protection_level_m},
                        {"integrity", to_string(integrity(*fix_))},
                        {"age_s", seconds_since(fixed_at_)}};
  }
  state["fixes"] = {{"ok", ok_}, {"no_fix", no_fix_}};
  state["temperature_degC"] = std::isfinite(temperature_degC_) ? Json(temperature_degC_) : Json(nullptr);
  state["track"] = track_;
  for (const Sample& s : history_)
    history.push_back({s.time_s, s.per_s, number_or_null(s.rms_sigmas), number_or_null(s.protection_m)});
  state["history"] = std::move(history);
  state["alarms"] = alarms_;
}

}  // namespace octant::app
