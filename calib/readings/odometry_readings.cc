// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/odometry_readings.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace octant::calib {
namespace {

/// File with planar odometry; empty if there is none.
std::string planar_odometry(const std::vector<MeasurementLog>& runs) {
  const auto run = run_of_planar_odometry(runs);
  return run ? runs[*run].path + "/odometry.csv" : "";
}

/// Factors on odometry steps.
struct StepFactors {
  double way = 1.0, side = 1.0, turn = 1.0;  ///< on dx, dy and dheading
};

Reading with_other_steps(std::string file, const char* stated, std::string found, std::string remedy,
                         const StepFactors& factors) {
  return {{ContradictionKind::kLog, std::move(file), stated, std::move(found), 0.0, std::move(remedy)},
          {},
          [factors](std::size_t, MeasurementLog& run) {
            for (OdometryStep& step : run.odometry) {
              step.dx_m *= factors.way;
              step.dy_m *= factors.side;
              step.dheading_rad *= factors.turn;
              step.way_m *= std::abs(factors.way);
            }
          },
          true};
}

}  // namespace

std::optional<std::size_t> run_of_planar_odometry(const std::vector<MeasurementLog>& runs) {
  const auto driven = std::ranges::find_if(runs, [](const auto& run) { return !run.odometry.empty(); });
  if (driven == runs.end() || !std::ranges::all_of(driven->odometry, &OdometryStep::is_planar))
    return std::nullopt;
  return static_cast<std::size_t>(driven - runs.begin());
}

std::vector<Reading> other_odometry(const std::vector<MeasurementLog>& runs) {
  struct Convention {
    const char *words, *remedy;
    StepFactors factors;
  };
  constexpr double kDegree_rad = M_PI / 180.0;
  static const Convention kConventions[] = {
      {"that its turns count clockwise",
       "negate dheading_rad: counter-clockwise is positive",
       {1.0, 1.0, -1.0}},
      {"that it counts the way backward", "negate dx_m: forward is positive", {-1.0, 1.0, 1.0}},
      {"that y counts to the right and turns clockwise",
       "negate dy_m and dheading_rad: left and counter-clockwise are positive",
       {1.0, -1.0, -1.0}},
      {"that it counts backward and turns clockwise", "negate dx_m and dheading_rad", {-1.0, 1.0, -1.0}},
      {"that its turns are in degrees", "multiply dheading_rad by pi / 180", {1.0, 1.0, kDegree_rad}},
      {"that its way is in millimetres", "multiply dx_m and dy_m by 0.001", {1e-3, 1e-3, 1.0}},
      {"that its way is in centimetres", "multiply dx_m and dy_m by 0.01", {1e-2, 1e-2, 1.0}}};
  const std::string file = planar_odometry(runs);
  std::vector<Reading> readings;
  for (const Convention& c : kConventions)
    if (!file.empty())
      readings.push_back(with_other_steps(file,
                                          "metres and radians in the vehicle's frame, x forward, y left",
                                          c.words, c.remedy, c.factors));
  return readings;
}

std::vector<ReadingFamily> odometry_stamped_late(const std::vector<MeasurementLog>& runs) {
  const std::string file = planar_odometry(runs);
  if (file.empty()) return {};
  return {of_other_clock(ContradictionKind::kLog, file, file, "it is stamped",
                         [](double lag_s, MeasurementLog& run) {
                           for (OdometryStep& step : run.odometry) step.time_s -= lag_s;
                         })};
}

void join_odometry_to_wiring(std::vector<Contradiction>& reported) {
  const auto of_kind = [&](ContradictionKind kind) {
    return std::ranges::find(reported, kind, &Contradiction::kind);
  };
  const auto wiring = of_kind(ContradictionKind::kWiring), odometry = of_kind(ContradictionKind::kLog);
  if (wiring == reported.end() || odometry == reported.end() || !odometry->subject.ends_with("odometry.csv"))
    return;
  wiring->remedy += fmt::format("; if these are right, of {}: {}", odometry->subject, odometry->remedy);
  reported.erase(odometry);
}

}  // namespace octant::calib
