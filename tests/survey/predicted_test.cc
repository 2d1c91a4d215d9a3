// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// What the maps predict against what the localizer achieves: Monte Carlo over noise and over the calibration's own errors.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "models/localizers/epoch_fix.h"
#include "models/random.h"
#include "survey/calibration_map.h"
#include "survey/map_tiles.h"
#include "survey/survey.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"
#include "tests/survey/brute_force.h"

namespace octant::survey {
namespace {

using test::must;

constexpr int kDraws = 400;  // of 2 degrees of freedom each: the RMSE's own standard deviation is 2.5 %

/// A joint covariance with everything correlated: millimetres, microseconds, tenths of metres a second.
void add_covariance(Deployment& d, Random& draw) {
  auto& names = d.covariance.parameters;
  std::vector<double> sigma;
  for (const auto& b : d.beacons) {
    for (const char* what : {"/x_m", "/y_m", "/z_m"}) names.push_back("beacon/" + b.name + what), sigma.push_back(3e-3);
    names.push_back("beacon/" + b.name + "/delay_s"), sigma.push_back(6e-6);
  }
  for (const auto& r : d.receivers)
    for (const char* what : {"/x_m", "/y_m", "/z_m"}) names.push_back("receiver/robot/" + r.name + what), sigma.push_back(5e-4);
  names.push_back("medium/speed_mps"), sigma.push_back(0.1);
  const auto n = static_cast<Eigen::Index>(names.size());
  Eigen::MatrixXd mix(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) mix(i, j) = draw.normal() / std::sqrt(2.0 * static_cast<double>(n)) + (i == j ? std::sqrt(0.5) : 0.0);
  const Eigen::MatrixXd root = Eigen::Map<const Eigen::VectorXd>(sigma.data(), n).asDiagonal() * mix;
  d.covariance.matrix = root * root.transpose();
}

/// The deployment as a calibration with these errors would have written it.
Deployment with_errors(Deployment d, const Eigen::VectorXd& error) {
  Eigen::Index at = 0;
  for (auto& b : d.beacons) {
    b.position_m += error.segment<3>(at);
    b.delay_s += error[at + 3];
    at += 4;
  }
  for (auto& r : d.receivers) r.position_m += error.segment<3>(at), at += 3;
  d.speed_offset_mps += error[at];
  return d;
}

std::vector<Arrival> arrivals_at(const Deployment& truth, const SurveyModel& model, const PoseAt& pose, double offset_s, Random& draw) {
  std::vector<Arrival> arrivals;
  const double speed = truth.speed_mps(truth.medium.temperature_degC);
  for (std::size_t b = 0; b < model.beacons.size(); ++b)
    for (std::size_t r = 0; r < model.receivers.size(); ++r) {
      const HeardPath path = path_between(model, b, r, pose);
      const Eigen::Vector3d axis = Eigen::AngleAxisd(pose.heading_rad, Eigen::Vector3d::UnitZ()) * model.receivers[r].axis;
      if (path.distance_m > model.hearing.range_m || test::gain_at(model, model.receivers[r].pattern, axis, -path.unit) <= 0) continue;
      Arrival a;
      a.time_s = 0.05 * static_cast<double>(b);
      a.epoch = 1;
      a.beacon = BeaconId(b), a.receiver = ReceiverId(r), a.vehicle = VehicleId(std::size_t{0});
      a.tof_s = path.distance_m / speed + truth.beacons[b].delay_s + truth.receivers[r].delay_s + offset_s + truth.noise.tof_sigma_s * draw.normal();
      arrivals.push_back(a);
    }
  return arrivals;
}

/// Errors of fixes at one place.
struct Achieved {
  double square_m2 = 0.0, nees = 0.0, heading_rad2 = 0.0;
  int fixes = 0;
};

void compare(Deployment truth, const Scene& scene, const std::vector<PoseAt>& places, bool calibrated, std::uint64_t seed) {
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
  for (std::size_t i = 0; i < places.size(); ++i) heard_paths(model, kernel, tile, places[i], paths[i]);
  calibration.systematic(model, paths, parts);

  std::vector<Achieved> achieved(places.size());
  const Eigen::MatrixXd root = calibrated ? Eigen::MatrixXd(Eigen::LLT<Eigen::MatrixXd>(truth.covariance.matrix).matrixL()) : Eigen::MatrixXd();
  for (int k = 0; k < kDraws; ++k) {
    Deployment believed = truth;
    if (calibrated) {
      Eigen::VectorXd normal(root.cols());
      for (double& v : normal) v = draw.normal();
      believed = with_errors(truth, root * normal);
    }
    LeastSquaresLocalizer localizer(believed, {.rejection_sigmas = 8.0});  // no arrival is at fault here
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Fix fix = localizer.locate(arrivals_at(truth, model, places[i], truth.timing.clock == Clock::kCycleOffset ? draw.uniform(0, 0.05) : 0.0, draw));
      if (!fix.ok()) continue;  // the search found two answers, once in some hundred times with cycle offsets
      ++achieved[i].fixes;
      const Eigen::Vector2d e = fix.T_map_vehicle.translation_m.head<2>() - Eigen::Vector2d(places[i].x_m, places[i].y_m);
      Eigen::Matrix2d C;
      C << std::pow(map.sigma_x_m[i], 2) + parts[i].xx_m2, map.covariance_xy_m2[i] + parts[i].xy_m2, 0, std::pow(map.sigma_y_m[i], 2) + parts[i].yy_m2;
      C(1, 0) = C(0, 1);
      achieved[i].square_m2 += e.squaredNorm();
      achieved[i].nees += e.dot(C.inverse() * e);
      achieved[i].heading_rad2 += std::pow(wrap_angle(fix.T_map_vehicle.heading_rad() - places[i].heading_rad), 2);
    }
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    // NEES of both coordinates over all draws is chi-square; bounds of 1e-4 a side, as there are some dozens of places.
    const int fixes = achieved[i].fixes;
    ASSERT_GT(fixes, 0.98 * kDraws);
    EXPECT_GT(achieved[i].nees, test::chi2_quantile(1e-4, 2 * fixes)) << i << ", seed " << seed;
    EXPECT_LT(achieved[i].nees, test::chi2_quantile(1 - 1e-4, 2 * fixes)) << i << ", seed " << seed;
    const double predicted = std::sqrt(map.sigma_m[i] * map.sigma_m[i] + parts[i].xx_m2 + parts[i].yy_m2);
    EXPECT_NEAR(std::sqrt(achieved[i].square_m2 / fixes) / predicted, 1.0, 0.1) << i << ", seed " << seed;
    if (calibrated) EXPECT_GT(parts[i].xx_m2 + parts[i].yy_m2, 0.2 * map.sigma_m[i] * map.sigma_m[i]) << "the part that is tested counts";
    if (!calibrated && model.unknowns.rotation == 1) {
      const double chi2 = achieved[i].heading_rad2 / std::pow(map.sigma_heading_rad[i], 2);
      EXPECT_GT(chi2, test::chi2_quantile(1e-4, fixes));
      EXPECT_LT(chi2, test::chi2_quantile(1 - 1e-4, fixes));
    }
  }
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

}  // namespace
}  // namespace octant::survey
