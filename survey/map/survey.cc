// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/survey.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "models/physics/polygon.h"
#include "models/support/parallel.h"
#include "survey/geometry/map_tiles.h"
#include "survey/map/calibration_map.h"
#include "survey/map/floor_maps.h"
#include "survey/map/mirror.h"

namespace octant::survey {
namespace {

constexpr std::size_t kPairsListed = 20;
constexpr std::size_t kMostForPairs = 300;  ///< beacons; of more, pairs are too many to look at each

/// Takes tiles of poses and writes maps; one for each thread.
class FloorMapTask {
 public:
  FloorMapTask(const SurveyModel& model, const KernelModel& kernel, const Survey& survey,
               const CalibrationMap* calibration, const SurveyOptions& options, int failures)
      : losses(kernel, failures),
        model_(model),
        kernel_(kernel),
        survey_(survey),
        calibration_(calibration),
        options_(options),
        failures_(failures),
        paths_(kTilePoses),
        systematic_(kTilePoses),
        other_m2_(kTilePoses),
        one_m_(kTilePoses),
        two_m_(kTilePoses),
        one_beacon_(kTilePoses),
        mask_(kTilePoses) {}

  /// Poses [first, first + count) of a list; at[i] is where pose i's values go. Where a heading before has
  /// already written, the worse of both stays.
  /// @param offset  a multiple of eight
  void take(const PoseList& poses, std::size_t first, std::size_t count, std::size_t offset, bool again,
            std::vector<FloorMap*>& maps, std::vector<std::vector<std::uint8_t>>& heard_bits) {
    fill_tile(kernel_, model_.walls, poses, first, count, tile_);
    map_tile(kernel_, tile_, options_.integrity, work_, figures_);
    for (std::size_t b = 0; b < heard_bits.size(); ++b) {
      if (count % 8 != 0)
        work_.heard_bits[b * (kTilePoses / 8) + count / 8] &=
            static_cast<std::uint8_t>((1U << (count % 8)) - 1);
      for (std::size_t byte = 0; byte < (count + 7) / 8; ++byte)
        heard_bits[b][offset / 8 + byte] |= work_.heard_bits[b * (kTilePoses / 8) + byte];
    }
    look_closer(poses, first, count);
    if (failures_ > 0) {
      losses.add(kernel_, tile_,
                 {.other_m2 = std::span(other_m2_).first(count),
                  .tolerance_m = model_.tolerance.fix_m.value_or(1e150),
                  .one_m = std::span(one_m_).first(count),
                  .two_m = std::span(two_m_).first(count),
                  .one_beacon = std::span(one_beacon_).first(count)});
    }
    for (std::size_t i = 0; i < count; ++i) {
      const bool worse =
          !again || !(figures_.value[kSigma][i] <= static_cast<double>(maps[kMapSigma]->values[offset + i]));
      if (worse) write(i, offset + i, maps);
    }
  }

  LossAccount losses;

 private:
  /// The calibration's part and mirror images: path by path.
  void look_closer(const PoseList& poses, std::size_t first, std::size_t count) {
    const bool calibrated = calibration_ != nullptr && !calibration_->exact();
    const bool mirrors = options_.integrity && model_.motion == Motion::kPlanar;
    std::ranges::fill(systematic_, SystematicPart{});
    std::ranges::fill(other_m2_, 0.0);
    std::ranges::fill(mask_, 0);
    if (!calibrated && !mirrors) return;
    for (std::size_t i = 0; i < count; ++i) {
      const PoseAt pose{poses.x_m[first + i], poses.y_m[first + i], poses.z_m[first + i],
                        poses.heading_rad[first + i]};
      paths_[i].clear();
      if (std::isinf(figures_.value[kSigma][i])) continue;
      const bool look = mirrors && mirrors_.may_have_image(model_, pose, heard_here(i));
      if (calibrated || look) heard_paths(model_, tile_, pose, paths_[i]);
      if (!look) continue;
      const MirrorImage image = mirror_image(model_, pose, paths_[i]);
      mask_[i] = image.ambiguous && on_floor(image.p_map_m);
    }
    if (!calibrated) return;
    calibration_->systematic(model_, std::span(paths_).first(count), std::span(systematic_).first(count));
    for (std::size_t i = 0; i < count; ++i) other_m2_[i] = systematic_[i].xx_m2 + systematic_[i].yy_m2;
  }

  const std::vector<std::size_t>& heard_here(std::size_t i) {
    heard_.clear();
    for (std::size_t b = 0; b < model_.beacons.size(); ++b)
      if (((work_.heard_bits[b * (kTilePoses / 8) + i / 8] >> (i % 8)) & 1) != 0) heard_.push_back(b);
    return heard_;
  }

  /// Where a vehicle cannot be there is no second answer.
  [[nodiscard]] bool on_floor(const Eigen::Vector2d& p) const {
    if (!is_inside(model_.floor_m, p)) return false;
    for (const SceneWall& wall : survey_.scene.walls)
      if (wall.solid && wall.blocks_vehicle && is_inside(wall.points_m, p)) return false;
    return true;
  }

  [[nodiscard]] double protection(std::size_t i) const {
    const double shift = figures_.value[kFaultShift][i];
    if (std::isinf(shift)) return shift;
    const SystematicPart& s = systematic_[i];
    const double sx = figures_.value[kSigmaX][i], sy = figures_.value[kSigmaY][i];
    const double xx = sx * sx + s.xx_m2, yy = sy * sy + s.yy_m2,
                 xy = figures_.value[kCovarianceXy][i] + s.xy_m2;
    return shift + 3.29 * std::sqrt((xx + yy) / 2 + std::hypot((xx - yy) / 2, xy));
  }

  void write(std::size_t i, std::size_t at, std::vector<FloorMap*>& maps) const {
    const auto put = [&](MapName map, double value) {
      if (maps[map] != nullptr) maps[map]->values[at] = static_cast<float>(value);
    };
    const auto figure = [&](Figure f) { return figures_.value[f][i]; };
    const double sigma = figure(kSigma);
    put(kMapSigma, sigma);
    const bool fix = !std::isinf(sigma);
    put(kMapTotal, fix ? std::sqrt(sigma * sigma + other_m2_[i]) : sigma);
    put(kMapCalibration, fix ? std::sqrt(other_m2_[i]) : sigma);
    put(kMapSpeedPart, figure(kShiftBySpeed) * (fix ? model_.speed_sigma_mps / model_.speed_mps : 1.0));
    put(kMapTemperature, figure(kShiftBySpeed) * (fix ? std::abs(survey_.speed_error) : 1.0));
    put(kMapSigmaHeading, figure(kSigmaHeading));
    put(kMapHdop, figure(kHdop));
    put(kMapPdop, figure(kPdop));
    put(kMapVdop, figure(kVdop));
    put(kMapTdop, figure(kTdop));
    put(kMapGdop, figure(kGdop));
    put(kMapHeadingDop, figure(kHeadingDop));
    put(kMapBeacons, figure(kBeacons));
    if (options_.integrity) {
      put(kMapBias, figure(kDetectableBias));
      put(kMapProtection, protection(i));
      put(kMapMirror, mask_[i]);
    }
    put(kMapLossOne, one_m_[i]);
    put(kMapLossBeacon, one_beacon_[i]);
    put(kMapLossTwo, two_m_[i]);
  }

  const SurveyModel& model_;
  const KernelModel& kernel_;
  const Survey& survey_;
  const CalibrationMap* calibration_;
  const SurveyOptions& options_;
  int failures_;
  KernelTile tile_;
  KernelFigures figures_;
  KernelWork work_;
  std::vector<std::vector<HeardPath>> paths_;
  std::vector<SystematicPart> systematic_;
  std::vector<double> other_m2_, one_m_, two_m_;
  std::vector<std::int32_t> one_beacon_;
  std::vector<std::size_t> heard_;
  MirrorFilter mirrors_;
  std::vector<std::uint8_t> mask_;
};

/// Fraction of poses whose total sigma is within the tolerance, and whose place is not one of two.
double covered(const std::vector<FloorMap*>& maps, const SurveyModel& model) {
  const FloorMap& total = maps[kMapTotal] != nullptr ? *maps[kMapTotal] : *maps[kMapSigma];
  const FloorMap* mirror = maps[kMapMirror];
  const double limit = model.tolerance.fix_m.value_or(std::numeric_limits<double>::max());
  std::size_t within = 0;
  for (std::size_t i = 0; i < total.values.size(); ++i) {
    const bool is_mirrored = mirror != nullptr && mirror->values[i] > 0;
    if (static_cast<double>(total.values[i]) <= limit && !is_mirrored) ++within;
  }
  return total.values.empty() ? 0.0 : static_cast<double>(within) / static_cast<double>(total.values.size());
}

void look_at_floor(const SurveyModel& model, const KernelModel& kernel, const CalibrationMap* calibration,
                   const SurveyOptions& options, std::vector<FloorMap*>& maps, Survey& survey) {
  const std::size_t cells = survey.grid.cells.size(), tiles = (cells + kTilePoses - 1) / kTilePoses;
  const int threads = std::max(1, options.threads);
  std::vector<std::unique_ptr<FloorMapTask>> workers;
  workers.reserve(static_cast<std::size_t>(threads));
  for (int t = 0; t < threads; ++t)
    workers.push_back(
        std::make_unique<FloorMapTask>(model, kernel, survey, calibration, options, options.failures));
  std::atomic<std::size_t> next{0};
  for_each_parallel(static_cast<std::size_t>(threads), threads, [&](std::size_t thread) {
    for (std::size_t t = next.fetch_add(1); t < tiles; t = next.fetch_add(1)) {
      const std::size_t first = t * kTilePoses, count = std::min(kTilePoses, cells - first);
      for (int h = 0; h < survey.scene.headings; ++h) {
        const double heading = 2 * std::numbers::pi * h / survey.scene.headings;
        workers[thread]->take(poses_of(survey.grid, heading, model.vehicle_z_m, first, count), 0, count,
                              first, h > 0, maps, survey.heard_bits);
      }
    }
  });
  for (std::size_t t = 1; t < workers.size(); ++t) workers[0]->losses.merge(workers[t]->losses);
  survey.failures = workers[0]->losses.singles();
  survey.double_failures = workers[0]->losses.pairs(kPairsListed);
}

void look_along(const SceneRoute& route, const SurveyModel& model, const KernelModel& kernel,
                const CalibrationMap* calibration, const SurveyOptions& options, Survey& survey) {
  RouteSurvey along;
  along.name = route.name;
  along.poses = poses_along(route, survey.scene.cell_m, model.vehicle_z_m);
  std::vector<FloorMap*> maps;
  along.maps = make_maps(wanted_maps(model, survey, options, true), along.poses.size(), model, maps);
  along.heard_bits.assign(model.beacons.size(), std::vector<std::uint8_t>((along.poses.size() + 7) / 8));
  FloorMapTask worker(model, kernel, survey, calibration, options, 0);
  for (std::size_t first = 0; first < along.poses.size(); first += kTilePoses)
    worker.take(along.poses, first, std::min(kTilePoses, along.poses.size() - first), first, false, maps,
                along.heard_bits);
  for (FloorMap& map : along.maps) map.spread = spread_of(map.values);
  along.covered_fraction = covered(maps, model);
  survey.routes.push_back(std::move(along));
}

void sum_up(const std::vector<FloorMap*>& maps, Survey& survey) {
  for (FloorMap& map : survey.maps) map.spread = spread_of(map.values);
  const auto cells = static_cast<double>(survey.grid.cells.size());
  const auto fraction = [&](const FloorMap* map, auto holds) {
    return map == nullptr ? 0.0 : static_cast<double>(std::ranges::count_if(map->values, holds)) / cells;
  };
  survey.fix_fraction = fraction(maps[kMapSigma], [](float v) { return v < kNoMapValue; });
  survey.k_covered_fraction =
      fraction(maps[kMapBeacons], [&](float v) { return v >= static_cast<float>(survey.coverage); });
  survey.mirror_fraction = fraction(maps[kMapMirror], [](float v) { return v > 0; });
  survey.covered_fraction = covered(maps, survey.model);
  for (const auto& bits : survey.heard_bits) {
    std::size_t count = 0;
    for (const std::uint8_t byte : bits) count += static_cast<std::size_t>(std::popcount(byte));
    survey.heard_fraction.push_back(static_cast<double>(count) / cells);
  }
}

/// An error of the air temperature as a relative error of all distances: times at speed c1 are converted with
/// c0.
void set_temperature_error(const SurveyModel& model, const Scene& scene, Survey& survey) {
  const double c0 = octant::speed_mps(model.medium),
               c1 = octant::speed_mps(model.medium,
                                      model.medium.temperature_degC + scene.temperature_error_degC);
  if (c0 == c1 || !(c1 > 0)) return;
  survey.temperature_error_degC = scene.temperature_error_degC;
  survey.speed_error = c0 / c1 - 1;
}

}  // namespace

Spread spread_of(std::vector<float> values) {
  Spread spread;
  const auto end = std::partition(values.begin(), values.end(), [](float v) { return v < kNoMapValue; });
  const auto count = static_cast<std::size_t>(end - values.begin());
  spread.count = count, spread.without = values.size() - count;
  if (count == 0) return spread;
  const auto quantile = [&](double part) {
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(std::min(
                             count - 1, static_cast<std::size_t>(part * static_cast<double>(count))));
    std::nth_element(values.begin(), at, end);
    return static_cast<double>(*at);
  };
  spread.median = quantile(0.5), spread.p95 = quantile(0.95);
  spread.min = static_cast<double>(*std::min_element(values.begin(), end)),
  spread.max = static_cast<double>(*std::max_element(values.begin(), end));
  return spread;
}

const FloorMap* Survey::find(const std::string& name) const {
  const auto found = std::ranges::find(maps, name, &FloorMap::name);
  return found == maps.end() ? nullptr : &*found;
}

Result<Survey> run_survey(const SurveyModel& model, const Scene& scene, const Deployment* deployment,
                          const SurveyOptions& asked) {
  SurveyOptions options = asked;
  if (model.beacons.size() > kMostForPairs) options.failures = std::min(options.failures, 1);
  auto grid = make_floor_grid(model, scene);
  if (!grid) return fail(grid.error());
  for (const SceneRoute& route : scene.routes)
    if (!(most_poses_along(route, scene.cell_m) <= kMostCells))
      return fail(
          {.file = scene.path,
           .line = route.line,
           .found = "route '" + route.name + "' has more poses, a cell apart, than a floor may have cells",
           .expected = "a shorter one, or a larger cell_m"});
  Survey survey;
  survey.model = model;
  survey.scene = scene;
  survey.grid = std::move(*grid);
  survey.coverage =
      scene.coverage > 0 ? scene.coverage : model.unknowns.position + (model.unknowns.clock ? 1 : 0) + 1;
  set_temperature_error(model, scene, survey);
  std::optional<CalibrationMap> calibration;
  if (deployment != nullptr) calibration.emplace(*deployment, model);
  survey.calibrated = calibration && !calibration->exact();
  const CalibrationMap* part = calibration ? &*calibration : nullptr;
  const KernelModel kernel = kernel_model(model, model.beacons);
  std::vector<FloorMap*> maps;
  survey.maps = make_maps(wanted_maps(model, survey, options, false), survey.grid.cells.size(), model, maps);
  survey.heard_bits.assign(model.beacons.size(),
                           std::vector<std::uint8_t>((survey.grid.cells.size() + 7) / 8));
  look_at_floor(model, kernel, part, options, maps, survey);
  sum_up(maps, survey);
  for (const SceneRoute& route : scene.routes) look_along(route, model, kernel, part, options, survey);
  return survey;
}

}  // namespace octant::survey
