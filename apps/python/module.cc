// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant._octant: implementation of the Python package octant. It converts arguments and results; estimation
// is in the libraries.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "apps/octant/steps/steps.h"
#include "apps/python/arrays.h"
#include "apps/python/calls.h"
#include "apps/python/live.h"
#include "apps/python/run.h"
#include "io/deployment/deployment_json.h"
#include "io/run/run_folder.h"
#include "io/run/tum.h"
#include "io/site/scenario_yaml.h"
#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"
#include "models/physics/unit_rotation.h"
#include "models/simulator/synthetic.h"
#include "models/support/largest.h"

namespace octant::python {
namespace {

namespace py = pybind11;
using namespace py::literals;

/// Calls a function without Python's lock and raises its error with the lock.
template <class Call>
auto unlocked(Call&& call) {
  auto result = [&] {
    const py::gil_scoped_release others_may_run;
    return call();
  }();
  if (!result) raise(result.error());
  if constexpr (!std::is_void_v<typename decltype(result)::value_type>) return std::move(*result);
}

NameTable names_in(const py::object& of) {
  if (py::isinstance<Site>(of)) return names_of(of.cast<const Site&>());
  if (py::isinstance<Deployment>(of)) return names_of(of.cast<const Deployment&>());
  throw py::type_error("names are those of a Site or a Deployment");
}

Run read_run(const std::string& folder, const py::object& of, bool truth) {
  const NameTable names = names_in(of);
  Timing timing;
  Medium medium;
  if (py::isinstance<Site>(of)) {
    timing = of.cast<const Site&>().timing;
    medium = of.cast<const Site&>().medium;
  } else {
    timing = of.cast<const Deployment&>().timing;
    medium = of.cast<const Deployment&>().medium;
  }
  io::ReadRunOptions options{.read_truth = truth};
  if (medium.model == MediumModel::kConstant) options.constant_speed_mps = medium.speed_mps;
  return {unlocked([&] { return io::read_run(folder, names, timing, options); }), names};
}

/// Arrays are rejected for the same reasons as rows of files.
void expect(bool holds, const char* message) {
  if (!holds) throw py::value_error(message);
}

template <class Value>
using Array = py::array_t<Value, py::array::c_style | py::array::forcecast>;

/// Rows of numbers as odometry: 4 columns in the plane, 8 in space.
std::vector<OdometryStep> steps_of(const Array<double>& rows, VehicleId vehicle) {
  const bool in_space = rows.ndim() == 2 && rows.shape(1) == 8;
  if (rows.ndim() != 2 || (rows.shape(1) != 4 && !in_space))
    throw py::value_error(
        "odometry: rows of time_s, dx_m, dy_m, dheading_rad are expected, or in space of time_s, dx_m, dy_m, "
        "dz_m, qx, qy, qz, qw");
  std::vector<OdometryStep> steps;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    OdometryStep step{
        .time_s = rows.at(i, 0), .dx_m = rows.at(i, 1), .dy_m = rows.at(i, 2), .vehicle = vehicle};
    for (py::ssize_t column = 0; column < rows.shape(1); ++column)
      expect(std::isfinite(rows.at(i, column)), "odometry: a number is expected in each place");
    for (py::ssize_t column = 1; column < (in_space ? 4 : 3); ++column)
      expect(std::abs(rows.at(i, column)) <= kLargestLength_m, "odometry: metres are expected, at most 1e9");
    if (!steps.empty() && !(step.time_s > steps.back().time_s))
      throw py::value_error("odometry: time_s does not increase");
    if (in_space) {
      const auto rotation = unit_rotation(rows.at(i, 4), rows.at(i, 5), rows.at(i, 6), rows.at(i, 7));
      if (!rotation) throw py::value_error("odometry: a quaternion of no length");
      step.set_pose({{step.dx_m, step.dy_m, rows.at(i, 3)}, *rotation});
    } else {
      step.dheading_rad = rows.at(i, 3);
    }
    steps.push_back(step);
  }
  return steps;
}

Run make_run(const py::object& of, const Array<double>& time_s, const Array<std::int32_t>& beacon,
             const Array<double>& tof_s, const std::optional<Array<std::int32_t>>& receiver,
             const std::optional<Array<std::int64_t>>& epoch, const std::optional<Array<double>>& amplitude_v,
             const std::optional<Array<double>>& temperature_degC,
             const std::optional<Array<double>>& odometry, std::int32_t vehicle,
             const OdometrySigmas& noise) {
  Run run{{}, names_in(of)};
  run.log.odometry_accuracy = odometry_noise(noise);
  const auto size = time_s.size();
  const auto check = [size](const char* name, const auto& array) {
    if (array.ndim() != 1 || array.size() != size)
      throw py::value_error(std::string(name) + ": one entry an arrival is expected, as in time_s");
  };
  check("time_s", time_s);
  check("beacon", beacon);
  check("tof_s", tof_s);
  if (receiver) check("receiver", *receiver);
  if (epoch) check("epoch", *epoch);
  if (amplitude_v) check("amplitude_v", *amplitude_v);
  if (temperature_degC) check("temperature_degC", *temperature_degC);
  expect(vehicle >= 0 && static_cast<std::size_t>(vehicle) < run.names.vehicles.size(),
         "vehicle: there is none of this number");
  const ReceiverId only = run.names.find_receiver(VehicleId(vehicle), "");
  if (!receiver && !only.valid()) throw py::value_error("receiver: the vehicle has not just one");
  run.log.has_epochs = epoch.has_value();
  run.log.vehicle = VehicleId(vehicle);
  run.log.arrivals.resize(static_cast<std::size_t>(size));
  for (py::ssize_t i = 0; i < size; ++i) {
    Arrival& a = run.log.arrivals[static_cast<std::size_t>(i)];
    a.time_s = time_s.at(i);
    a.tof_s = tof_s.at(i);
    a.beacon = BeaconId(beacon.at(i));
    a.receiver = receiver ? ReceiverId(receiver->at(i)) : only;
    a.vehicle = VehicleId(vehicle);
    if (epoch) a.epoch = epoch->at(i);
    if (amplitude_v) a.amplitude_v = amplitude_v->at(i);
    if (temperature_degC) a.temperature_degC = temperature_degC->at(i);
    expect(std::isfinite(a.time_s), "time_s: a number is expected in each place");
    expect(i == 0 || a.time_s >= time_s.at(i - 1), "time_s decreases");
    expect(!(std::abs(a.temperature_degC) > 100.0),
           "temperature_degC: degrees Celsius from -100 to 100 are expected (20 degC are 293 K)");
  }
  if (odometry) run.log.odometry = steps_of(*odometry, VehicleId(vehicle));
  run.log.rows = run.log.arrivals.size();
  return run;
}

Fixes localize(const Deployment& deployment, const Run& run, const std::string& method) {
  const Method how = method_named(method);
  expect(same_names(run.names, names_of(deployment)),
         "the run was read by other names than the deployment's: read_run(folder, deployment)");
  auto found = unlocked([&] { return app::localize_runs(deployment, {run.log}, how); });
  return {std::move(found.fixes), names_of(deployment), found.speeds.front()};
}

template <class Owner>
py::array positions(const py::object& self, Owner* first, std::size_t count, const double* at) {
  return py::array(py::dtype::of<double>(), {count, std::size_t{3}}, {sizeof(Owner), sizeof(double)},
                   first == nullptr ? nullptr : at, self);
}

/// One 3 x 3 covariance for each beacon.
py::array_t<double> beacon_covariances(const Deployment& d) {
  py::array_t<double> all({d.beacons.size(), std::size_t{3}, std::size_t{3}});
  auto out = all.mutable_unchecked<3>();
  for (py::ssize_t b = 0; b < out.shape(0); ++b)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) out(b, i, j) = d.beacons[static_cast<std::size_t>(b)].covariance_m2(i, j);
  return all;
}

void bind_site(py::module_& m) {
  py::class_<Site>(m, "Site", "What is known of a site before calibration: a site file.")
      .def_readonly("name", &Site::name)
      .def_readonly("path", &Site::path)
      .def_readonly("warnings", &Site::warnings)
      .def_property_readonly("beacons", [](const Site& s) { return names_of(s).beacons; })
      .def_property_readonly("vehicles", [](const Site& s) { return names_of(s).vehicles; })
      .def("to_yaml", &io::site_to_yaml, "Text of a site file.");
}

void bind_deployment(py::module_& m) {
  py::class_<Deployment>(m, "Deployment", "What calibration found: all that a localizer needs.")
      .def_readonly("site", &Deployment::site)
      .def_readonly("created", &Deployment::created)
      .def_readonly("digest", &Deployment::digest)
      .def_property_readonly("beacons", [](const Deployment& d) { return names_of(d).beacons; })
      .def_property_readonly("vehicles", [](const Deployment& d) { return names_of(d).vehicles; })
      .def_property_readonly(
          "receivers",
          [](const Deployment& d) {
            std::vector<std::pair<std::string, std::string>> names;
            for (const auto& r : d.receivers) names.emplace_back(d.vehicles[r.vehicle.index()].name, r.name);
            return names;
          },
          "(vehicle, receiver) of each, in the order of their numbers.")
      .def_property_readonly("beacon_status",
                             [](const Deployment& d) {
                               std::vector<std::string> status;
                               for (const auto& b : d.beacons) status.emplace_back(to_string(b.status));
                               return status;
                             })
      .def_property_readonly(
          "beacon_positions_m",
          [](const py::object& self) {
            auto& d = self.cast<Deployment&>();
            return positions(self, d.beacons.data(), d.beacons.size(),
                             d.beacons.empty() ? nullptr : d.beacons[0].position_m.data());
          },
          "Rows x, y, z; a view, no copy.")
      .def_property_readonly(
          "receiver_positions_m",
          [](const py::object& self) {
            auto& d = self.cast<Deployment&>();
            return positions(self, d.receivers.data(), d.receivers.size(),
                             d.receivers.empty() ? nullptr : d.receivers[0].position_m.data());
          },
          "Rows x, y, z in the vehicle frame; a view, no copy.")
      .def_property_readonly("beacon_covariances_m2", &beacon_covariances)
      .def_property_readonly(
          "covariance_parameters",
          [](const Deployment& d) { return parameter_names(d.covariance.parameters, names_of(d)); })
      .def_property_readonly(
          "covariance",
          [](const py::object& self) {
            auto& C = self.cast<Deployment&>().covariance.matrix;
            const auto n = static_cast<std::size_t>(C.rows());
            return py::array(py::dtype::of<double>(), {n, n}, {sizeof(double), n * sizeof(double)}, C.data(),
                             self);
          },
          "Joint covariance of covariance_parameters; a view, no copy.")
      .def("speed_mps", &Deployment::speed_mps, "temperature_degC"_a, "Speed of sound (or light) [m/s].")
      .def("to_json", &io::deployment_to_json, "Text of a deployment file.")
      .def(
          "write",
          [](const Deployment& d, const std::string& path) {
            unlocked([&] { return io::write_deployment(path, d); });
          },
          "path"_a, "Writes the deployment file, whole or not at all.");
}

void bind_run(py::module_& m) {
  py::class_<Run>(m, "Run", "One recording.")
      .def_property_readonly("path", [](const Run& r) { return r.log.path; })
      .def_property_readonly("warnings", [](const Run& r) { return r.log.warnings; })
      .def_property_readonly("has_epochs", [](const Run& r) { return r.log.has_epochs; })
      .def_property_readonly(
          "arrivals", [](const py::object& self) { return view(self.cast<Run&>().log.arrivals, self); },
          "Structured array, a view: changing it changes the run.")
      .def_property_readonly(
          "bearings", [](const py::object& self) { return view(self.cast<Run&>().log.bearings, self); })
      .def_property_readonly(
          "odometry", [](const py::object& self) { return view(self.cast<Run&>().log.odometry, self); })
      .def_property_readonly(
          "poses", [](const Run& r) { return poses_array(r.log.poses); },
          "Rows time_s, x, y, z, qx, qy, qz, qw.")
      .def_property_readonly(
          "truth", [](const Run& r) { return poses_array(r.log.truth); },
          "The reference, as poses; empty where it was not read.")
      .def("__len__", [](const Run& r) { return r.log.arrivals.size(); })
      .def(
          "write",
          [](const Run& r, const std::string& folder) {
            unlocked([&] { return io::write_run(folder, r.log, r.names); });
          },
          "folder"_a, "Writes a run folder.");
}

void bind_fixes(py::module_& m) {
  py::class_<Fixes>(m, "Fixes", "Where the vehicle was.")
      .def_property_readonly(
          "table",
          [](const Fixes& f) {
            std::vector<FixRow> rows;
            for (const Fix& fix : f.fixes) rows.push_back(row_of(fix));
            return own(std::move(rows));
          },
          "Structured array with one row for each fix; unknown values are nan. covariance: 6 x 6, of x, y, z "
          "[m] and of small rotations about x, y, z of the map [rad]. velocity_mps and turn_rate_radps: 3 "
          "numbers, along and about x, y, z of the vehicle, with their standard deviations in "
          "sigma_velocity_mps and "
          "sigma_turn_rate_radps.")
      .def_property_readonly("status",
                             [](const Fixes& f) {
                               std::vector<std::string> status;
                               for (const Fix& fix : f.fixes) status.emplace_back(to_string(fix.status));
                               return status;
                             })
      .def_property_readonly(
          "rejections",
          [](const Fixes& f) {
            std::vector<std::vector<std::string>> all;
            for (const Fix& fix : f.fixes) {
              all.emplace_back();
              for (const Rejection r : fix.rejections) all.back().emplace_back(to_string(r));
            }
            return all;
          },
          "Of each fix, what became of each arrival.")
      .def_property_readonly(
          "speed",
          [](const Fixes& f) -> py::object {
            if (!f.speed || !f.speed->determined) return py::none();
            return py::dict("offset_mps"_a = f.speed->offset_mps, "sigma_mps"_a = f.speed->sigma_mps,
                            "taken"_a = f.speed->differs());
          },
          "What the arrivals of a run at an unknown temperature say of the speed; None: it is known, or they "
          "do "
          "not tell.")
      .def("__len__", [](const Fixes& f) { return f.fixes.size(); })
      .def("to_tum", [](const Fixes& f) { return io::fixes_to_tum(f.fixes); })
      .def("to_csv", [](const Fixes& f) { return io::fixes_to_csv(f.fixes, f.names); });
}

void bind_world(py::module_& m) {
  py::class_<World>(m, "World", "A simulated site with known truth.")
      .def_readonly("site", &World::site)
      .def_property_readonly("run",
                             [](const World& w) {
                               return Run{w.run, names_of(w.site)};
                             })
      .def_property_readonly("heldout",
                             [](const World& w) {
                               return Run{w.heldout, names_of(w.site)};
                             })
      .def_readonly("truth", &World::truth, "The true deployment.");
}

void bind_values(py::module_& m) {
  bind_site(m);
  bind_deployment(m);
  bind_run(m);
  bind_fixes(m);
  bind_world(m);
}

}  // namespace

bool same_names(const NameTable& a, const NameTable& b) {
  return a.beacons == b.beacons && a.vehicles == b.vehicles &&
         std::equal(a.receivers.begin(), a.receivers.end(), b.receivers.begin(), b.receivers.end(),
                    [](const NameTable::Receiver& one, const NameTable::Receiver& other) {
                      return one.name == other.name && one.vehicle == other.vehicle;
                    });
}

PYBIND11_MODULE(_octant, m) {
  m.doc() = "Calibration and survey of time-of-flight beacon positioning; import octant instead.";
  m.attr("__version__") = OCTANT_VERSION;
  register_rows();
  bind_values(m);
  bind_live(m);
  m.def(
      "read_site", [](const std::string& path) { return unlocked([&] { return io::read_site(path); }); },
      "path"_a);
  m.def(
      "read_deployment",
      [](const std::string& path) { return unlocked([&] { return io::read_deployment(path); }); }, "path"_a);
  m.def("read_run", &read_run, "folder"_a, "names"_a, "truth"_a = false);
  m.def("make_run", &make_run, "names"_a, "time_s"_a, "beacon"_a, "tof_s"_a, "receiver"_a = py::none(),
        "epoch"_a = py::none(), "amplitude_v"_a = py::none(), "temperature_degC"_a = py::none(),
        "odometry"_a = py::none(), "vehicle"_a = 0, "odometry_noise"_a = py::none());
  m.def("localize", &localize, "deployment"_a, "run"_a, "method"_a = "auto");
  m.def(
      "simulate",
      [](const std::string& scenario, std::uint64_t seed) {
        return unlocked([&]() -> Result<World> {
          auto read = scenario.empty() ? io::scenario_from_yaml(io::bundled_scenario(), "the bundled hall")
                                       : io::read_scenario(scenario);
          if (!read) return fail(read.error());
          return simulate(*read, seed);
        });
      },
      "scenario"_a = "", "seed"_a = 1);
  bind_calls(m);
}

}  // namespace octant::python
