// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Predictions of the maps, compared with the localizer: Monte Carlo over noise and over the calibration's
// errors.
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "models/localizers/least_squares/epoch_fix.h"
#include "models/simulator/random.h"
#include "survey/geometry/make_survey_model.h"
#include "survey/geometry/map_tiles.h"
#include "survey/map/calibration_map.h"
#include "survey/map/survey.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"
#include "tests/survey/brute_force.h"
#include "tests/survey/calibration_errors.h"

namespace octant::survey {
namespace predicted_test {

using test::add_covariance;
using test::must;
using test::with_errors;

constexpr int kDraws = 400;  // of 2 degrees of freedom each: the RMSE's own standard deviation is 2.5 %

std::vector<Arrival> arrivals_at(const Deployment& truth, const SurveyModel& model, const PoseAt& pose,
                                 double offset_s, Random& draw) {
  std::vector<Arrival> arrivals;
  const double speed = truth.speed_mps(truth.medium.temperature_degC);
  for (std::size_t b = 0; b < model.beacons.size(); ++b)
    for (std::size_t r = 0; r < model.receivers.size(); ++r) {
      const HeardPath path = path_between(model, b, r, pose);
      const Eigen::Vector3d axis =
          Eigen::AngleAxisd(pose.heading_rad, Eigen::Vector3d::UnitZ()) * model.receivers[r].axis;
      if (path.distance_m > model.hearing.range_m ||
          test::gain_at(model, model.receivers[r].pattern, axis, -path.unit) <= 0)
        continue;
      Arrival a;
      a.time_s = 0.05 * static_cast<double>(b);
      a.epoch = 1;
      a.beacon = BeaconId(b), a.receiver = ReceiverId(r), a.vehicle = VehicleId(std::size_t{0});
      a.tof_s = path.distance_m / speed + truth.beacons[b].delay_s + truth.receivers[r].delay_s + offset_s +
                truth.noise.tof_sigma_s * draw.normal();
      arrivals.push_back(a);
    }
  return arrivals;
}

/// Errors of fixes at one place.
struct Achieved {
  double square_m2 = 0.0, nees = 0.0, heading_rad2 = 0.0;
  int fixes = 0;
};

void expect_as_predicted(const Achieved& achieved, const GeometryFigures& map, const SystematicPart& part,
                         std::size_t i, bool calibrated, bool has_heading) {
  // NEES of both coordinates over all draws is chi-square; bounds of 1e-4 a side, as there are some dozens
  // of places.
  const int fixes = achieved.fixes;
  ASSERT_GT(fixes, 0.98 * kDraws);
  EXPECT_GT(achieved.nees, test::chi2_quantile(1e-4, 2 * fixes)) << i;
  EXPECT_LT(achieved.nees, test::chi2_quantile(1 - 1e-4, 2 * fixes)) << i;
  const double predicted = std::sqrt(map[kSigma][i] * map[kSigma][i] + part.xx_m2 + part.yy_m2);
  EXPECT_NEAR(std::sqrt(achieved.square_m2 / fixes) / predicted, 1.0, 0.1) << i;
  if (calibrated)
    EXPECT_GT(part.xx_m2 + part.yy_m2, 0.2 * map[kSigma][i] * map[kSigma][i])
        << "the part that is tested counts";
  if (!calibrated && has_heading) {
    const double chi2 = achieved.heading_rad2 / std::pow(map[kSigmaHeading][i], 2);
    EXPECT_GT(chi2, test::chi2_quantile(1e-4, fixes));
    EXPECT_LT(chi2, test::chi2_quantile(1 - 1e-4, fixes));
  }
}

void compare(Deployment truth, const Scene& scene, const std::vector<PoseAt>& places, bool calibrated,
             std::uint64_t seed) {
  Random draw(seed);
  if (calibrated) add_covariance(truth, draw);
  const SurveyModel model = must(make_survey_model(truth, scene));
  PoseList poses;
  for (const PoseAt& p : places) poses.add(p.x_m, p.y_m, p.z_m, p.heading_rad);
  const auto map = evaluate_poses(model, poses);
  const CalibrationMap calibration(truth, model);
  const KernelModel kernel = kernel_model(model, model.beacons);
  KernelTile tile;
  fill_tile(kernel, model.walls, poses, 0, poses.size(), tile);
  std::vector<std::vector<HeardPath>> paths(places.size());
  std::vector<SystematicPart> parts(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) heard_paths(model, tile, places[i], paths[i]);
  calibration.systematic(model, paths, parts);

  std::vector<Achieved> achieved(places.size());
  const Eigen::MatrixXd root =
      calibrated ? Eigen::MatrixXd(Eigen::LLT<Eigen::MatrixXd>(truth.covariance.matrix).matrixL())
                 : Eigen::MatrixXd();
  for (int k = 0; k < kDraws; ++k) {
    Deployment believed = truth;
    if (calibrated) {
      Eigen::VectorXd normal(root.cols());
      for (double& v : normal) v = draw.normal();
      believed = with_errors(truth, root * normal);
    }
    LeastSquaresLocalizer localizer(believed, {.rejection_sigmas = 8.0});  // no arrival is at fault here
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Fix fix = localizer.locate(
          arrivals_at(truth, model, places[i],
                      truth.timing.clock == Clock::kCycleOffset ? draw.uniform(0, 0.05) : 0.0, draw));
      if (!fix.ok()) continue;  // the search found two answers, once in some hundred times with cycle offsets
      ++achieved[i].fixes;
      const Eigen::Vector2d e =
          fix.T_map_vehicle.translation_m.head<2>() - Eigen::Vector2d(places[i].x_m, places[i].y_m);
      Eigen::Matrix2d C;
      C << std::pow(map[kSigmaX][i], 2) + parts[i].xx_m2, map[kCovarianceXy][i] + parts[i].xy_m2, 0,
          std::pow(map[kSigmaY][i], 2) + parts[i].yy_m2;
      C(1, 0) = C(0, 1);
      achieved[i].square_m2 += e.squaredNorm();
      achieved[i].nees += e.dot(C.inverse() * e);
      achieved[i].heading_rad2 +=
          std::pow(wrap_angle(fix.T_map_vehicle.heading_rad() - places[i].heading_rad), 2);
    }
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    SCOPED_TRACE(seed);
    expect_as_predicted(achieved[i], map, parts[i], i, calibrated, model.unknowns.rotation == 1);
  }
}

/// Noise-free arrivals, with reception and lateness by the truth.
std::vector<Arrival> exact_arrivals(Deployment truth, const SurveyModel& model, const PoseAt& pose) {
  truth.noise.tof_sigma_s = 0.0;
  Random unused(1);
  auto arrivals = arrivals_at(truth, model, pose, 0.0, unused);
  if (!truth.attenuation) return arrivals;
  for (Arrival& a : arrivals) {
    const HeardPath path = path_between(model, a.beacon.index(), a.receiver.index(), pose);
    a.tof_s += must(time_walk_s(amplitude_v(path.distance_m, *truth.attenuation), *truth.attenuation));
  }
  return arrivals;
}

/// Horizontal covariance of a fix from the calibration alone.
SystematicPart part_at(const Deployment& d, const SurveyModel& model, const PoseAt& place) {
  PoseList poses;
  poses.add(place.x_m, place.y_m, place.z_m, place.heading_rad);
  const KernelModel kernel = kernel_model(model, model.beacons);
  KernelTile tile;
  fill_tile(kernel, model.walls, poses, 0, 1, tile);
  std::vector<std::vector<HeardPath>> paths(1);
  std::vector<SystematicPart> parts(1);
  heard_paths(model, tile, place, paths[0]);
  CalibrationMap(d, model).systematic(model, paths, parts);
  return parts[0];
}

/// A calibrated parameter: its name in the joint covariance, a small error, and its field in a deployment.
struct Parameter {
  std::string name;
  double error = 0.0;
  std::function<void(Deployment&, double)> add;
};

std::vector<Parameter> parameters_of(const Deployment& d) {
  std::vector<Parameter> all;
  const char* axes[] = {"/x_m", "/y_m", "/z_m"};
  for (const std::size_t b : {std::size_t{1}, std::size_t{4}}) {
    for (int i = 0; i < 3; ++i)
      all.push_back({"beacon/" + d.beacons[b].name + axes[i], 1e-3,
                     [b, i](Deployment& x, double e) { x.beacons[b].position_m[i] += e; }});
    all.push_back({"beacon/" + d.beacons[b].name + "/delay_s", 2e-6,
                   [b](Deployment& x, double e) { x.beacons[b].delay_s += e; }});
  }
  for (const std::size_t r : {std::size_t{0}, std::size_t{3}}) {
    for (int i = 0; i < 3; ++i)
      all.push_back({"receiver/robot/" + d.receivers[r].name + axes[i], 1e-3,
                     [r, i](Deployment& x, double e) { x.receivers[r].position_m[i] += e; }});
    all.push_back({"receiver/robot/" + d.receivers[r].name + "/delay_s", 2e-6,
                   [r](Deployment& x, double e) { x.receivers[r].delay_s += e; }});
  }
  all.push_back({"site/delay_s", 2e-6, [](Deployment& x, double e) {
                   for (auto& b : x.beacons) b.delay_s += e;
                 }});
  all.push_back({"medium/speed_mps", 0.1, [](Deployment& x, double e) { x.speed_offset_mps += e; }});
  all.push_back({"attenuation/amplitude_1m_v", 0.2,
                 [](Deployment& x, double e) { x.attenuation->amplitude_1m_v += e; }});
  all.push_back({"attenuation/absorption_np_per_m", 2e-3,
                 [](Deployment& x, double e) { x.attenuation->absorption_np_per_m += e; }});
  all.push_back(
      {"attenuation/rise_time_s", 1e-5, [](Deployment& x, double e) { x.attenuation->rise_time_s += e; }});
  return all;
}

std::vector<PoseAt> grid_of_places(double turn) {
  std::vector<PoseAt> places;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 2; ++j) places.push_back({2.0 + 5.2 * i, 2.5 + 6.4 * j, 0.0, turn * (i + j)});
  return places;
}

Deployment hall_truth() {
  Scenario scenario = test::hall_scenario();
  scenario.path.epochs = scenario.heldout_path.epochs = 1;
  return must(simulate(scenario, 3)).truth;
}

TEST(Predicted, NoiseOfAnOctagonInTheHall) { compare(hall_truth(), {}, grid_of_places(0.7), false, 11); }

TEST(Predicted, WithTheCalibrationsPart) { compare(hall_truth(), {}, grid_of_places(-0.4), true, 12); }

// Each kind of parameter on its own, as among all of them the small ones would not be missed: the shift of a
// noise-free fix in a deployment that is wrong in that alone.
TEST(Predicted, EachParametersErrorMovesTheFixAsTheMapSays) {
  Deployment truth = hall_truth();
  truth.attenuation = AttenuationModel{
      .amplitude_1m_v = 12.5, .absorption_np_per_m = 0.08, .threshold_v = 0.05, .rise_time_s = 4.5e-4};
  const SurveyModel model = must(make_survey_model(truth, {}));
  const PoseAt place{7.2, 4.4, 0.0, 0.6};
  const auto arrivals = exact_arrivals(truth, model, place);
  const auto fix_with = [&](const Parameter& p, double error) -> Eigen::Vector2d {
    Deployment wrong = truth;
    p.add(wrong, error);
    const Fix fix = LeastSquaresLocalizer(wrong, {.rejection_sigmas = 8.0}).locate(arrivals);
    EXPECT_TRUE(fix.ok()) << p.name;
    return fix.T_map_vehicle.translation_m.head<2>();
  };
  for (const Parameter& p : parameters_of(truth)) {
    const Eigen::Vector2d shift = (fix_with(p, p.error) - fix_with(p, -p.error)) / 2;
    EXPECT_GT(shift.norm(), 1e-6) << p.name << " moves the fix by more than the fix' own rounding";
    Deployment known = truth;
    const NameTable names = names_of(known);
    known.covariance.parameters = {ParameterLookup(names).find(p.name).value()};
    known.covariance.matrix = Eigen::MatrixXd::Constant(1, 1, p.error * p.error);
    const SystematicPart part = part_at(known, model, place);
    // The map leaves the slope of the time-walk along the path out: some 1 % of a range.
    const double tolerance = 0.03 * shift.squaredNorm();
    EXPECT_NEAR(part.xx_m2, shift.x() * shift.x(), tolerance) << p.name;
    EXPECT_NEAR(part.xy_m2, shift.x() * shift.y(), tolerance) << p.name;
    EXPECT_NEAR(part.yy_m2, shift.y() * shift.y(), tolerance) << p.name;
  }
}

TEST(Predicted, WithoutAJointCovarianceEachBeaconsOwnCounts) {
  Deployment own = hall_truth(), joint = own;
  own.covariance = {};
  const auto n = static_cast<Eigen::Index>(4 * own.beacons.size() + 1);
  joint.covariance.matrix = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t b = 0; b < own.beacons.size(); ++b) {
    const double s = 1e-3 * static_cast<double>(b + 1);
    own.beacons[b].covariance_m2 << 2 * s * s, s * s / 2, 0, s * s / 2, s * s, 0, 0, 0, s * s;
    own.beacons[b].delay_sigma_s = 1e-6 * static_cast<double>(b + 1);
    for (std::size_t i = 0; i < 3; ++i)
      joint.covariance.parameters.push_back(parameters::beacon_position(b, i));
    joint.covariance.parameters.push_back(parameters::beacon_delay(b));
    const auto at = static_cast<Eigen::Index>(4 * b);
    joint.covariance.matrix.block<3, 3>(at, at) = own.beacons[b].covariance_m2;
    joint.covariance.matrix(at + 3, at + 3) = std::pow(own.beacons[b].delay_sigma_s, 2);
  }
  own.speed_sigma_mps = 0.2;
  joint.covariance.parameters.push_back(parameters::speed());
  joint.covariance.matrix(n - 1, n - 1) = 0.04;
  const SurveyModel model = must(make_survey_model(own, {}));
  const SystematicPart a = part_at(own, model, {7.2, 4.4, 0, 0.6}),
                       b = part_at(joint, model, {7.2, 4.4, 0, 0.6});
  EXPECT_GT(a.xx_m2, 0.0);
  EXPECT_NEAR(a.xx_m2, b.xx_m2, 1e-9 * b.xx_m2);
  EXPECT_NEAR(a.xy_m2, b.xy_m2, 1e-9 * b.xx_m2);
  EXPECT_NEAR(a.yy_m2, b.yy_m2, 1e-9 * b.yy_m2);
}

// One receiver, beacon errors of a millimetre in each direction: sum over beacons of D^-1 h w (u'u mm^2) w h'
// D^-1, by dense matrices.
TEST(Predicted, CalibrationsPartWeighsRangesByTheirNoise) {
  Deployment truth = hall_truth();
  truth.receivers.resize(1);
  truth.receivers[0].axis.reset();
  truth.vehicles[0].receiver_count = 1;
  truth.covariance = {};
  truth.speed_sigma_mps = 0.0;
  for (auto& b : truth.beacons) b.covariance_m2 = 1e-6 * Eigen::Matrix3d::Identity(), b.delay_sigma_s = 0.0;
  Scene scene;
  scene.noise = {.sigma_m_per_m = 2e-3, .sigma_m_per_sqrt_m = 5e-3};
  const SurveyModel model = must(make_survey_model(truth, scene));
  for (const PoseAt& place : grid_of_places(0.0)) {
    const auto arrivals = test::brute_arrivals(model, place.x_m, place.y_m, 0.0, 0.0);
    const Eigen::Matrix2d D = test::information_of(model, arrivals, true);
    Eigen::Matrix2d expected = Eigen::Matrix2d::Zero();
    for (const auto& a : arrivals) {
      const Eigen::Vector2d moved = D.inverse() * a.row / (a.sigma_m * a.sigma_m);
      expected += 1e-6 * moved * moved.transpose();
    }
    const SystematicPart part = part_at(truth, model, place);
    EXPECT_NEAR(part.xx_m2, expected(0, 0), 1e-9 * expected(0, 0));
    EXPECT_NEAR(part.xy_m2, expected(0, 1), 1e-9 * expected(0, 0));
    EXPECT_NEAR(part.yy_m2, expected(1, 1), 1e-9 * expected(1, 1));
  }
}

// A fix that weights each range by its own noise reaches the accuracy of the map: Gauss-Newton steps from the
// true pose, for a vehicle with one receiver. A fix with equal weights, as in the localizers, does not:
// README.md has the difference.
TEST(Predicted, NoiseThatGrowsWithTheRange) {
  for (const Clock clock : {Clock::kSynchronised, Clock::kCycleOffset}) {
    Deployment truth = hall_truth();
    truth.timing.clock = clock;
    truth.receivers.resize(1);
    truth.receivers[0].axis.reset();
    truth.receivers[0].position_m = {0.0, 0.0, 0.4};
    truth.vehicles[0].receiver_count = 1;
    Scene scene;
    scene.noise = {.sigma_m_per_m = 1e-3, .sigma_m_per_sqrt_m = 3e-3};
    const SurveyModel model = must(make_survey_model(truth, scene));
    const double constant_m = truth.noise.tof_sigma_s * truth.speed_mps(truth.medium.temperature_degC);
    const int n = clock == Clock::kSynchronised ? 2 : 3, draws = 4000;
    Random draw(16);
    for (const PoseAt& at : grid_of_places(0.0)) {
      PoseList poses;
      poses.add(at.x_m, at.y_m, 0, 0);
      const auto map = evaluate_poses(model, poses);
      double square_m2 = 0.0, plain_m2 = 0.0;
      for (int k = 0; k < draws; ++k) {
        std::vector<double> range_m, sigma_m;
        for (const auto& b : model.beacons) {
          const double d = (b.p_map_m - Eigen::Vector3d(at.x_m, at.y_m, 0.4)).norm();
          sigma_m.push_back(std::sqrt(constant_m * constant_m + 1e-6 * d * d + 9e-6 * d));
          range_m.push_back(d + sigma_m.back() * draw.normal());
        }
        for (const bool weighed : {true, false}) {
          Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
          x.head<2>() << at.x_m, at.y_m;
          for (int step = 0; step < 3; ++step) {
            Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
            Eigen::VectorXd g = Eigen::VectorXd::Zero(n), row = Eigen::VectorXd::Ones(n);
            for (std::size_t b = 0; b < model.beacons.size(); ++b) {
              const Eigen::Vector3d way = Eigen::Vector3d(x[0], x[1], 0.4) - model.beacons[b].p_map_m;
              row.head<2>() = way.head<2>() / way.norm();
              const double w = weighed ? 1 / (sigma_m[b] * sigma_m[b]) : 1.0;
              A += w * row * row.transpose();
              g += w * row * (range_m[b] - way.norm() - (n == 3 ? x[2] : 0.0));
            }
            x += A.ldlt().solve(g);
          }
          (weighed ? square_m2 : plain_m2) += (x.head<2>() - Eigen::Vector2d(at.x_m, at.y_m)).squaredNorm();
        }
      }
      EXPECT_LT(std::sqrt(plain_m2 / draws) / map[kSigma][0], 1.25) << at.x_m << ", " << at.y_m;
      // The RMSE's own standard deviation is 1 %.
      EXPECT_NEAR(std::sqrt(square_m2 / draws) / map[kSigma][0], 1.0, 0.05) << at.x_m << ", " << at.y_m;
    }
  }
}

TEST(Predicted, WithinReachOnly) {
  Scene scene;
  scene.acoustics.range_m = 13.0;
  compare(hall_truth(), scene, grid_of_places(0.3), true, 13);
}

TEST(Predicted, CycleOffsets) {
  Deployment truth = hall_truth();
  truth.timing.clock = Clock::kCycleOffset;
  std::vector<PoseAt> places = grid_of_places(0.5);
  places.resize(4);  // each takes its time
  compare(truth, {}, places, false, 14);
}

TEST(Predicted, OneReceiver) {
  Deployment truth = hall_truth();
  truth.receivers.resize(1);
  truth.receivers[0].axis.reset();
  truth.receivers[0].position_m = {0.0, 0.0, 0.4};
  truth.vehicles[0].receiver_count = 1;
  compare(truth, {}, grid_of_places(0.0), true, 15);
}

}  // namespace predicted_test
}  // namespace octant::survey
