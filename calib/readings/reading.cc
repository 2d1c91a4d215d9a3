// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/reading.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/problem/log_health.h"
#include "calib/problem/site_units.h"
#include "calib/readings/clock_jumps.h"
#include "calib/readings/mixed_units.h"
#include "calib/readings/pose_clock.h"
#include "calib/readings/pose_frames.h"
#include "calib/readings/wiring.h"

namespace octant::calib {
namespace {

/// Control points among which every exchange of two is looked at.
constexpr std::size_t kFewPoints = 4;

Reading unit_reading(const LengthUnit& u, const ScaledParts& parts, const std::string& whose) {
  return {
      {ContradictionKind::kUnits, "positions of " + whose, "metres",
       fmt::format("that they are in {}", u.name), 0.0,
       fmt::format("multiply them (and their sigmas, where these are in {} too) by {:g}", u.name, u.metres)},
      [u, parts](const Site& site) { return in_unit(site, u, parts); },
      {}};
}

std::string path_of_poses(const std::vector<MeasurementLog>& runs) {
  const auto posed =
      std::find_if(runs.begin(), runs.end(), [](const MeasurementLog& run) { return !run.poses.empty(); });
  return posed == runs.end() ? "poses.tum" : posed->path + "/" + pose_file(*posed);
}

}  // namespace

std::vector<Reading> other_ranging(const Site& site) {
  if (site.timing.clock == Clock::kCycleOffset) return {};
  const bool one_way = site.timing.ranging == Ranging::kOneWay;
  const auto read = [one_way](Site other) {
    other.timing.ranging = one_way ? Ranging::kTwoWay : Ranging::kOneWay;
    return other;
  };
  return {Reading{
      {ContradictionKind::kRanging, "the arrivals", one_way ? "one_way" : "two_way",
       one_way ? "that the times of flight are times there and back (two-way), though timing.ranging says "
                 "one_way"
               : "that the times of flight are one-way times, though timing.ranging says two_way, the time "
                 "there and back",
       0.0, one_way ? "state timing.ranging: two_way, and turnaround_s" : "state timing.ranging: one_way"},
      read,
      {}}};
}

std::vector<Reading> other_units(const Site& site, const std::vector<MeasurementLog>& runs, bool some_only) {
  const std::vector<bool> none(site.beacons.size(), false);
  std::vector<bool> all = none;
  for (std::size_t b = 0; b < all.size(); ++b)
    all[b] = std::ranges::any_of(site.beacons[b].position_m, [](const auto& x) { return x.has_value(); });
  const bool placed = std::ranges::find(all, true) != all.end();
  std::vector<Reading> readings;
  for (const LengthUnit& u : length_units()) {
    if (placed && !some_only) readings.push_back(unit_reading(u, {all, false}, "the beacons"));
    if (placed && !some_only) readings.push_back(unit_reading(u, {all, true}, "the beacons and receivers"));
    if (!some_only) readings.push_back(unit_reading(u, {none, true}, "the receivers"));
    std::vector<std::vector<bool>> shares = beacons_in_unit_by_ranges(site, runs, u);
    const std::vector<bool> by_size = beacons_in_unit(site, u);
    if (std::ranges::find(shares, by_size) == shares.end()) shares.push_back(by_size);
    for (const std::vector<bool>& some : shares) {
      std::vector<std::string> names;
      for (std::size_t b = 0; b < some.size(); ++b)
        if (some[b]) names.push_back(site.beacons[b].name);
      if (!names.empty())
        readings.push_back(unit_reading(u, {some, false}, fmt::format("beacons {}", fmt::join(names, ", "))));
    }
  }
  return readings;
}

std::vector<Reading> exchanged_points(const Site& site) {
  std::vector<std::size_t> points;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    if (site.beacons[b].is_control_point()) points.push_back(b);
  std::vector<Reading> readings;
  if (points.size() > kFewPoints) return readings;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const std::size_t a = points[i], b = points[j];
      const std::string names = site.beacons[a].name + ", " + site.beacons[b].name;
      readings.push_back(
          {{ContradictionKind::kExchanged, names, "at the places in the site file", "at each other's places",
            0.0,
            fmt::format("exchange the positions of control points {} and {} in the site file, or their "
                        "labels on the wall",
                        site.beacons[a].name, site.beacons[b].name)},
           [a, b](const Site& stated) {
             Site other = stated;
             std::swap(other.beacons[a].position_m, other.beacons[b].position_m);
             return other;
           },
           {}});
    }
  return readings;
}

std::vector<Reading> other_pose_frames(const std::vector<MeasurementLog>& runs) {
  std::vector<Reading> readings;
  const auto posed = std::ranges::find_if(runs, [](const MeasurementLog& run) { return !run.poses.empty(); });
  if (posed == runs.end()) return readings;
  for (const Reflection& reflection : reflections())
    readings.push_back({{ContradictionKind::kPoses, "in " + pose_file(*posed), "in a right-handed frame",
                         fmt::format("that their frame is left-handed (mirrored): {}", reflection.words), 0.0,
                         "export the poses in a right-handed frame: z up, headings counter-clockwise from x"},
                        {},
                        [read = reflection.read](std::size_t, MeasurementLog& run) {
                          for (TimedPose& pose : run.poses) pose.T_map_vehicle = read(pose.T_map_vehicle);
                        }});
  return readings;
}

Reading poses_of_other_clock(const std::vector<MeasurementLog>& runs, double lag_s) {
  const std::string file = path_of_poses(runs);
  return {
      {ContradictionKind::kPoses, "in " + file, "times by the clock of the arrivals",
       fmt::format("that they are stamped {:.3g} s {}", std::abs(lag_s), lag_s > 0 ? "late" : "early"), 0.0,
       fmt::format("look at how the two clocks are synchronised, or {} {:.3g} s {} each time of {}",
                   lag_s > 0 ? "subtract" : "add", std::abs(lag_s), lag_s > 0 ? "from" : "to", file)},
      {},
      [lag_s](std::size_t, MeasurementLog& run) { take_back_lag(lag_s, run); },
      true};
}

Reading poses_of_other_point(const std::vector<MeasurementLog>& runs, const Eigen::Vector3d& lever_m) {
  const std::string file = path_of_poses(runs);
  return {{ContradictionKind::kPoses, "in " + file, "of the origin of the vehicle's frame",
           fmt::format("that they are of a point at ({:.3f}, {:.3f}, {:.3f}) m on the vehicle", lever_m.x(),
                       lever_m.y(), lever_m.z()),
           0.0,
           "measure where the prism, the antenna or the markers are on the vehicle and give poses of its "
           "origin, or else count the receivers' places from that point"},
          {},
          [lever_m](std::size_t, MeasurementLog& run) {
            for (TimedPose& pose : run.poses)
              pose.T_map_vehicle.translation_m -= pose.T_map_vehicle.rotation * lever_m;
          },
          true};
}

Reading poses_of_other_frame(const std::vector<MeasurementLog>& runs, const Pose& T_map_frame) {
  constexpr double kDegrees = 180.0 / M_PI;
  const double turn = kDegrees * T_map_frame.heading_rad();
  const Eigen::Vector3d& shift = T_map_frame.translation_m;
  return {
      {ContradictionKind::kPoses, "in " + path_of_poses(runs), "in the frame of the control points",
       fmt::format("that the control points are in a frame turned by {:.2f} degrees against theirs", turn),
       0.0,
       fmt::format("measure both in one frame, or turn the poses (headings too) by {:.3f} degrees "
                   "counter-clockwise about the origin and then shift them by ({:.3f}, {:.3f}) m",
                   turn, shift.x(), shift.y())},
      {},
      [T_map_frame](std::size_t, MeasurementLog& run) {
        for (TimedPose& pose : run.poses) pose.T_map_vehicle = T_map_frame * pose.T_map_vehicle;
      },
      true};
}

std::vector<Reading> other_odometry(const std::vector<MeasurementLog>& runs) {
  struct Convention {
    const char* words;
    const char* remedy;
    double way = 1.0, side = 1.0, turn = 1.0;  ///< factors of dx, dy and dheading
  };
  constexpr double kDegree_rad = M_PI / 180.0;
  static const Convention kConventions[] = {
      {"that its turns count clockwise", "negate dheading_rad: counter-clockwise is positive", 1.0, 1.0,
       -1.0},
      {"that it counts the way backward", "negate dx_m: forward is positive", -1.0, 1.0, 1.0},
      {"that y counts to the right and turns clockwise",
       "negate dy_m and dheading_rad: left and counter-clockwise are positive", 1.0, -1.0, -1.0},
      {"that it counts backward and turns clockwise", "negate dx_m and dheading_rad", -1.0, 1.0, -1.0},
      {"that its turns are in degrees", "multiply dheading_rad by pi / 180", 1.0, 1.0, kDegree_rad},
      {"that its way is in millimetres", "multiply dx_m and dy_m by 0.001", 1e-3, 1e-3, 1.0},
      {"that its way is in centimetres", "multiply dx_m and dy_m by 0.01", 1e-2, 1e-2, 1.0},
  };
  const auto driven =
      std::ranges::find_if(runs, [](const MeasurementLog& run) { return !run.odometry.empty(); });
  if (driven == runs.end() ||
      !std::ranges::all_of(driven->odometry, [](const OdometryStep& s) { return s.is_planar(); }))
    return {};
  std::vector<Reading> readings;
  for (const Convention& c : kConventions)
    readings.push_back(
        {{ContradictionKind::kLog, driven->path + "/odometry.csv",
          "metres and radians in the vehicle's frame, x forward, y left", c.words, 0.0, c.remedy},
         {},
         [&c](std::size_t, MeasurementLog& run) {
           for (OdometryStep& step : run.odometry) {
             step.dx_m *= c.way;
             step.dy_m *= c.side;
             step.dheading_rad *= c.turn;
             step.way_m *= std::abs(c.way);
           }
         },
         true});
  return readings;
}

std::vector<Reading> without_poses(const std::vector<MeasurementLog>& runs) {
  const auto posed = std::ranges::find_if(
      runs, [](const MeasurementLog& run) { return !run.poses.empty() && run.has_epochs; });
  if (posed == runs.end()) return {};
  return {Reading{{ContradictionKind::kPoses, "in " + posed->path + "/" + pose_file(*posed),
                   "poses of the vehicle in the map's frame",
                   "that they do not fit the arrivals, which fit without them", 0.0,
                   "compare them with the site file's frame (origin, axes, metres; the vehicle's origin; "
                   "headings in radians counter-clockwise from x), or leave them out"},
                  {},
                  [](std::size_t, MeasurementLog& run) {
                    if (run.has_epochs) run.poses.clear();
                  }}};
}

std::vector<Reading> other_wirings(const Site& site, const Solution& solution) {
  std::vector<Reading> readings;
  const std::vector<bool> doubtful = doubtful_receivers(site, solution.trajectories);
  for (std::size_t v = 0; v < site.vehicles.size(); ++v)
    for (const Wiring& wiring : wirings(site, VehicleId(v), doubtful))
      readings.push_back(
          {{ContradictionKind::kWiring, "of " + site.vehicles[v].name, "wired as in the site file",
            "that " + wiring.words, 0.0, "check the cables, or exchange the places in the site file"},
           [v, wiring](const Site& stated) { return rewired(stated, VehicleId(v), wiring); },
           {}});
  return readings;
}

std::vector<Reading> jumped_clocks(const Site& site, const std::vector<MeasurementLog>& runs,
                                   const SolveOptions& options) {
  std::vector<Reading> readings;
  for (const LogHalf half : {LogHalf::kFirst, LogHalf::kLast}) {
    std::vector<std::vector<ClockStep>> jumps;
    std::vector<std::string> names, words;
    for (const MeasurementLog& run : runs) {
      jumps.push_back(clock_jumps(site, run, half, options));
      if (jumps.back().empty()) continue;
      names.push_back(run.path);
      for (const ClockStep& jump : jumps.back())
        words.push_back(fmt::format("from {:.6g} s on times of flight are {:.4g} ms {}", jump.time_s,
                                    1e3 * std::abs(jump.step_s), jump.step_s > 0 ? "longer" : "shorter"));
    }
    if (names.empty()) continue;
    readings.push_back(
        {{ContradictionKind::kLog, fmt::format("{}", fmt::join(names, ", ")), "one clock throughout",
          fmt::format("that it jumped: {}", fmt::join(words, ", ")), 0.0,
          "look at what synchronises beacons and receivers (a restart, a lost pulse), and leave out what was "
          "recorded before the jump or after it"},
         {},
         [jumps](std::size_t run, MeasurementLog& log) { without_jumps(jumps[run], log); }});
  }
  return readings;
}

}  // namespace octant::calib
