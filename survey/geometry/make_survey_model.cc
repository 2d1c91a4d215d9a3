// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/make_survey_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "models/localizers/least_squares/epoch_fix.h"
#include "models/physics/polygon.h"
#include "survey/geometry/scene_check.h"

namespace octant::survey {
namespace {

constexpr double kMarginM = 2.0;  ///< round beacons in a line, whose hull has no area

/// Content of a site or of a deployment in common form: the part that enters the model directly, and the
/// input from which the rest is built together with the scene.
struct SiteOrDeployment {
  SurveyModel model;
  Ranging ranging = Ranging::kOneWay;
  Noise noise;
  std::optional<AttenuationModel> attenuation;
  double max_range_m = std::numeric_limits<double>::infinity();
  std::optional<double> heard_m;  ///< largest range of the calibration
  std::vector<double> sigma_m;    ///< sigma of each beacon's position
  std::vector<std::string> left_out;
  std::vector<double> hearing_cosine;  ///< smallest cosine at which each receiver with an axis received
  std::vector<Eigen::Vector2d> area_m;
};

Result<void> apply_acoustics(const SiteOrDeployment& common, const Scene& scene, SurveyModel& model) {
  const SceneAcoustics& a = scene.acoustics;
  const auto& attenuation = common.attenuation;
  if (a.amplitude_1m_v.has_value() != a.threshold_v.has_value() && !attenuation)
    return fail(
        {.file = scene.path,
         .found = fmt::format("acoustics with {} alone", a.threshold_v ? "threshold_v" : "amplitude_1m_v"),
         .expected = "amplitude_1m_v and threshold_v, or neither"});
  Hearing& hearing = model.hearing;
  hearing.range_m = std::min(a.range_m.value_or(std::numeric_limits<double>::infinity()), common.max_range_m);
  hearing.amplitude_1m_v = a.amplitude_1m_v.value_or(attenuation ? attenuation->amplitude_1m_v : 0.0);
  hearing.threshold_v = a.threshold_v.value_or(attenuation ? attenuation->threshold_v : 0.0);
  // A stated range or threshold takes precedence over the largest observed range.
  if (!std::isfinite(hearing.range_m) && !(hearing.threshold_v > 0) && common.heard_m)
    hearing.range_m = *common.heard_m;
  if (a.absorption_np_per_m) {
    hearing.absorption_np_per_m = *a.absorption_np_per_m;
  } else if (a.frequency_hz) {
    hearing.absorption_np_per_m =
        air_absorption_np_per_m(*a.frequency_hz, model.medium.temperature_degC,
                                model.medium.relative_humidity, model.medium.pressure_pa);
  } else if (attenuation) {
    hearing.absorption_np_per_m = attenuation->absorption_np_per_m;
  }
  return {};
}

/// A pattern's index: that of one alike, else a new one.
std::size_t add_pattern(BeamPattern pattern, SurveyModel& model) {
  const auto alike = [&](const BeamPattern& p) {
    return p.kind == pattern.kind && p.half_angle_rad == pattern.half_angle_rad &&
           p.half_power_angle_rad == pattern.half_power_angle_rad;
  };
  const auto found = std::ranges::find_if(model.patterns, alike);
  const auto index = static_cast<std::size_t>(found - model.patterns.begin());
  if (found == model.patterns.end()) model.patterns.push_back(std::move(pattern));
  return index;
}

/// Pattern of a receiver that the scene does not describe: as calibrated, or else as wide as the calibration
/// observed.
std::size_t pattern_of_receiver(const SiteOrDeployment& common, double hearing_cosine, SurveyModel& model) {
  BeamPattern pattern;
  if (common.attenuation && common.attenuation->directional() && model.hearing.threshold_v > 0) {
    pattern.kind = BeamPattern::Kind::kHalfPower;
    pattern.half_power_angle_rad = common.attenuation->half_power_angle_rad;
    pattern.name = fmt::format("-3 dB at {:.0f} degrees", pattern.half_power_angle_rad * 180 / M_PI);
  } else {
    pattern.half_angle_rad = std::acos(std::clamp(hearing_cosine, -1.0, 1.0));
    pattern.name = fmt::format("hears to {:.0f} degrees", pattern.half_angle_rad * 180 / M_PI);
  }
  return add_pattern(std::move(pattern), model);
}

Result<void> apply_patterns(const SiteOrDeployment& common, const Scene& scene, SurveyModel& model) {
  for (SurveyBeacon& beacon : model.beacons)
    if (scene.beacon_pattern && !beacon.axis.isZero()) beacon.pattern = *scene.beacon_pattern;
  for (const SceneBeacon& described : scene.beacons) {
    const auto found = std::ranges::find(model.beacons, described.name, &SurveyBeacon::name);
    if (found == model.beacons.end()) {
      if (std::ranges::find(common.left_out, described.name) != common.left_out.end()) continue;
      return fail({.file = scene.path,
                   .line = described.line,
                   .found = fmt::format("scene: beacon '{}' is not in the site", described.name),
                   .expected = "a beacon's id"});
    }
    if (described.axis) found->axis = described.axis->normalized();
    const auto pattern = described.pattern ? described.pattern : scene.beacon_pattern;
    if (pattern && found->axis.isZero())
      return fail({.file = scene.path,
                   .line = described.line,
                   .found = fmt::format("scene: beacon '{}' has a pattern and no axis", described.name),
                   .expected = "the direction it looks in, such as axis: [0, 0, -1]"});
    if (pattern) found->pattern = *pattern;
  }
  for (const SurveyBeacon& beacon : model.beacons)
    if (scene.beacon_pattern && beacon.axis.isZero())
      return fail({.file = scene.path,
                   .found = fmt::format("scene: beacon '{}' has no axis, and beacon_pattern applies to all",
                                        beacon.name),
                   .expected = "an axis for each beacon"});
  for (std::size_t r = 0; r < model.receivers.size(); ++r) {
    SurveyReceiver& receiver = model.receivers[r];
    if (receiver.axis.isZero()) continue;
    receiver.pattern = scene.receiver_pattern ? *scene.receiver_pattern
                                              : pattern_of_receiver(common, common.hearing_cosine[r], model);
  }
  return {};
}

std::vector<Eigen::Vector2d> outline_of(const SiteOrDeployment& common) {
  if (common.area_m.size() >= 3 && std::abs(signed_area_m2(common.area_m)) > 1e-6) return common.area_m;
  std::vector<Eigen::Vector2d> places;
  for (const SurveyBeacon& beacon : common.model.beacons) places.emplace_back(beacon.p_map_m.head<2>());
  Polygon hull = convex_hull(places);
  if (hull.size() >= 3 && signed_area_m2(hull) > 1e-6) return hull;
  const Eigen::AlignedBox2d box = bounds_of(places);
  const Eigen::Vector2d low = box.min().array() - kMarginM, high = box.max().array() + kMarginM;
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

void add_wall(const SceneWall& wall, SurveyModel& model) {
  if (!wall.blocks_sound) return;
  const std::size_t n = wall.points_m.size();
  for (std::size_t i = 0; i + 1 < n + (wall.solid ? 1 : 0); ++i)
    model.walls.push_back({wall.points_m[i], wall.points_m[(i + 1) % n], wall.bottom_m, wall.top_m});
}

Result<SurveyModel> assemble(const SiteOrDeployment& common, const Scene& scene, bool may_be_empty = false) {
  if (const auto checked = check_scene(scene); !checked) return fail(checked.error());
  SurveyModel model = common.model;
  model.patterns = scene.patterns;
  model.vehicle_z_m = model.motion == Motion::kSpatial ? scene.vehicle_z_m : 0.0;
  if (model.beacons.empty() && !may_be_empty)
    return fail({.found = "not a single beacon has a place",
                 .expected = "beacons with position_m",
                 .advice = "calibrate first"});
  if (model.receivers.empty())
    return fail(
        {.found = "the vehicle has no receivers", .expected = "receivers: what is to hear the beacons"});
  for (const std::string& name : common.left_out)
    model.warnings.push_back(fmt::format("beacon '{}' has no known place and is left out", name));
  model.unknowns = unknowns_of(model.motion, model.clock, model.receivers);
  // A path there and back is timed as a whole: half its time is the way.
  const double by_time = model.speed_mps / (common.ranging == Ranging::kTwoWay ? 2.0 : 1.0);
  model.noise = {by_time * std::hypot(common.noise.tof_sigma_s, common.noise.pair_sigma_s.value_or(0.0)),
                 scene.noise.sigma_m_per_m, scene.noise.sigma_m_per_sqrt_m};
  if (const auto applied = apply_acoustics(common, scene, model); !applied) return fail(applied.error());
  if (const auto applied = apply_patterns(common, scene, model); !applied) return fail(applied.error());
  for (const SceneWall& wall : scene.walls) add_wall(wall, model);
  model.floor_m = scene.floor_m.empty() ? outline_of(common) : scene.floor_m;
  if (const auto checked = check_beacon_places(scene, model, common.sigma_m); !checked)
    return fail(checked.error());
  return model;
}

void add_receiver(const std::string& name, const Eigen::Vector3d& p,
                  const std::optional<Eigen::Vector3d>& axis, double hearing_cosine,
                  SiteOrDeployment& common) {
  common.model.receivers.push_back({name, p, axis.value_or(Eigen::Vector3d::Zero())});
  common.hearing_cosine.push_back(hearing_cosine);
}

SiteOrDeployment common_of(const Site& site, std::size_t vehicle) {
  SiteOrDeployment common;
  common.model.name = site.name;
  common.model.vehicle = vehicle;
  common.model.motion = site.motion;
  common.model.medium = site.medium;
  common.model.clock = site.timing.clock;
  common.ranging = site.timing.ranging;
  common.noise = site.noise;
  if (site.attenuation) common.attenuation = site.attenuation->mean();
  common.model.speed_mps = octant::speed_mps(site.medium);
  common.model.speed_sigma_mps = site.speed_sigma_mps;
  common.max_range_m = site.gates.max_range_m;
  common.model.tolerance = site.tolerance;
  for (const SiteBeacon& beacon : site.beacons) {
    const auto& p = beacon.position_m;
    if (!p[0] || !p[1] || !p[2]) {
      common.left_out.push_back(beacon.name);
      continue;
    }
    common.model.beacons.push_back({beacon.name, {*p[0], *p[1], *p[2]}});
    common.sigma_m.push_back(std::max(beacon.sigma_m[0].value_or(1.0), beacon.sigma_m[1].value_or(1.0)));
  }
  if (vehicle < site.vehicles.size())
    for (std::size_t r = 0; r < site.vehicles[vehicle].receiver_count; ++r) {
      const SiteReceiver& receiver = site.receivers[site.vehicles[vehicle].first_receiver + r];
      add_receiver(receiver.name, receiver.position_m, receiver.axis, kHearingCosine, common);
    }
  return common;
}

}  // namespace

Result<SurveyModel> make_survey_model(const Site& site, const Scene& scene, std::size_t vehicle) {
  return assemble(common_of(site, vehicle), scene);
}

Result<SurveyModel> make_empty_survey_model(Site site, Scene scene, std::size_t vehicle) {
  if (scene.floor_m.empty())
    return fail({.file = scene.path,
                 .found = "the scene has no floor",
                 .expected = "scene.floor_m: the outline over which vehicles are to be positioned"});
  site.beacons.clear();
  scene.beacons.clear();
  return assemble(common_of(site, vehicle), scene, /*may_be_empty=*/true);
}

Result<SurveyModel> make_survey_model(const Deployment& d, const Scene& scene, std::size_t vehicle) {
  SiteOrDeployment common;
  common.model.name = d.site;
  common.model.vehicle = vehicle;
  common.model.motion = d.motion;
  common.model.medium = d.medium;
  common.model.clock = d.timing.clock;
  common.ranging = d.timing.ranging;
  common.noise = d.noise;
  common.noise.tof_sigma_s =
      std::hypot(d.noise.tof_sigma_s, d.correlated_noise.sigma_s, d.correlated_noise.pair_sigma_s);
  common.attenuation = d.attenuation;
  common.model.speed_mps = d.speed_mps(d.medium.temperature_degC);
  common.model.speed_sigma_mps = d.speed_sigma_mps;
  common.model.tolerance = d.tolerance;
  common.area_m = d.validity_area_m;
  common.heard_m = d.validity_reach_m;
  for (const DeploymentBeacon& beacon : d.beacons) {
    if (beacon.status == BeaconStatus::kUndetermined || !beacon.position_m.allFinite()) {
      common.left_out.push_back(beacon.name);
      continue;
    }
    common.model.beacons.push_back({beacon.name, beacon.position_m});
    common.sigma_m.push_back(std::sqrt(beacon.covariance_m2.topLeftCorner<2, 2>().trace()));
  }
  if (vehicle < d.vehicles.size())
    for (std::size_t r = 0; r < d.vehicles[vehicle].receiver_count; ++r) {
      const DeploymentReceiver& receiver = d.receivers[d.vehicles[vehicle].first_receiver + r];
      add_receiver(receiver.name, receiver.position_m, receiver.axis,
                   receiver.hearing_cosine.value_or(kHearingCosine), common);
    }
  return assemble(std::move(common), scene);
}

}  // namespace octant::survey
