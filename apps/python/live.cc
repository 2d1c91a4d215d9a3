// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/python/live.h"

#include <array>
#include <cmath>
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
  py::class_<Live>(m, "Follower", "Localizes as the data come; see octant localize --follow.")
      .def(
          py::init<const Deployment&, const std::string&, bool, const OdometrySigmas&, double>(),
          "deployment"_a, "method"_a = "auto", "watch"_a = false, "odometry_noise"_a = py::none(),
          "lateness"_a = 0.2,
          "odometry_noise: a dict with the keys of run.yaml's block odometry. lateness: seconds within which "
          "arrivals and odometry may come in any order.")
      .def(
          "hear",
          [](Live& live, double time_s, const std::string& beacon, double tof_s, const std::string& receiver,
             const std::string& vehicle, std::optional<std::int64_t> epoch) {
            auto arrival = arrival_of(live.names, beacon, tof_s, time_s, receiver, vehicle);
            if (!arrival) raise(arrival.error());
            if (epoch) arrival->epoch = *epoch;
            return live.follower->hear(*arrival);
          },
          "time_s"_a, "beacon"_a, "tof_s"_a, "receiver"_a = "", "vehicle"_a = "", "epoch"_a = py::none(),
          "One arrival; False: it runs backwards in time, or repeats another one.")
      .def(
          "move",
          [](Live& live, double time_s, double dx_m, double dy_m, double dheading_rad,
             const std::string& vehicle, double dz_m, const std::optional<std::array<double, 4>>& xyzw) {
            OdometryStep step{.time_s = time_s,
                              .dx_m = dx_m,
                              .dy_m = dy_m,
                              .dheading_rad = dheading_rad,
                              .vehicle = live.names.find_vehicle(vehicle),
                              .dz_m = dz_m};
            if (xyzw) {
              const auto [qx, qy, qz, qw] = *xyzw;
              const auto rotation = unit_rotation(qx, qy, qz, qw);
              if (!rotation) throw py::value_error("quaternion_xyzw: a quaternion of no length");
              if (dheading_rad != 0.0)
                throw py::value_error("quaternion_xyzw is in place of dheading_rad: one of them");
              step.set_pose({{dx_m, dy_m, dz_m}, *rotation});
            }
            return live.follower->move(step);
          },
          "time_s"_a, "dx_m"_a, "dy_m"_a, "dheading_rad"_a = 0.0, "vehicle"_a = "", "dz_m"_a = 0.0,
          "quaternion_xyzw"_a = py::none(),
          "One row of odometry; in space with dz_m, and quaternion_xyzw in place of dheading_rad.")
      .def(
          "flush", [](Live& live) { live.follower->flush(); }, "Nothing more is coming of this pose.")
      .def(
          "take",
          [](Live& live) {
            Fixes taken{std::move(live.fixes), live.names};
            live.fixes.clear();
            return taken;
          },
          "The fixes since the last call.");
}

}  // namespace octant::python
