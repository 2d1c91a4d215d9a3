// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/python/live.h"

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include <pybind11/stl.h>

#include "apps/python/calls.h"
#include "models/live/follower.h"
#include "models/physics/unit_rotation.h"

namespace octant::python {
namespace {

namespace py = pybind11;
using namespace py::literals;

/// A follower whose fixes are stored until they are fetched.
struct Live {
  Live(const Deployment& d, const std::string& method, bool watch, const OdometrySigmas& noise,
       double lateness_s)
      : names(names_of(d)) {
    FollowOptions options;
    options.method = method_named(method);
    options.watch = watch;
    if (!(lateness_s >= 0.0) || !std::isfinite(lateness_s))
      throw py::value_error("lateness is not a number from 0 on");
    options.lateness_s = lateness_s;
    options.odometry = odometry_noise(noise);
    if (auto fits = follow_fits(d, options.method); !fits) raise(fits.error());
    follower = std::make_unique<Follower>(d, options);
    follower->on_fix = [this](const Fix& fix) { fixes.push_back(fix); };
    follower->on_alarm = [this](const WatchAlarm& alarm) { alarms.push_back(alarm); };
  }
  NameTable names;
  std::unique_ptr<Follower> follower;
  std::vector<Fix> fixes;
  std::vector<WatchAlarm> alarms;
};

py::dict alarm_dict(const WatchAlarm& alarm, const NameTable& names) {
  py::dict found("kind"_a = to_string(alarm.kind), "time_s"_a = alarm.time_s, "since_s"_a = alarm.since_s,
                 "size_m"_a = alarm.size_m, "sigma_m"_a = alarm.sigma_m,
                 "shift_m"_a = std::vector<double>(alarm.shift_m.begin(), alarm.shift_m.end()));
  if (alarm.beacon.valid()) {
    found["beacon"] = names.beacons[alarm.beacon.index()];
  } else {
    const NameTable::Receiver& receiver = names.receivers[alarm.receiver.index()];
    found["receiver"] = names.vehicles[receiver.vehicle.index()] + "/" + receiver.name;
  }
  return found;
}

using Quaternion = std::optional<std::array<double, 4>>;

Eigen::Quaterniond rotation_of(double heading_rad, const char* heading, const Quaternion& xyzw) {
  if (!xyzw) return Pose::planar(0.0, 0.0, heading_rad).rotation;
  const auto [qx, qy, qz, qw] = *xyzw;
  const auto rotation = unit_rotation(qx, qy, qz, qw);
  if (!rotation) throw py::value_error("quaternion_xyzw: a quaternion of no length");
  if (heading_rad != 0.0)
    throw py::value_error("quaternion_xyzw is in place of " + std::string(heading) + ": one of them");
  return *rotation;
}

bool move(Live& live, double time_s, double dx_m, double dy_m, double dheading_rad,
          const std::string& vehicle, double dz_m, const Quaternion& xyzw) {
  const Eigen::Quaterniond rotation = rotation_of(dheading_rad, "dheading_rad", xyzw);
  OdometryStep step{.time_s = time_s,
                    .dx_m = dx_m,
                    .dy_m = dy_m,
                    .dheading_rad = dheading_rad,
                    .vehicle = live.names.find_vehicle(vehicle),
                    .dz_m = dz_m};
  if (xyzw) step.set_pose({{dx_m, dy_m, dz_m}, rotation});
  return live.follower->move(step);
}

bool move_to(Live& live, double time_s, double x_m, double y_m, double heading_rad,
             const std::string& vehicle, double z_m, const Quaternion& xyzw) {
  return live.follower->move(
      OdometryPose{.time_s = time_s,
                   .T_odometry_vehicle = {{x_m, y_m, z_m}, rotation_of(heading_rad, "heading_rad", xyzw)},
                   .vehicle = live.names.find_vehicle(vehicle)});
}

Fixes predicted(Live& live, double time_s, const std::string& vehicle) {
  Fixes one{{Fix{}}, live.names};
  live.follower->predict(live.names.find_vehicle(vehicle), time_s, one.fixes.front());
  return one;
}

void bind_results(py::class_<Live>& follower) {
  follower
      .def(
          "take",
          [](Live& live) {
            Fixes taken{std::move(live.fixes), live.names};
            live.fixes.clear();
            return taken;
          },
          "The fixes since the last call, as Fixes. A fix without a pose has its reason in `status`.")
      .def(
          "take_alarms",
          [](Live& live) {
            std::vector<py::dict> taken;
            for (const WatchAlarm& alarm : live.alarms) taken.push_back(alarm_dict(alarm, live.names));
            live.alarms.clear();
            return taken;
          },
          "The alarms of the watch since the last call: dicts with the keys of `octant schema live`.")
      .def("predict", &predicted, "time_s"_a, "vehicle"_a = "",
           "Fixes with the pose predicted to a time [s], without a change of the state. Its status is ok if "
           "the vehicle is tracked.");
}

}  // namespace

Method method_named(const std::string& name) {
  std::string listed;
  for (const auto& [spelling, method] : method_names()) {
    if (spelling == name) return method;
    listed += (listed.empty() ? "" : ", ") + std::string(spelling);
  }
  throw py::value_error("there is no method '" + name + "'; expected one of " + listed);
}

OdometryAccuracy odometry_noise(const OdometrySigmas& sigmas) {
  OdometryAccuracy accuracy;
  const std::map<std::string, double*> known = {
      {"distance_sigma_m_per_sqrt_m", &accuracy.distance_sigma_m_per_sqrt_m},
      {"heading_sigma_rad_per_sqrt_m", &accuracy.heading_sigma_rad_per_sqrt_m},
      {"heading_sigma_per_rad", &accuracy.heading_sigma_per_rad},
      {"floor_m", &accuracy.floor_m},
      {"floor_rad", &accuracy.floor_rad}};
  if (!sigmas) return accuracy;
  for (const auto& [name, value] : *sigmas) {
    const auto at = known.find(name);
    if (at == known.end())
      throw py::value_error("odometry_noise: there is no '" + name + "'; see octant schema run");
    if (!(value >= 0.0) || !std::isfinite(value))
      throw py::value_error("odometry_noise: " + name + " is not a number from 0 on");
    *at->second = value;
  }
  return accuracy;
}

void bind_live(py::module_& m) {
  py::class_<Live> follower(m, "Follower",
                            "Localizes live data; see octant localize --follow. SI units; map with z up, "
                            "vehicle with x forward, y left, z up.");
  follower
      .def(
          py::init<const Deployment&, const std::string&, bool, const OdometrySigmas&, double>(),
          "deployment"_a, "method"_a = "auto", "watch"_a = false, "odometry_noise"_a = py::none(),
          "lateness"_a = 0.2,
          "watch: also monitors beacons and receivers (take_alarms). odometry_noise: a dict with the keys of "
          "run.yaml's block odometry. lateness: seconds within which arrivals and odometry may come in any "
          "order. Raises ValueError for an unknown method or an invalid number.")
      .def(
          "hear",
          [](Live& live, double time_s, const std::string& beacon, double tof_s, const std::string& receiver,
             const std::string& vehicle, std::optional<std::int64_t> epoch, std::optional<double> amplitude_v,
             std::optional<double> temperature_degC) {
            auto arrival = arrival_of(live.names, beacon, tof_s, time_s, receiver, vehicle);
            if (!arrival) raise(arrival.error());
            if (epoch) arrival->epoch = *epoch;
            arrival->amplitude_v = amplitude_v.value_or(std::numeric_limits<double>::quiet_NaN());
            arrival->temperature_degC = temperature_degC.value_or(std::numeric_limits<double>::quiet_NaN());
            return live.follower->hear(*arrival);
          },
          "time_s"_a, "beacon"_a, "tof_s"_a, "receiver"_a = "", "vehicle"_a = "", "epoch"_a = py::none(),
          "amplitude_v"_a = py::none(), "temperature_degC"_a = py::none(),
          "Adds an arrival: time and time of flight [s], amplitude [V] and temperature of the air [degC] if "
          "they are measured. False: it is too late, or repeats another one. Raises InputError for an "
          "unknown name.")
      .def("move", &move, "time_s"_a, "dx_m"_a, "dy_m"_a, "dheading_rad"_a = 0.0, "vehicle"_a = "",
           "dz_m"_a = 0.0, "quaternion_xyzw"_a = py::none(),
           "Adds a row of odometry [s, m, rad]; in space with dz_m, and quaternion_xyzw (4 numbers) in place "
           "of dheading_rad. False: it is too late. Raises ValueError for an invalid quaternion.")
      .def("move_to", &move_to, "time_s"_a, "x_m"_a, "y_m"_a, "heading_rad"_a = 0.0, "vehicle"_a = "",
           "z_m"_a = 0.0, "quaternion_xyzw"_a = py::none(),
           "Adds the pose in the frame of the odometry [s, m, rad], as move() does for steps. A lost row "
           "loses no motion.")
      .def(
          "flush", [](Live& live) { live.follower->flush(); },
          "Fixes the waiting arrivals, because no more will come for this pose.");
  bind_results(follower);
}

}  // namespace octant::python
