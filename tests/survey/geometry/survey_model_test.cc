// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/make_survey_model.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/physics/polygon.h"
#include "models/simulator/random.h"
#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace survey_model_test {

using test::must;
using test::small_site;
using ::testing::HasSubstr;

Scene bare_scene() {
  Scene scene = test::small_scene();
  scene.walls.clear();
  scene.routes.clear();
  return scene;
}

/// The small site as calibrated, without attenuation.
Deployment small_deployment() {
  Deployment d;
  d.site = "small";
  d.medium = small_site().medium;
  d.noise.tof_sigma_s = 1e-5;
  for (const SiteBeacon& b : small_site().beacons)
    d.beacons.push_back(
        {.name = b.name, .position_m = {*b.position_m[0], *b.position_m[1], *b.position_m[2]}});
  d.vehicles = {{.name = "robot", .first_receiver = 0, .receiver_count = 1}};
  d.receivers.push_back({.name = "r0", .vehicle = VehicleId(0), .position_m = {0, 0, 0.3}, .axis = {}});
  return d;
}

TEST(SurveyModel, ReachIsWhereTheAmplitudeMeetsTheThreshold) {
  Random draws(20261125);
  for (int i = 0; i < 500; ++i) {
    Hearing h;
    h.threshold_v = draws.log_uniform(1e-3, 1.0);
    h.amplitude_1m_v = h.threshold_v * draws.log_uniform(1e-2, 1e4);
    h.absorption_np_per_m = i % 5 == 0 ? 0.0 : draws.log_uniform(1e-4, 3.0);
    const double d = reach_m(h);
    // A(d) = threshold to the precision of the bisection, a few units of the last place of d.
    const double amplitude_v = h.amplitude_1m_v / d * std::exp(-h.absorption_np_per_m * d);
    EXPECT_NEAR(amplitude_v / h.threshold_v, 1.0, 1e-12 * (1 + h.absorption_np_per_m * d));
    if (h.absorption_np_per_m == 0.0) EXPECT_NEAR(d * h.threshold_v / h.amplitude_1m_v, 1.0, 1e-14);
    h.range_m = 0.5 * d;
    EXPECT_EQ(reach_m(h), 0.5 * d) << "never beyond the range that is stated";
  }
  EXPECT_EQ(reach_m({.range_m = 12.0}), 12.0);
  EXPECT_TRUE(std::isinf(reach_m({})));
  EXPECT_EQ(reach_m({.amplitude_1m_v = 0.0, .threshold_v = 0.1}), 0.0) << "a beacon that is silent";
}

std::vector<SurveyReceiver> receivers_at(const std::vector<Eigen::Vector3d>& places) {
  std::vector<SurveyReceiver> receivers;
  for (const auto& p : places) receivers.push_back({"r", p});
  return receivers;
}

TEST(SurveyModel, RotationsAreUnknownsWhereReceiversCanTellThem) {
  const auto rotation = [](Motion motion, const std::vector<Eigen::Vector3d>& places) {
    return unknowns_of(motion, Clock::kSynchronised, receivers_at(places)).rotation;
  };
  EXPECT_EQ(rotation(Motion::kPlanar, {{0, 0, 0}}), 0);
  EXPECT_EQ(rotation(Motion::kPlanar, {{0, 0, 0}, {0.1, 0, 0}}), 1);
  EXPECT_EQ(rotation(Motion::kPlanar, {{0.2, 0.1, 0}, {0.2, 0.1, 1}}), 0) << "one above the other";
  EXPECT_EQ(rotation(Motion::kSpatial, {{0, 0, 0}, {0.1, 0, 0}}), 0);
  EXPECT_EQ(rotation(Motion::kSpatial, {{0, 0, 0}, {0.1, 0, 0}, {0.3, 0, 0}}), 0) << "in a line";
  EXPECT_EQ(rotation(Motion::kSpatial, {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}}), 3);
  EXPECT_EQ(rotation(Motion::kSpatial, {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), 0) << "all at one place";
}

TEST(SurveyModel, UnknownsAreCountedWithTheirTriangle) {
  const auto three = receivers_at({{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}});
  const Unknowns planar = unknowns_of(Motion::kPlanar, Clock::kCycleOffset, three);
  EXPECT_EQ(planar.count(), 4) << "x, y, heading, clock";
  EXPECT_EQ(planar.entries(), 10);
  const Unknowns spatial = unknowns_of(Motion::kSpatial, Clock::kCycleOffset, three);
  EXPECT_EQ(spatial.count(), 7);
  EXPECT_EQ(spatial.entries(), 28);
  EXPECT_EQ(unknowns_of(Motion::kPlanar, Clock::kSynchronised, {}).count(), 2);
}

TEST(SurveyModel, TheNoiseOfARangeIsThatOfItsTime) {
  Site site = small_site();
  site.noise.tof_sigma_s = 3e-5;
  Scene scene = bare_scene();
  const SurveyModel one_way = must(make_survey_model(site, scene));
  EXPECT_DOUBLE_EQ(one_way.noise.constant_m, 3e-5 * speed_mps(site.medium));
  EXPECT_FALSE(one_way.noise.grows());
  site.noise.pair_sigma_s = 4e-5;
  EXPECT_DOUBLE_EQ(must(make_survey_model(site, scene)).noise.constant_m, 5e-5 * speed_mps(site.medium));
  site.timing.ranging = Ranging::kTwoWay;  // half of the time is the way
  EXPECT_DOUBLE_EQ(must(make_survey_model(site, scene)).noise.constant_m, 2.5e-5 * speed_mps(site.medium));
  scene.noise = {.sigma_m_per_m = 0.001, .sigma_m_per_sqrt_m = 0.002};
  const RangeNoise grown = must(make_survey_model(site, scene)).noise;
  EXPECT_TRUE(grown.grows());
  EXPECT_DOUBLE_EQ(grown.variance_m2(9.0),
                   std::pow(2.5e-5 * speed_mps(site.medium), 2) + std::pow(0.009, 2) + std::pow(0.006, 2));
}

TEST(SurveyModel, ADeploymentsNoiseHoldsWhatIsCorrelated) {
  Deployment d = small_deployment();
  d.speed_offset_mps = 1.5;
  d.noise.tof_sigma_s = 2e-5;
  d.correlated_noise = {.sigma_s = 3e-5, .time_s = 10, .pair_sigma_s = 6e-5};
  const SurveyModel model = must(make_survey_model(d, bare_scene()));
  EXPECT_DOUBLE_EQ(model.speed_mps, speed_mps(d.medium) + 1.5);
  EXPECT_DOUBLE_EQ(model.noise.constant_m, 7e-5 * model.speed_mps);  // 2, 3, 6: 7
}

TEST(SurveyModel, BeaconsWithoutAPlaceAreLeftOutWithAWord) {
  Site site = small_site();
  site.beacons[1].position_m[2].reset();
  const SurveyModel model = must(make_survey_model(site, bare_scene()));
  EXPECT_EQ(model.beacons.size(), 6U);
  ASSERT_EQ(model.warnings.size(), 1U);
  EXPECT_THAT(model.warnings[0], HasSubstr("beacon 'B1' has no known place"));
  Deployment d = small_deployment();
  d.beacons[0].status = BeaconStatus::kUndetermined;
  d.beacons[2].position_m.x() = std::nan("");
  EXPECT_EQ(must(make_survey_model(d, bare_scene())).beacons.size(), 5U);
  // The entries of the scene are valid.
  Scene scene = bare_scene();
  scene.beacons = {{"B1", Eigen::Vector3d(0, 0, -1), {}, 3}};
  EXPECT_TRUE(make_survey_model(site, scene));
}

TEST(SurveyModel, NothingToHearOrNobodyToHearItIsRefused) {
  Site site = small_site(1);
  site.beacons[0].position_m[0].reset();
  auto model = make_survey_model(site, bare_scene());
  ASSERT_FALSE(model);
  EXPECT_THAT(model.error().message(), HasSubstr("not a single beacon has a place"));
  model = make_survey_model(small_site(), bare_scene(), 1);
  ASSERT_FALSE(model) << "there is one vehicle";
  EXPECT_THAT(model.error().message(), HasSubstr("no receivers"));
}

TEST(SurveyModel, HowFarOneHearsIsStatedElseAsTheCalibrationHeard) {
  Deployment d = small_deployment();
  d.validity_reach_m = 9.0;
  Scene scene = bare_scene();
  EXPECT_EQ(must(make_survey_model(d, scene)).hearing.range_m, 9.0);
  scene.acoustics.range_m = 20.0;
  EXPECT_EQ(must(make_survey_model(d, scene)).hearing.range_m, 20.0) << "a statement says more";
  scene.acoustics.range_m.reset();
  scene.acoustics.amplitude_1m_v = 2.0, scene.acoustics.threshold_v = 0.1;
  EXPECT_TRUE(std::isinf(must(make_survey_model(d, scene)).hearing.range_m)) << "a threshold does too";
  Site site = small_site();
  site.gates.max_range_m = 7.0;
  scene.acoustics.range_m = 11.0;
  EXPECT_EQ(must(make_survey_model(site, scene)).hearing.range_m, 7.0) << "the gate drops what is farther";
}

TEST(SurveyModel, AbsorptionIsStatedElseTheStandardsElseTheCalibrations) {
  Site site = small_site();
  site.attenuation = AttenuationPrior{.amplitude_1m_v = {4.0, 0.1},
                                      .absorption_np_per_m = {0.07, 0.01},
                                      .rise_time_s = {},
                                      .threshold_v = 0.05};
  Scene scene = bare_scene();
  SurveyModel model = must(make_survey_model(site, scene));
  EXPECT_EQ(model.hearing.absorption_np_per_m, 0.07);
  EXPECT_EQ(model.hearing.amplitude_1m_v, 4.0);
  EXPECT_EQ(model.hearing.threshold_v, 0.05);
  scene.acoustics.frequency_hz = 40e3;
  model = must(make_survey_model(site, scene));
  EXPECT_EQ(model.hearing.absorption_np_per_m,
            air_absorption_np_per_m(40e3, site.medium.temperature_degC, site.medium.relative_humidity,
                                    site.medium.pressure_pa));
  scene.acoustics.absorption_np_per_m = 0.2;
  EXPECT_EQ(must(make_survey_model(site, scene)).hearing.absorption_np_per_m, 0.2);
  scene.acoustics.threshold_v = 0.5;  // beside the site's amplitude
  EXPECT_EQ(must(make_survey_model(site, scene)).hearing.amplitude_1m_v, 4.0);
}

TEST(SurveyModel, ObstaclesHaveOneSideMoreThanWallsOfAsManyPoints) {
  Scene scene = test::small_scene();
  const SurveyModel model = must(make_survey_model(small_site(), scene));
  ASSERT_EQ(model.walls.size(), 4U + 1U);
  double round_m = 0.0;
  for (std::size_t i = 0; i < 4; ++i) round_m += (model.walls[i].to_m - model.walls[i].from_m).norm();
  EXPECT_DOUBLE_EQ(round_m, 8.0) << "all round the column";
  EXPECT_EQ(model.walls[4].top_m, 2.0);
  scene.walls[0].blocks_sound = false;
  EXPECT_EQ(must(make_survey_model(small_site(), scene)).walls.size(), 1U);
}

TEST(SurveyModel, PatternsAreOfThoseThatLookSomewhere) {
  Site site = small_site();
  Scene scene = bare_scene();
  BeamPattern beam;
  beam.name = "beam", beam.kind = BeamPattern::Kind::kCosinePower;
  scene.patterns = {beam, beam};
  scene.beacons = {{"B2", Eigen::Vector3d(0, 0, -3), std::size_t{1}, 8}};
  scene.receiver_pattern = 0;
  const SurveyModel model = must(make_survey_model(site, scene));
  EXPECT_EQ(model.beacons[2].pattern, 1U);
  EXPECT_EQ(model.beacons[2].axis, Eigen::Vector3d(0, 0, -1)) << "a unit vector";
  EXPECT_EQ(model.beacons[0].pattern, kAllRound);
  for (const SurveyReceiver& r : model.receivers) EXPECT_EQ(r.pattern, 0U);
  scene.beacons[0].axis.reset();
  const auto error = make_survey_model(site, scene);
  ASSERT_FALSE(error);
  EXPECT_EQ(error.error().line, 8);
  EXPECT_THAT(error.error().message(), HasSubstr("beacon 'B2' has a pattern and no axis"));
}

/// Receivers without an entry in the scene have the calibrated directivity, each its own.
TEST(SurveyModel, ReceiversHearAsWidelyAsTheyWereHeardToHear) {
  Deployment d = small_deployment();
  d.vehicles[0].receiver_count = 4;
  d.receivers.clear();
  const Eigen::Vector3d ahead(1, 0, 0);
  for (const auto& cosine : {std::optional(0.5), std::optional(0.5), std::optional(-0.5)})
    d.receivers.push_back({.name = "r" + std::to_string(d.receivers.size()),
                           .vehicle = VehicleId(0),
                           .position_m = {0.1 * static_cast<double>(d.receivers.size()), 0, 0.3},
                           .axis = ahead,
                           .hearing_cosine = cosine});
  d.receivers.push_back({.name = "r3", .vehicle = VehicleId(0), .position_m = {0, 0.2, 0.3}, .axis = {}});
  const SurveyModel model = must(make_survey_model(d, bare_scene()));
  ASSERT_EQ(model.patterns.size(), 2U) << "one for those that are alike";
  EXPECT_EQ(model.receivers[0].pattern, model.receivers[1].pattern);
  EXPECT_NEAR(model.patterns[model.receivers[0].pattern].half_angle_rad, std::numbers::pi / 3, 1e-12);
  EXPECT_NEAR(model.patterns[model.receivers[2].pattern].half_angle_rad, 2 * std::numbers::pi / 3, 1e-12);
  EXPECT_EQ(model.receivers[3].pattern, kAllRound) << "it looks nowhere";
}

TEST(SurveyModel, WithoutBeaconsTheFloorMustBeDrawn) {
  const SurveyModel empty = must(make_empty_survey_model(small_site(), bare_scene()));
  EXPECT_TRUE(empty.beacons.empty());
  EXPECT_EQ(empty.receivers.size(), 8U);
  EXPECT_DOUBLE_EQ(signed_area_m2(empty.floor_m), 96.0);
  const auto none = make_empty_survey_model(small_site(), Scene{});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message(), HasSubstr("the scene has no floor"));
}

}  // namespace survey_model_test
}  // namespace octant::survey
