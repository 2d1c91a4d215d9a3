// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A calibration with an error of similarity moves every fix by this similarity, for any geometry. Also a
// dense sum for independent errors of beacons.
#include "survey/map/calibration_map.h"
#include "survey/geometry/make_survey_model.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"
#include "tests/survey/brute_force.h"
#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace calibration_map_test {

using test::must;

/// The small hall with an array (x, y, heading), as calibrated and without errors.
Deployment hall(Clock clock = Clock::kSynchronised) {
  const Site site = test::small_site();
  Deployment d;
  d.medium = site.medium;
  d.noise = site.noise;
  d.timing.clock = clock;
  for (const SiteBeacon& b : site.beacons)
    d.beacons.push_back(
        {.name = b.name, .position_m = {*b.position_m[0], *b.position_m[1], *b.position_m[2]}});
  d.vehicles = site.vehicles;
  for (const SiteReceiver& r : site.receivers)
    d.receivers.push_back({.name = r.name, .vehicle = r.vehicle, .position_m = r.position_m, .axis = {}});
  return d;
}

std::vector<HeardPath> all_paths(const SurveyModel& model, const PoseAt& pose) {
  std::vector<HeardPath> paths;
  for (std::size_t b = 0; b < model.beacons.size(); ++b)
    for (std::size_t r = 0; r < model.receivers.size(); ++r) paths.push_back(path_between(model, b, r, pose));
  return paths;
}

Eigen::Matrix2d systematic_at(const Deployment& d, const PoseAt& pose) {
  const SurveyModel model = must(make_survey_model(d, Scene{}));
  const std::vector<std::vector<HeardPath>> paths = {all_paths(model, pose)};
  std::vector<SystematicPart> parts(1);
  CalibrationMap(d, model).systematic(model, paths, parts);
  Eigen::Matrix2d C;
  C << parts[0].xx_m2, parts[0].xy_m2, parts[0].xy_m2, parts[0].yy_m2;
  return C;
}

/// One error for all parameters of a deployment: a column for each independent cause.
struct Causes {
  explicit Causes(const Deployment& d) {
    for (std::size_t b = 0; b < d.beacons.size(); ++b)
      for (std::size_t i = 0; i < 3; ++i) ids.push_back(parameters::beacon_position(b, i));
    for (std::size_t r = 0; r < d.receivers.size(); ++r)
      for (std::size_t i = 0; i < 3; ++i) ids.push_back(parameters::receiver_position(r, i));
    ids.push_back(parameters::site_delay());
    ids.push_back(parameters::speed());
  }
  Eigen::VectorXd& add() {
    columns.emplace_back(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(ids.size())));
    return columns.back();
  }
  void put_into(Deployment& d) const {
    d.covariance.parameters = ids;
    d.covariance.matrix = Eigen::MatrixXd::Zero(columns[0].size(), columns[0].size());
    for (const auto& c : columns) d.covariance.matrix += c * c.transpose();
  }
  std::vector<ParameterId> ids;
  std::vector<Eigen::VectorXd> columns;
};

Eigen::Index beacon_at(std::size_t b) { return static_cast<Eigen::Index>(3 * b); }
Eigen::Index receiver_at(const Deployment& d, std::size_t r) {
  return static_cast<Eigen::Index>(3 * (d.beacons.size() + r));
}

/// Within 1e-8 of the largest: the root of a covariance of rank one is rounded to the root of 1e-16.
void expect_close(const Eigen::Matrix2d& found, const Eigen::Matrix2d& expected, double size_m2) {
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-8 * size_m2) << found << "\nexpected\n" << expected;
}

PoseAt some_pose(Random& draws) {
  return {draws.uniform(1, 11), draws.uniform(1, 7), 0.0, draws.uniform(-3, 3)};
}

TEST(CalibrationMap, NothingUncertainIsExact) {
  const Deployment d = hall();
  const SurveyModel model = must(make_survey_model(d, Scene{}));
  EXPECT_TRUE(CalibrationMap(d, model).exact());
  EXPECT_TRUE(systematic_at(d, {5, 4, 0, 1}).isZero(0.0));
}

TEST(CalibrationMap, BeaconsThatAreAllShiftedShiftTheFix) {
  Random draws(20261125);
  Deployment d = hall();
  Causes causes(d);
  Eigen::Matrix2d shifts;
  shifts << 0.003, 0.001, -0.002, 0.004;  // a column a cause
  for (int k = 0; k < 2; ++k) {
    Eigen::VectorXd& error = causes.add();
    for (std::size_t b = 0; b < d.beacons.size(); ++b) error.segment<2>(beacon_at(b)) = shifts.col(k);
  }
  causes.put_into(d);
  for (int i = 0; i < 20; ++i)
    expect_close(systematic_at(d, some_pose(draws)), shifts * shifts.transpose(), 2e-5);
}

TEST(CalibrationMap, BeaconsThatAreAllTurnedTurnTheFixAboutTheSamePoint) {
  Random draws(2);
  Deployment d = hall();
  Causes causes(d);
  const double angle_rad = 1e-3;
  Eigen::VectorXd& error = causes.add();
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    error.segment<3>(beacon_at(b)) = angle_rad * Eigen::Vector3d::UnitZ().cross(d.beacons[b].position_m);
  causes.put_into(d);
  for (int i = 0; i < 20; ++i) {
    const PoseAt pose = some_pose(draws);
    const Eigen::Vector2d shift = angle_rad * Eigen::Vector2d(-pose.y_m, pose.x_m);
    expect_close(systematic_at(d, pose), shift * shift.transpose(), 1e-4);
  }
}

/// The vehicle's frame turned in itself changes the heading alone.
TEST(CalibrationMap, ReceiversThatAreAllTurnedLeaveTheFix) {
  Random draws(3);
  Deployment d = hall();
  Causes causes(d);
  Eigen::VectorXd& error = causes.add();
  for (std::size_t r = 0; r < d.receivers.size(); ++r)
    error.segment<3>(receiver_at(d, r)) = 0.01 * Eigen::Vector3d::UnitZ().cross(d.receivers[r].position_m);
  causes.put_into(d);
  for (int i = 0; i < 20; ++i)
    expect_close(systematic_at(d, some_pose(draws)), Eigen::Matrix2d::Zero(), 1e-4);
}

TEST(CalibrationMap, ReceiversThatAreAllShiftedShiftTheFixTheOtherWayInTheMap) {
  Random draws(4);
  Deployment d = hall();
  Causes causes(d);
  Eigen::VectorXd& error = causes.add();
  for (std::size_t r = 0; r < d.receivers.size(); ++r)
    error.segment<3>(receiver_at(d, r)) = Eigen::Vector3d(0.004, 0.001, 0);
  causes.put_into(d);
  for (int i = 0; i < 20; ++i) {
    const PoseAt pose = some_pose(draws);
    const Eigen::Vector2d shift = Eigen::Rotation2Dd(pose.heading_rad) * Eigen::Vector2d(-0.004, -0.001);
    expect_close(systematic_at(d, pose), shift * shift.transpose(), 2e-5);
  }
}

/// A site enlarged by a factor, with a speed larger by the same factor: times are equal, and the fix is
/// farther from the origin by that factor.
TEST(CalibrationMap, ScaleAndSpeedGoTogether) {
  Random draws(5);
  Deployment d = hall();
  const double part = 2e-4, receivers_z_m = d.receivers[0].position_m.z();
  Causes causes(d);
  Eigen::VectorXd& error = causes.add();
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    Eigen::Vector3d arm = d.beacons[b].position_m;
    arm.z() -= receivers_z_m;  // the vehicle stays on the floor
    error.segment<3>(beacon_at(b)) = part * arm;
  }
  for (std::size_t r = 0; r < d.receivers.size(); ++r)
    error.segment<2>(receiver_at(d, r)) = part * d.receivers[r].position_m.head<2>();
  error[error.size() - 1] = part * d.speed_mps(d.medium.temperature_degC);
  causes.put_into(d);
  for (int i = 0; i < 20; ++i) {
    const PoseAt pose = some_pose(draws);
    const Eigen::Vector2d shift = part * Eigen::Vector2d(pose.x_m, pose.y_m);
    expect_close(systematic_at(d, pose), shift * shift.transpose(), 1e-5);
  }
}

TEST(CalibrationMap, ACommonDelayIsTheClocksWhereItHasAnOffset) {
  Random draws(6);
  for (const Clock clock : {Clock::kCycleOffset, Clock::kSynchronised}) {
    Deployment d = hall(clock);
    Causes causes(d);
    Eigen::VectorXd& error = causes.add();
    error[error.size() - 2] = 1e-5;  // 3.4 mm
    causes.put_into(d);
    double largest_m2 = 0.0;
    for (int i = 0; i < 20; ++i)
      largest_m2 = std::max(largest_m2, systematic_at(d, some_pose(draws)).cwiseAbs().maxCoeff());
    if (clock == Clock::kCycleOffset)
      EXPECT_LT(largest_m2, 1e-13);
    else
      EXPECT_GT(largest_m2, 1e-7) << "without an offset it moves the fix";
  }
}

/// Without a joint covariance: beacons as if independent of each other.
TEST(CalibrationMap, BeaconsErrorsOfTheirOwnAddUp) {
  Random draws(7);
  Deployment d = hall();
  for (auto& b : d.beacons) {
    Eigen::Matrix3d root;
    for (int k = 0; k < 3; ++k) root.col(k) = 2e-3 * draws.normal3();
    b.covariance_m2 = root * root.transpose();
    b.delay_sigma_s = 5e-6;
  }
  const SurveyModel model = must(make_survey_model(d, Scene{}));
  for (int i = 0; i < 10; ++i) {
    const PoseAt pose = some_pose(draws);
    const auto arrivals = test::brute_arrivals(model, pose.x_m, pose.y_m, pose.z_m, pose.heading_rad);
    const Eigen::MatrixXd C = test::information_of(model, arrivals, true).inverse();
    Eigen::Matrix2d expected = Eigen::Matrix2d::Zero();
    for (std::size_t b = 0; b < d.beacons.size(); ++b) {
      Eigen::MatrixXd by_place = Eigen::MatrixXd::Zero(3, 3);
      Eigen::VectorXd by_delay = Eigen::VectorXd::Zero(3);
      for (const auto& a : arrivals) {
        if (a.beacon != b) continue;
        // The z of the unit is not among the unknowns: from its length.
        Eigen::Vector3d unit(a.row[0], a.row[1], 0);
        unit.z() = (0.3 - d.beacons[b].position_m.z()) / a.distance_m;
        const Eigen::VectorXd moved = C * a.row / (a.sigma_m * a.sigma_m);
        by_place += moved * unit.transpose();
        by_delay += moved * model.speed_mps;
      }
      const Eigen::MatrixXd one = by_place * d.beacons[b].covariance_m2 * by_place.transpose() +
                                  by_delay * by_delay.transpose() * 25e-12;
      expected += one.topLeftCorner<2, 2>();
    }
    expect_close(systematic_at(d, pose), expected, expected.trace());
  }
}

TEST(CalibrationMap, WithoutAFixThereIsNoPart) {
  Deployment d = hall();
  for (auto& b : d.beacons) b.covariance_m2 = 1e-6 * Eigen::Matrix3d::Identity();
  const SurveyModel model = must(make_survey_model(d, Scene{}));
  const std::vector<HeardPath> one = {path_between(model, 0, 0, {5, 4, 0, 0})};
  const std::vector<std::vector<HeardPath>> paths = {{}, one, all_paths(model, {5, 4, 0, 0})};
  std::vector<SystematicPart> parts(3, {1, 1, 1});
  CalibrationMap(d, model).systematic(model, paths, parts);
  for (const std::size_t i : {0U, 1U}) EXPECT_EQ(parts[i].xx_m2 + parts[i].xy_m2 + parts[i].yy_m2, 0.0) << i;
  EXPECT_GT(parts[2].xx_m2, 0.0);
}

}  // namespace calibration_map_test
}  // namespace octant::survey
