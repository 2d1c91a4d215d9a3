// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/schedule/floor_schedule.h"

#include <algorithm>
#include <cmath>

#include "models/physics/polygon.h"
#include "survey/geometry/geometry_map.h"
#include "survey/map/floor_grid.h"

namespace octant::survey {
namespace {

constexpr double kAboveBeaconsM = 0.5;
constexpr double kCells = 4000;  ///< approximate number of cells
constexpr int kHeadings =
    4;  ///< headings for receivers with axes; a beacon counts as received if any heading receives it

Reverberance reverberance_of(const SurveyModel& model, const FloorScheduleOptions& options, double height_m) {
  Reverberance r;
  const Hearing& h = model.hearing;
  const bool by_threshold = h.threshold_v > 0;
  r.amplitude_1m_v = by_threshold ? h.amplitude_1m_v : h.range_m;
  r.threshold_v = by_threshold ? h.threshold_v : 1.0;
  r.absorption_np_per_m = by_threshold ? h.absorption_np_per_m : 0.0;
  r.wall_reflection = options.wall_reflection;
  r.pulse_s = options.pulse_s;
  r.speed_mps = model.speed_mps;
  double round_m = 0.0, widest_m = 0.0;
  for (std::size_t i = 0; i < model.floor_m.size(); ++i) {
    round_m += (model.floor_m[(i + 1) % model.floor_m.size()] - model.floor_m[i]).norm();
    for (const Eigen::Vector2d& other : model.floor_m)
      widest_m = std::max(widest_m, (other - model.floor_m[i]).norm());
  }
  const double area_m2 = std::abs(signed_area_m2(model.floor_m));
  r.volume_m3 = area_m2 * height_m;
  r.surface_m2 = 2 * area_m2 + round_m * height_m;
  r.longest_m = std::hypot(widest_m, height_m);
  return r;
}

/// From the floor to somewhat above the highest beacon. The floor is at zero, or as low as what stands above
/// it where some of that is below zero, or all so far above it that heights are counted from elsewhere.
double hall_height_m(const SurveyModel& model) {
  constexpr double kAboveAnyFloorM = 10.0;
  double highest_m = -INFINITY, lowest_m = INFINITY;
  for (const SurveyBeacon& b : model.beacons) {
    highest_m = std::max(highest_m, b.p_map_m.z());
    lowest_m = std::min(lowest_m, b.p_map_m.z());
  }
  for (const SurveyReceiver& r : model.receivers)
    lowest_m = std::min(lowest_m, model.vehicle_z_m + r.p_vehicle_m.z());
  double floor_m = 0.0;
  if (lowest_m < 0.0 || lowest_m > kAboveAnyFloorM) {
    // A vehicle in the plane may have its origin at zero whatever its receivers' heights are counted from.
    const bool vehicle_stands_there = model.vehicle_z_m > lowest_m - kAboveAnyFloorM;
    floor_m = vehicle_stands_there ? std::min(lowest_m, model.vehicle_z_m) : lowest_m;
  }
  return std::max(highest_m, floor_m) - floor_m + kAboveBeaconsM;
}

Audience audience_of(const SurveyModel& model, const FloorGrid& grid, int threads) {
  Audience audience;
  const PoseList poses = poses_of(grid, 0.0, model.vehicle_z_m);
  audience.heard = heard_at(model, poses, threads);
  for (int k = 1; k < kHeadings && model.unknowns.rotation > 0; ++k) {
    const auto turned = heard_at(model, poses_of(grid, 2 * M_PI * k / kHeadings, model.vehicle_z_m), threads);
    for (std::size_t b = 0; b < turned.size(); ++b)
      for (std::size_t i = 0; i < turned[b].size(); ++i) audience.heard[b][i] |= turned[b][i];
  }
  for (const SurveyBeacon& beacon : model.beacons) {
    std::vector<double>& distances = audience.distance_m.emplace_back();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      double nearest_m = INFINITY;
      for (const SurveyReceiver& r : model.receivers)
        nearest_m = std::min(nearest_m, (beacon.p_map_m - Eigen::Vector3d(poses.x_m[i], poses.y_m[i],
                                                                          poses.z_m[i] + r.p_vehicle_m.z()))
                                            .norm());
      distances.push_back(nearest_m);
    }
  }
  return audience;
}

}  // namespace

Result<FloorSchedule> floor_schedule(const SurveyModel& model, const Scene& scene,
                                     const FloorScheduleOptions& options) {
  FloorSchedule out;
  out.reach_m = reach_m(model.hearing);
  if (!std::isfinite(out.reach_m))
    return fail({.file = scene.path,
                 .found = "neither file nor scene state the range of a pulse",
                 .expected = "attenuation with a threshold_v, acoustics.range_m of a scene (--scene), or "
                             "gates.max_range_m of a site file",
                 .advice = "a schedule waits until a pulse has decayed, which depends on its range"});
  out.height_m = options.height_m.value_or(hall_height_m(model));
  out.reverberance = reverberance_of(model, options, out.height_m);
  if (!(model.hearing.threshold_v > 0))
    out.warnings.push_back(
        "no threshold is stated: a pulse is assumed to weaken with the distance only and to be received "
        "exactly up to the range");
  if (model.clock == Clock::kCycleOffset)
    out.warnings.push_back(
        "receivers without a common clock identify beacons by their turn: beacons that fire together must be "
        "distinguished by the position of the vehicle");
  const double cell_m = std::max(scene.cell_m, std::sqrt(std::abs(signed_area_m2(model.floor_m)) / kCells));
  const auto grid = make_floor_grid(model, scene, cell_m);
  if (!grid) return fail(grid.error());
  out.silent = fall_silent(out.reverberance);
  out.plan = share_slots(audience_of(model, *grid, options.threads),
                         {.reach_m = out.reach_m + cell_m,
                          .trust_walls = options.trust_walls,
                          .by_time = options.by_time,
                          .guard_s = 2 * options.pulse_s,
                          .speed_mps = model.speed_mps},
                         out.silent.slot_s);
  return out;
}

std::optional<FloorSchedule> schedule_of_survey(const SurveyModel& model, const Scene& scene, int threads) {
  if (model.beacons.size() > kMostScheduledUnasked || model.speed_mps > kFastestSoundMps) return {};
  FloorScheduleOptions options;
  options.threads = threads;
  auto schedule = floor_schedule(model, scene, options);
  if (!schedule) return {};
  return std::move(*schedule);
}

}  // namespace octant::survey
