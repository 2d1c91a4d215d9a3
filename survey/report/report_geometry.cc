// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report/report_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "models/physics/polygon.h"
#include "survey/geometry/geometry_map.h"
#include "survey/geometry/make_survey_model.h"
#include "survey/geometry/quantity.h"
#include "survey/map/floor_grid.h"
#include "survey/map/survey.h"

namespace octant::survey {
namespace {

/// Cells along the longer side: more would only make the page heavier.
constexpr double kCellsAcross = 48, kCellsAcrossForLoss = 28;
/// Beyond this many beacons the loss of one is a local matter, and a table of all of them no help.
constexpr std::size_t kMostLosses = 300;

double cell_of(const SurveyModel& model, double cells_across) {
  return std::max(1e-3, bounds_of(model.floor_m).sizes().maxCoeff() / cells_across);
}

double or_nothing(double value) {
  return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
}

NamedMap map_of(const FloorGrid& grid, std::string name, std::string unit, const std::vector<double>& values,
                double per_si) {
  NamedMap map{std::move(name), std::move(unit), grid.origin_m, grid.cell_m, grid.columns, {}};
  map.values.assign(grid.columns * grid.rows, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < grid.cells.size(); ++i)
    map.values[grid.cells[i]] = or_nothing(per_si * values[i]);
  return map;
}

std::vector<double> finite_of(const std::vector<double>& values) {
  std::vector<double> finite;
  std::ranges::copy_if(values, std::back_inserter(finite), [](double v) { return std::isfinite(v); });
  std::ranges::sort(finite);
  return finite;
}

double quantile_of_ascending(const std::vector<double>& ascending, double q) {
  return ascending[static_cast<std::size_t>(q * static_cast<double>(ascending.size() - 1))];
}

BeaconLoss loss_of(const std::string& beacon, const FloorGrid& grid, const std::vector<double>& sigma_m,
                   const std::string& name, const Unit& unit) {
  BeaconLoss loss{beacon, 0.0, {}, {}, map_of(grid, name, unit.symbol, sigma_m, unit.per_si)};
  const std::vector<double> finite = finite_of(sigma_m);
  loss.covered_fraction =
      static_cast<double>(finite.size()) / static_cast<double>(std::max<std::size_t>(1, sigma_m.size()));
  if (finite.empty()) return loss;
  loss.median = unit.per_si * quantile_of_ascending(finite, 0.5);
  loss.p95 = unit.per_si * quantile_of_ascending(finite, 0.95);
  return loss;
}

/// Information of all beacons except one, as the sum of those before it and those after it: positive terms
/// only, because a difference would leave rounding errors in undetermined directions.
void add_losses(const SurveyModel& model, int threads, ReportInput& input) {
  if (model.beacons.size() < 2 || model.beacons.size() > kMostLosses) return;
  const auto grid = make_floor_grid(model, Scene{}, cell_of(model, kCellsAcrossForLoss));
  if (!grid) return;
  const PoseList poses = poses_of(*grid, 0.0, model.vehicle_z_m);
  std::vector<std::vector<double>> after(model.beacons.size() + 1);  // after[b]: of beacons b, b + 1, ...
  const std::size_t entries = static_cast<std::size_t>(model.unknowns.entries()) * poses.size();
  after.back().assign(entries, 0.0);
  const auto add = [entries](const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> sum(entries);
    for (std::size_t i = 0; i < entries; ++i) sum[i] = a[i] + b[i];
    return sum;
  };
  std::vector<std::vector<double>> own;
  for (const auto& beacon : model.beacons)
    own.push_back(beacon_layer(model, beacon, poses, threads).information);
  for (std::size_t b = model.beacons.size(); b-- > 0;) after[b] = add(after[b + 1], own[b]);

  std::vector<double> sigma_m(poses.size()), before(entries, 0.0);
  sigma_of_information(model.unknowns, after[0], sigma_m);
  const std::vector<double> finite = finite_of(sigma_m);
  const Unit unit = length_unit(finite.empty() ? 1.0 : finite.back());
  input.loss_name = "expected error of a fix by the arrivals' noise";
  input.loss_unit = unit.symbol;
  input.no_loss = loss_of("", *grid, sigma_m, input.loss_name, unit);
  for (std::size_t b = 0; b < model.beacons.size(); ++b) {
    sigma_of_information(model.unknowns, add(before, after[b + 1]), sigma_m);
    input.losses.push_back(loss_of(model.beacons[b].name, *grid, sigma_m, input.loss_name, unit));
    before = add(before, own[b]);
  }
  std::ranges::stable_sort(input.losses, [](const BeaconLoss& a, const BeaconLoss& b) {
    if (a.covered_fraction != b.covered_fraction) return a.covered_fraction < b.covered_fraction;
    return a.p95.value_or(0.0) > b.p95.value_or(0.0);
  });
}

}  // namespace

void add_geometry(ReportInput& input, int threads) {
  const auto model = make_survey_model(input.plan.deployment, Scene{});
  if (!model) return;
  Scene open_air;
  open_air.cell_m = cell_of(*model, kCellsAcross);
  const auto survey = run_survey(*model, open_air, &input.plan.deployment,
                                 {.threads = threads, .failures = 0, .integrity = true});
  if (!survey) return;
  for (const char* name : {"total_m", "sigma_m", "hdop", "protection_m"}) {
    const FloorMap* map = survey->find(name);
    if (map == nullptr || map->spread.count == 0) continue;
    const Unit unit = map->unit == "m" ? length_unit(map->spread.p95) : Unit{};
    input.plan.maps.push_back(
        map_of(survey->grid, map->title, unit.symbol, {map->values.begin(), map->values.end()}, unit.per_si));
    const bool of_a_fix = std::string_view(name) == "total_m" || std::string_view(name) == "sigma_m";
    if (const auto& limit_m = input.plan.deployment.tolerance.fix_m; limit_m && of_a_fix)
      input.plan.maps.back().tolerance = unit.per_si * *limit_m;
  }
  add_losses(*model, threads, input);
}

}  // namespace octant::survey
