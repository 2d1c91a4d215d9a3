// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/survey.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "models/physics/polygon.h"
#include "models/physics/receiver_array.h"
#include "models/simulator/random.h"
#include "survey/geometry/make_survey_model.h"
#include "survey/geometry/map_tiles.h"
#include "survey/geometry/scene_check.h"
#include "survey/map/calibration_map.h"
#include "survey/map/mirror.h"
#include "survey/map/survey_csv.h"
#include "survey/page/survey_verdict.h"
#include "tests/support/worlds.h"
#include "tests/survey/brute_force.h"
#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace survey_test {

using test::must;
using test::small_scene;
using test::small_site;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Survey, CellsAreTheFreeFloor) {
  const Scene scene = small_scene();
  const auto grid = must(make_floor_grid(must(make_survey_model(small_site(), scene)), scene));
  EXPECT_EQ(grid.columns, 24u);
  EXPECT_EQ(grid.rows, 16u);
  EXPECT_EQ(grid.cells.size(), 24u * 16u - 16u);  // the column takes 2 x 2 m
  for (const auto cell : grid.cells) EXPECT_FALSE(is_inside(scene.walls[0].points_m, grid.centre_m(cell)));
}

// The result does not depend on the examination of single failures, or on the threads; each is checked by
// surveying the geometry without the beacons.
TEST(Survey, FailuresAgreeWithSurveysWithoutTheBeacons) {
  const Scene scene = small_scene();
  for (const Clock clock : {Clock::kSynchronised, Clock::kCycleOffset}) {
    Site site = small_site();
    site.timing.clock = clock;
    SurveyModel model = must(make_survey_model(site, scene));
    model.hearing.range_m = 9.0;
    const auto survey = must(run_survey(model, scene, nullptr, {.threads = 2}));
    const auto& whole = survey.find("sigma_m")->values;
    std::vector<float> worst_one = whole, worst_two = whole;
    const auto without = [&](const std::vector<std::size_t>& gone) {
      SurveyModel less = model;
      for (auto g = gone.rbegin(); g != gone.rend(); ++g)
        less.beacons.erase(less.beacons.begin() + static_cast<std::ptrdiff_t>(*g));
      return must(run_survey(less, scene, nullptr, {.failures = 0, .integrity = false}))
          .find("sigma_m")
          ->values;
    };
    const auto agree = [&](const Loss& loss, const std::vector<float>& after) {
      std::size_t out = 0, no_fix = 0;
      for (std::size_t i = 0; i < whole.size(); ++i) {
        if (std::isinf(whole[i])) continue;
        if (std::isinf(after[i])) ++no_fix;
        if (whole[i] <= 0.003F && !(after[i] <= 0.003F)) ++out;
      }
      EXPECT_EQ(loss.poses_without_fix, no_fix);
      EXPECT_EQ(loss.poses_out, out);
    };
    for (std::size_t a = 0; a < model.beacons.size(); ++a) {
      const auto after = without({a});
      const auto loss = std::find_if(survey.failures.begin(), survey.failures.end(),
                                     [&](const Loss& l) { return l.first == a; });
      ASSERT_NE(loss, survey.failures.end());
      agree(*loss, after);
      for (std::size_t i = 0; i < whole.size(); ++i) worst_one[i] = std::max(worst_one[i], after[i]);
      for (std::size_t b = a + 1; b < model.beacons.size(); ++b) {
        const auto both = without({a, b});
        for (std::size_t i = 0; i < whole.size(); ++i) worst_two[i] = std::max(worst_two[i], both[i]);
        for (const Loss& pair : survey.double_failures)
          if (pair.first == a && pair.second == b) agree(pair, both);
      }
    }
    // Floats, of differences whose cancellation costs no more than the geometry's own condition.
    const auto& one = survey.find("loss_one_m")->values;
    const auto& two = survey.find("loss_two_m")->values;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      EXPECT_TRUE(one[i] == worst_one[i] || std::abs(one[i] - worst_one[i]) < 1e-4F * worst_one[i])
          << i << " " << one[i] << " " << worst_one[i];
      EXPECT_TRUE(two[i] == worst_two[i] || std::abs(two[i] - worst_two[i]) < 1e-4F * worst_two[i])
          << i << " " << two[i] << " " << worst_two[i];
    }
    EXPECT_GT(survey.failures[0].poses_out, 0u) << "some failure matters here";
    EXPECT_GE(survey.failures[0].poses_out, survey.failures[1].poses_out);
  }
}

TEST(Survey, ThreadsAndFailuresChangeNothingElse) {
  const Scene scene = small_scene();
  const SurveyModel model = must(make_survey_model(small_site(), scene));
  const auto one = must(run_survey(model, scene, nullptr, {.threads = 1})),
             three = must(run_survey(model, scene, nullptr, {.threads = 3}));
  const auto none = must(run_survey(model, scene, nullptr, {.failures = 0}));
  for (const FloorMap& map : one.maps) EXPECT_EQ(map.values, three.find(map.name)->values) << map.name;
  for (const FloorMap& map : none.maps) EXPECT_EQ(map.values, one.find(map.name)->values) << map.name;
  for (std::size_t i = 0; i < one.failures.size(); ++i)
    EXPECT_EQ(one.failures[i].spread_ppm, three.failures[i].spread_ppm);
}

TEST(Survey, SumsAreThoseOfTheMaps) {
  const Scene scene = small_scene();
  SurveyModel model = must(make_survey_model(small_site(), scene));
  model.hearing.range_m = 6.0;
  const auto survey = must(run_survey(model, scene, nullptr));
  const auto& sigma = survey.find("sigma_m")->values;
  const auto& beacons = survey.find("beacons_heard")->values;
  std::size_t within = 0, fix = 0, k = 0, heard0 = 0;
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    within += sigma[i] <= 0.003F, fix += std::isfinite(sigma[i]), k += beacons[i] >= 3.0F,
        heard0 += survey.hears(0, i);
    int heard = 0;
    for (std::size_t b = 0; b < model.beacons.size(); ++b) heard += survey.hears(b, i);
    EXPECT_EQ(heard, static_cast<int>(beacons[i]));
  }
  const auto cells = static_cast<double>(sigma.size());
  EXPECT_EQ(survey.coverage, 3);
  EXPECT_DOUBLE_EQ(survey.covered_fraction, static_cast<double>(within) / cells);
  EXPECT_DOUBLE_EQ(survey.fix_fraction, static_cast<double>(fix) / cells);
  EXPECT_DOUBLE_EQ(survey.k_covered_fraction, static_cast<double>(k) / cells);
  EXPECT_DOUBLE_EQ(survey.heard_fraction[0], static_cast<double>(heard0) / cells);
  const Spread& s = survey.find("hdop")->spread;
  EXPECT_TRUE(s.min <= s.median && s.median <= s.p95 && s.p95 <= s.max);
  EXPECT_EQ(s.count + s.without, sigma.size());
  ASSERT_EQ(survey.routes.size(), 1u);
  EXPECT_EQ(survey.routes[0].poses.size(), 1u + 20u + 12u);
  EXPECT_NEAR(survey.routes[0].poses.heading_rad.back(), std::numbers::pi / 2, 1e-12);
}

/// A deployment of the small site's beacons, each known to some millimetres, the speed to 0.2 m/s.
Deployment small_deployment() {
  Scenario scenario = test::hall_scenario();
  scenario.site = small_site();
  scenario.hall_m = {12, 8};
  scenario.path.epochs = scenario.heldout_path.epochs = 1;
  Deployment d = must(simulate(scenario, 1)).truth;
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    d.beacons[b].covariance_m2 = 1e-6 * static_cast<double>(b + 1) * Eigen::Vector3d(1, 2, 3).asDiagonal();
  d.speed_sigma_mps = 0.2;
  d.tolerance.fix_m = 0.006;
  return d;
}

// The maps of a survey against the figures at one pose and the calibration's part there.
TEST(Survey, TotalAndProtectionHoldTheCalibrationsPart) {
  const Scene scene = small_scene();
  const Deployment deployment = small_deployment();
  SurveyModel model = must(make_survey_model(deployment, scene));
  model.hearing.range_m = 9.0;
  const auto survey = must(run_survey(model, scene, &deployment));
  ASSERT_TRUE(survey.calibrated);
  const auto map = [&](const char* name, std::size_t i) {
    return static_cast<double>(survey.find(name)->values[i]);
  };
  const CalibrationMap calibration(deployment, model);
  const KernelModel kernel = kernel_model(model, model.beacons);
  const PoseList poses = poses_of(survey.grid, 0.0, 0.0);
  const auto f = evaluate_poses(model, poses);
  std::size_t within = 0, noise_alone_within = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    within += map("total_m", i) <= 0.006, noise_alone_within += map("sigma_m", i) <= 0.006;
    if (i % 7 != 0 || f[kSigma][i] == kNoFix) continue;
    const PoseAt at{poses.x_m[i], poses.y_m[i], 0.0, 0.0};
    KernelTile tile;
    fill_tile(kernel, model.walls, poses, i, 1, tile);
    std::vector<std::vector<HeardPath>> paths(1);
    std::vector<SystematicPart> part(1);
    heard_paths(model, tile, at, paths[0]);
    calibration.systematic(model, paths, part);
    const double systematic_m2 = part[0].xx_m2 + part[0].yy_m2;
    const auto near = [&](const char* name, double expected) {
      EXPECT_NEAR(map(name, i), expected, 1e-5 * expected) << name << " " << i;
    };  // floats
    near("sigma_m", f[kSigma][i]);
    near("calibration_m", std::sqrt(systematic_m2));
    near("total_m", std::sqrt(f[kSigma][i] * f[kSigma][i] + systematic_m2));
    near("speed_part_m", f[kShiftBySpeed][i] * 0.2 / model.speed_mps);
    if (f[kFaultShift][i] == kNoFix) continue;
    Eigen::Matrix2d C;
    C << f[kSigmaX][i] * f[kSigmaX][i] + part[0].xx_m2, f[kCovarianceXy][i] + part[0].xy_m2, 0,
        f[kSigmaY][i] * f[kSigmaY][i] + part[0].yy_m2;
    C(1, 0) = C(0, 1);
    near("protection_m",
         f[kFaultShift][i] +
             3.29 * std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(C).eigenvalues()[1]));
  }
  EXPECT_LT(within, noise_alone_within) << "the calibration's part matters here";
  EXPECT_GT(within, 0u);
  EXPECT_DOUBLE_EQ(survey.covered_fraction, static_cast<double>(within) / static_cast<double>(poses.size()));
  // A beacon's failure is compared with the tolerance including the calibration's part of the whole geometry.
  for (const Loss& loss : survey.failures) {
    SurveyModel less = model;
    less.beacons.erase(less.beacons.begin() + static_cast<std::ptrdiff_t>(loss.first));
    const auto after =
        must(run_survey(less, scene, nullptr, {.failures = 0, .integrity = false})).find("sigma_m")->values;
    std::size_t out = 0;
    for (std::size_t i = 0; i < poses.size(); ++i)
      out += map("total_m", i) <= 0.006 &&
             !(std::hypot(static_cast<double>(after[i]), map("calibration_m", i)) <= 0.006);
    EXPECT_EQ(loss.poses_out, out) << loss.first;
  }
}

TEST(Survey, OfSeveralHeadingsTheWorstCounts) {
  Scene scene = small_scene();
  scene.headings = 6;
  SurveyModel model = must(make_survey_model(small_site(4), scene));
  const auto survey = must(run_survey(model, scene, nullptr, {.failures = 0}));
  std::vector<double> worst(survey.grid.cells.size(), 0.0), first;
  for (int h = 0; h < 6; ++h) {
    const auto sigma = evaluate_poses(model, poses_of(survey.grid, h * std::numbers::pi / 3, 0.0))[kSigma];
    if (h == 0) first = sigma;
    for (std::size_t i = 0; i < worst.size(); ++i) worst[i] = std::max(worst[i], sigma[i]);
  }
  EXPECT_NE(worst, first) << "headings matter here";
  for (std::size_t i = 0; i < worst.size(); ++i)
    EXPECT_FLOAT_EQ(survey.find("sigma_m")->values[i], static_cast<float>(worst[i])) << i;
}

// Ranges measured at c1 and interpreted with c0 have an error of d (c0 / c1 - 1); the plain least-squares fix
// of such ranges.
TEST(Survey, TemperatureWhatIf) {
  Scene scene = small_scene();
  scene.walls.clear();
  Site site = small_site();
  site.receivers.resize(1);
  site.receivers[0].axis.reset();
  site.vehicles[0].receiver_count = 1;
  const SurveyModel model = must(make_survey_model(site, scene));
  const auto survey = must(run_survey(model, scene, nullptr));
  const double c0 = speed_mps(model.medium, 20), c1 = speed_mps(model.medium, 25);
  EXPECT_NEAR(1e6 * survey.speed_error, 1e6 * (c0 / c1 - 1), 1e-6);
  for (std::size_t i = 0; i < survey.grid.cells.size(); i += 17) {
    const Eigen::Vector2d p = survey.grid.centre_m(survey.grid.cells[i]);
    const auto arrivals = test::brute_arrivals(model, p.x(), p.y(), 0, 0);
    Eigen::MatrixXd H(arrivals.size(), 2);
    Eigen::VectorXd error(arrivals.size());
    for (std::size_t a = 0; a < arrivals.size(); ++a)
      H.row(static_cast<Eigen::Index>(a)) = arrivals[a].row,
      error[static_cast<Eigen::Index>(a)] = arrivals[a].distance_m * (c0 / c1 - 1);
    const double expected = H.colPivHouseholderQr().solve(error).norm();
    EXPECT_NEAR(survey.find("temperature_m")->values[i], expected, 1e-6 + 1e-5 * expected);
  }
}

TEST(Survey, MirrorImagesWhereBeaconsStandInALine) {
  Scene scene = small_scene();
  scene.walls.clear();
  Site site = small_site(0);
  site.tolerance.fix_m = 10.0;
  for (int i = 0; i < 4; ++i)
    site.beacons.push_back(test::beacon("L" + std::to_string(i), {3.0 * i + 1, 4.0, 2.5}, 0.0));
  site.receivers.resize(1);
  site.receivers[0].axis.reset();
  site.receivers[0].position_m.setZero();
  site.vehicles[0].receiver_count = 1;
  const auto mirrored = must(run_survey(must(make_survey_model(site, scene)), scene, nullptr));
  const auto cells = static_cast<double>(mirrored.grid.cells.size());
  EXPECT_GT(mirrored.mirror_fraction, 0.99);
  EXPECT_GT(mirrored.fix_fraction, 0.99);
  EXPECT_NEAR(mirrored.covered_fraction, 1.0 - mirrored.mirror_fraction, 1e-9) << "one of two places is none";
  EXPECT_NE(survey_verdict(mirrored).grade, Grade::kGood);
  // Every image lies across the line, at the same distances.
  const SurveyModel model = must(make_survey_model(site, scene));
  std::vector<HeardPath> paths;
  for (std::size_t b = 0; b < 4; ++b) paths.push_back(path_between(model, b, 0, {3.3, 6.1, 0, 0}));
  const MirrorImage image = mirror_image(model, {3.3, 6.1, 0, 0}, paths);
  ASSERT_TRUE(image.ambiguous);
  EXPECT_NEAR((image.p_map_m - Eigen::Vector2d(3.3, 1.9)).norm(), 0.0, 1e-6);
  // One beacon half a metre off the line resolves it (a discrepancy of 4 H h / (d + d'), many millimetres).
  site.beacons[3].position_m[1] = 4.5;
  const auto told = must(run_survey(must(make_survey_model(site, scene)), scene, nullptr));
  EXPECT_LT(told.mirror_fraction * cells, 0.2 * cells);
  // Beacons along one wall: the image is outside, where no vehicle is.
  for (auto& beacon : site.beacons) beacon.position_m[1] = 0.0;
  EXPECT_EQ(must(run_survey(must(make_survey_model(site, scene)), scene, nullptr)).mirror_fraction, 0.0);
}

// The quick look before the adjustment leaves no image out: beacons a centimetre off a line, whose images
// still explain the ranges.
TEST(Survey, MirrorFilterLetsEveryImageThrough) {
  Scene scene = small_scene();
  scene.walls.clear();
  Site site = small_site(0);
  for (int i = 0; i < 4; ++i)
    site.beacons.push_back(
        test::beacon("L" + std::to_string(i), {3.0 * i + 1, 4.0 + 0.01 * (i % 2), 2.5}, 0.0));
  site.receivers.resize(1);
  site.receivers[0].axis.reset();
  site.vehicles[0].receiver_count = 1;
  const SurveyModel model = must(make_survey_model(site, scene));
  MirrorFilter filter;
  std::size_t images = 0;
  for (double x = 0.5; x < 12; x += 0.7)
    for (double y = 0.3; y < 8; y += 0.6) {
      const PoseAt pose{x, y, 0, 0.3};
      std::vector<HeardPath> paths;
      for (std::size_t b = 0; b < 4; ++b)
        for (std::size_t r = 0; r < model.receivers.size(); ++r)
          paths.push_back(path_between(model, b, r, pose));
      if (!mirror_image(model, pose, paths).ambiguous) continue;
      ++images;
      EXPECT_TRUE(filter.may_have_image(model, pose, {0, 1, 2, 3})) << x << ", " << y;
    }
  EXPECT_GT(images, 10u);
}

TEST(Survey, ReachAndAbsorption) {
  Scene scene = small_scene();
  scene.acoustics = {.frequency_hz = 40000, .amplitude_1m_v = 10.0, .threshold_v = 0.1};
  const SurveyModel model = must(make_survey_model(small_site(), scene));
  // ISO 9613-1 at 20 degC, 50 %, 101325 Pa, 40 kHz: 1.318 dB/m.
  EXPECT_NEAR(8.685889638 * model.hearing.absorption_np_per_m, 1.318, 5e-4);
  const double reach = reach_m(model.hearing);
  EXPECT_NEAR(10.0 / reach * std::exp(-model.hearing.absorption_np_per_m * reach), 0.1, 1e-9);
  EXPECT_TRUE(std::isinf(reach_m({})));
}

TEST(Survey, OutlineWithoutAScene) {
  const auto hull = must(make_survey_model(small_site(6), {})).floor_m;
  EXPECT_NEAR(signed_area_m2(hull), 96.0, 1e-9);
  Site line = small_site(3);
  EXPECT_NEAR(signed_area_m2(must(make_survey_model(line, {})).floor_m), 16.0 * 4.0,
              1e-9);  // 2 m round a line of 12 m
  Scenario scenario = test::hall_scenario();
  scenario.path.epochs = scenario.heldout_path.epochs = 1;
  Deployment deployment = must(simulate(scenario, 1)).truth;
  deployment.validity_area_m = {{1, 1}, {5, 1}, {5, 4}};
  EXPECT_EQ(must(make_survey_model(deployment, {})).floor_m.size(), 3u);
}
TEST(Survey, BadScenesNameTheElement) {
  const auto error_of = [](auto change, const char* expected) {
    Scene scene = small_scene();
    scene.path = "s.yaml";
    change(scene);
    const auto model = make_survey_model(small_site(), scene);
    if (!model) {
      EXPECT_EQ(model.error().code, Errc::kBadInput);
      EXPECT_THAT(model.error().message(), HasSubstr(expected));
      return;
    }
    const auto survey = run_survey(*model, scene, nullptr);
    ASSERT_FALSE(survey) << expected;
    EXPECT_THAT(survey.error().message(), HasSubstr(expected));
  };
  error_of([](Scene& s) { std::swap(s.floor_m[1], s.floor_m[2]); }, "the floor crosses itself");
  error_of([](Scene& s) { s.floor_m.resize(2); }, "the floor has 2 corners");
  error_of([](Scene& s) { s.floor_m = {{0, 0}, {1, 0}, {2, 0}}; }, "the floor");
  error_of([](Scene& s) { std::swap(s.walls[0].points_m[1], s.walls[0].points_m[2]); },
           "obstacle 'column' crosses itself");
  error_of([](Scene& s) { s.walls[0].points_m = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}; }, "beacon 'B0'");
  error_of([](Scene& s) { s.floor_m[2].x() = s.floor_m[1].x() = 11; }, "beacon 'B2'");
  error_of([](Scene& s) { s.walls[1].top_m = -1; }, "wall 'curtain'");
  error_of([](Scene& s) { s.walls[1].points_m = {{1, 1}, {1, 1}}; }, "wall 'curtain'");
  error_of([](Scene& s) { s.routes[0].points_m = {{1, 1}, {20, 1}}; }, "route 'way' leaves the floor");
  error_of(
      [](Scene& s) {
        s.routes[0].points_m = {{1, 1}, {6, 4}};
      },
      "route 'way' runs through obstacle 'column'");
  error_of(
      [](Scene& s) {
        s.routes[0].points_m = {{1, 1}, {1e9, 1}}, s.floor_m.clear(), s.walls.clear();
      },
      "route 'way' has more poses");
  error_of([](Scene& s) { s.cell_m = 0; }, "cell_m is 0");
  error_of([](Scene& s) { s.cell_m = 1e-4; }, "9.6e+09 cells");
  error_of(
      [](Scene& s) {
        s.walls[0].points_m = {{0.01, 0.01}, {11.99, 0.01}, {11.99, 7.99}, {0.01, 7.99}}, s.routes.clear();
      },
      "not a single cell");
  error_of([](Scene& s) { s.beacons = {{"B77", {}, {}, 4}}; }, "beacon 'B77' is not in the site");
  error_of([](Scene& s) { s.patterns.resize(1), s.beacon_pattern = 0; }, "has no axis");
  error_of(
      [](Scene& s) {
        s.patterns = {
            {.name = "t", .kind = BeamPattern::Kind::kTable, .angle_rad = {0, 1, 1}, .gain = {1, 1, 0}}};
      },
      "pattern 't'");
  error_of([](Scene& s) { s.acoustics.threshold_v = 1.0; }, "threshold_v alone");
  error_of([](Scene& s) { s.mounts = {{.name = "m", .kind = SceneMount::Kind::kPole}}; }, "mount 'm'");
}

}  // namespace survey_test
}  // namespace octant::survey
