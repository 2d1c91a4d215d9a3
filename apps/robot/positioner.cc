// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/robot/octant/positioner.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "io/deployment/deployment_json.h"
#include "models/live/follower.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/physics/unit_rotation.h"
#include "models/plain_fix.h"

namespace octant {
namespace {

Place place_of(const Fix& fix) {
  Place place;
  place.status = to_string(fix.status);
  place.integrity = to_string(integrity(fix));
  place.integrity_reason = integrity_reason(fix);
  place.has_velocity = fix.ok() && fix.velocity.has_value();
  if (!fill_row(fix, place)) return place;
  const bool spatial = fix.covariance.rows() == 6;
  place.sigma_z_m = spatial ? std::sqrt(std::max(fix.covariance(2, 2), 0.0)) : 0.0;
  place.covariance_xy_m2 = fix.covariance(0, 1);
  return place;
}

/// Rotation by a heading or by a quaternion. Returns no value for both, or for a quaternion without length.
std::optional<Eigen::Quaterniond> rotation_of(double heading_rad, double qx, double qy, double qz,
                                              double qw) {
  if (qx == 0.0 && qy == 0.0 && qz == 0.0 && qw == 1.0) return Pose::planar(0.0, 0.0, heading_rad).rotation;
  return heading_rad == 0.0 ? unit_rotation(qx, qy, qz, qw) : std::nullopt;
}

bool is_noise(const OdometryNoise& odometry) {
  const double sigmas[] = {odometry.distance_sigma_m_per_sqrt_m, odometry.heading_sigma_rad_per_sqrt_m,
                           odometry.heading_sigma_per_rad, odometry.floor_m, odometry.floor_rad};
  return std::all_of(std::begin(sigmas), std::end(sigmas),
                     [](double sigma) { return sigma >= 0.0 && std::isfinite(sigma); });
}

}  // namespace

struct Positioner::Inside {
  std::string error;
  NameTable names;
  std::unique_ptr<LeastSquaresLocalizer> at_rest;
  std::unique_ptr<Follower> follower;
  std::function<void(const Place&)> sink;
  std::function<void(const Alarm&)> alarm_sink;
  std::vector<Arrival> arrivals;

  [[nodiscard]] static std::unique_ptr<Inside> make(Result<Deployment> deployment,
                                                    const OdometryNoise& odometry, double lateness_s,
                                                    bool watch) {
    auto inside = std::make_unique<Inside>();
    if (!deployment) {
      inside->error = deployment.error().message();
    } else if (!is_noise(odometry)) {
      inside->error = "the noise of the odometry is no number from 0 on";
    } else if (!(lateness_s >= 0.0) || !std::isfinite(lateness_s)) {
      inside->error = "the lateness is no number from 0 on";
    } else {
      inside->begin(std::move(*deployment), odometry, lateness_s, watch);
    }
    return inside;
  }

  void begin(Deployment deployment, const OdometryNoise& odometry, double lateness_s, bool watch) {
    names = names_of(deployment);
    at_rest = std::make_unique<LeastSquaresLocalizer>(deployment);
    FollowOptions options;
    options.odometry = {.distance_sigma_m_per_sqrt_m = odometry.distance_sigma_m_per_sqrt_m,
                        .heading_sigma_rad_per_sqrt_m = odometry.heading_sigma_rad_per_sqrt_m,
                        .heading_sigma_per_rad = odometry.heading_sigma_per_rad,
                        .floor_m = odometry.floor_m,
                        .floor_rad = odometry.floor_rad};
    options.lateness_s = lateness_s;
    options.watch = watch;
    follower = std::make_unique<Follower>(std::move(deployment), options);
    // The address of this object does not change when a positioner is moved.
    follower->on_fix = [this](const Fix& fix) {
      if (sink) sink(place_of(fix));
    };
    follower->on_alarm = [this](const WatchAlarm& found) {
      if (alarm_sink) alarm_sink(alarm(found));
    };
  }

  /// An unknown name gives an id that is not valid, which every localizer rejects.
  [[nodiscard]] Arrival arrival(const Heard& heard) const {
    Arrival a;
    a.time_s = heard.time_s;
    a.tof_s = heard.tof_s;
    a.beacon = names.find_beacon(heard.beacon);
    a.vehicle = names.find_vehicle(heard.vehicle);
    a.receiver = names.find_receiver(a.vehicle, heard.receiver);
    a.epoch = heard.epoch == Heard::kNone ? kNoEpoch : heard.epoch;
    a.amplitude_v = heard.amplitude_v;
    a.temperature_degC = heard.temperature_degC;
    return a;
  }

  [[nodiscard]] Alarm alarm(const WatchAlarm& found) const {
    Alarm alarm;
    alarm.kind = to_string(found.kind);
    if (found.beacon.valid()) {
      alarm.name = names.beacons[found.beacon.index()];
    } else {
      const NameTable::Receiver& receiver = names.receivers[found.receiver.index()];
      alarm.name = receiver.name;
      alarm.vehicle = names.vehicles[receiver.vehicle.index()];
    }
    for (int i = 0; i < 3; ++i) alarm.shift_m[i] = found.shift_m[i];
    alarm.size_m = found.size_m;
    alarm.sigma_m = found.sigma_m;
    alarm.since_s = found.since_s;
    alarm.time_s = found.time_s;
    return alarm;
  }
};

Positioner::Positioner(std::unique_ptr<Inside> inside) : inside_(std::move(inside)) {}

Positioner::Positioner(const std::string& deployment_path, const OdometryNoise& odometry, double lateness_s,
                       bool watch)
    : Positioner(Inside::make(io::read_deployment(deployment_path), odometry, lateness_s, watch)) {}

Positioner Positioner::from_text(std::string_view deployment, const OdometryNoise& odometry,
                                 double lateness_s, bool watch) {
  return Positioner(Inside::make(io::deployment_from_json(std::string(deployment), "the text"), odometry,
                                 lateness_s, watch));
}

Positioner::~Positioner() = default;
Positioner::Positioner(Positioner&&) noexcept = default;
Positioner& Positioner::operator=(Positioner&&) noexcept = default;

Positioner::operator bool() const noexcept { return inside_ && inside_->at_rest; }
const std::string& Positioner::error() const noexcept { return inside_->error; }

Place Positioner::locate(std::span<const Heard> heard) noexcept {
  if (!*this) return place_of(Fix{});
  inside_->arrivals.clear();
  for (const Heard& one : heard) inside_->arrivals.push_back(inside_->arrival(one));
  return place_of(inside_->at_rest->locate(inside_->arrivals));
}

void Positioner::on_place(std::function<void(const Place&)> sink) { inside_->sink = std::move(sink); }
void Positioner::on_alarm(std::function<void(const Alarm&)> sink) { inside_->alarm_sink = std::move(sink); }

bool Positioner::hear(const Heard& heard) {
  if (!*this) return false;
  const Arrival arrival = inside_->arrival(heard);
  return inside_->follower->hear(arrival) && arrival.beacon.valid() && arrival.receiver.valid();
}

bool Positioner::move(const Moved& moved) {
  if (!*this) return false;
  const auto rotation = rotation_of(moved.dheading_rad, moved.qx, moved.qy, moved.qz, moved.qw);
  if (!rotation) return false;
  OdometryStep step{.time_s = moved.time_s,
                    .dx_m = moved.dx_m,
                    .dy_m = moved.dy_m,
                    .dheading_rad = moved.dheading_rad,
                    .vehicle = inside_->names.find_vehicle(moved.vehicle),
                    .dz_m = moved.dz_m};
  if (moved.dheading_rad == 0.0) step.set_pose({{moved.dx_m, moved.dy_m, moved.dz_m}, *rotation});
  return inside_->follower->move(step);
}

bool Positioner::move_to(const MovedTo& pose) {
  if (!*this) return false;
  const auto rotation = rotation_of(pose.heading_rad, pose.qx, pose.qy, pose.qz, pose.qw);
  return rotation && inside_->follower->move(
                         OdometryPose{.time_s = pose.time_s,
                                      .T_odometry_vehicle = {{pose.x_m, pose.y_m, pose.z_m}, *rotation},
                                      .vehicle = inside_->names.find_vehicle(pose.vehicle)});
}

void Positioner::flush() {
  if (*this) inside_->follower->flush();
}

Place Positioner::predict(double time_s, std::string_view vehicle) noexcept {
  Fix fix;
  if (*this) inside_->follower->predict(inside_->names.find_vehicle(vehicle), time_s, fix);
  return place_of(fix);
}

}  // namespace octant
