// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/paths.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "models/simulator/random.h"
#include "survey/geometry/map_tiles.h"
#include "tests/support/numeric.h"
#include "tests/survey/brute_force.h"

namespace octant::survey {
namespace paths_test {

Eigen::Vector3d some_place(Random& draws, double size_m) {
  const Eigen::Vector3d p = size_m * draws.normal3();
  return p;
}

SurveyModel some_model(Random& draws, Motion motion, Clock clock, bool array) {
  SurveyModel model;
  model.motion = motion, model.clock = clock;
  for (int r = 0; r < (array ? 4 : 1); ++r) model.receivers.push_back({"r", some_place(draws, 0.3)});
  model.unknowns = unknowns_of(motion, clock, model.receivers);
  for (int b = 0; b < 5; ++b) model.beacons.push_back({"B", some_place(draws, 10)});
  model.noise = {0.01, 0.002, 0.003};
  return model;
}

/// The range by the definition of the unknowns: the vehicle moves in the map, turns about its own axes, and
/// the clock's offset in metres is added.
double range_after(const SurveyModel& model, std::size_t b, std::size_t r, const PoseAt& pose,
                   const Eigen::VectorXd& change) {
  const Unknowns& u = model.unknowns;
  Eigen::Vector3d p(pose.x_m, pose.y_m, pose.z_m);
  p.head(u.position) += change.head(u.position);
  Eigen::Matrix3d R = Eigen::AngleAxisd(pose.heading_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  if (u.rotation == 1) turn.z() = change[u.position];
  if (u.rotation == 3) turn = change.segment<3>(u.position);
  if (turn.norm() > 0) R = R * Eigen::AngleAxisd(turn.norm(), turn.normalized());
  const double offset_m = u.clock ? change[u.count() - 1] : 0.0;
  return (p + R * model.receivers[r].p_vehicle_m - model.beacons[b].p_map_m).norm() + offset_m;
}

TEST(Paths, RowsAreTheDerivativesOfTheRange) {
  Random draws(20261125);
  for (const Motion motion : {Motion::kPlanar, Motion::kSpatial})
    for (const Clock clock : {Clock::kSynchronised, Clock::kCycleOffset})
      for (const bool array : {false, true})
        for (int trial = 0; trial < 20; ++trial) {
          const SurveyModel model = some_model(draws, motion, clock, array);
          const PoseAt pose{draws.normal(), draws.normal(), draws.normal(), draws.uniform(-3, 3)};
          const std::size_t r = model.receivers.size() - 1;
          const HeardPath path = path_between(model, 2, r, pose);
          const auto range = [&](const Eigen::VectorXd& change) {
            return Eigen::VectorXd::Constant(1, range_after(model, 2, r, pose, change));
          };
          const Eigen::VectorXd none = Eigen::VectorXd::Zero(model.unknowns.count());
          const Eigen::MatrixXd J = test::numeric_jacobian(range, none);
          ASSERT_EQ(path.row.size(), model.unknowns.count());
          // Central differences of 1 um in ranges of some ten metres: rounding of 2e-15 / 1e-6.
          EXPECT_LT((path.row.transpose() - J).cwiseAbs().maxCoeff(), 1e-8);
          EXPECT_NEAR(path.distance_m, range_after(model, 2, r, pose, none), 1e-12);
          EXPECT_DOUBLE_EQ(path.weight, 1 / model.noise.variance_m2(path.distance_m));
        }
}

TEST(Paths, TheUnitPointsFromTheBeaconToTheReceiver) {
  SurveyModel model;
  model.receivers = {{"r0", {1, 0, 0.5}}};
  model.beacons = {{"B0", {10, 5, 2.5}}};
  model.noise.constant_m = 0.01;
  const HeardPath path = path_between(model, 0, 0, {4, 5, 0, M_PI / 2});
  const Eigen::Vector3d receiver(4, 6, 0.5), way = receiver - model.beacons[0].p_map_m;
  EXPECT_LT((path.unit - way.normalized()).norm(), 1e-15);
  EXPECT_LT((path.unit * path.distance_m - way).norm(), 1e-14);
}

TEST(Paths, ABeaconAtTheReceiverHasNoDirectionAndNoNan) {
  SurveyModel model;
  model.receivers = {{"r0", Eigen::Vector3d::Zero()}};
  model.beacons = {{"B0", {1, 2, 3}}};
  model.noise.constant_m = 0.01;
  const HeardPath path = path_between(model, 0, 0, {1, 2, 3, 0});
  EXPECT_TRUE(path.row.allFinite());
  EXPECT_TRUE(std::isfinite(path.weight));
  EXPECT_LE(path.distance_m, 1e-6);
}

/// A hall with walls, patterns and a threshold, so that something is unheard for each reason.
SurveyModel hall_model(Random& draws) {
  SurveyModel model = some_model(draws, Motion::kPlanar, Clock::kCycleOffset, true);
  BeamPattern cone, power;
  cone.half_angle_rad = 1.0;
  power.kind = BeamPattern::Kind::kCosinePower, power.half_angle_rad = 1.3;
  model.patterns = {cone, power};
  for (std::size_t b = 0; b < model.beacons.size(); ++b) {
    SurveyBeacon& beacon = model.beacons[b];
    beacon.p_map_m = {draws.uniform(0, 20), draws.uniform(0, 15), draws.uniform(2, 4)};
    if (b < 3) beacon.axis = draws.normal3().normalized(), beacon.pattern = b % 2;
  }
  for (SurveyReceiver& r : model.receivers) {
    r.p_vehicle_m.z() = 0.3;
    r.axis = Eigen::Vector3d(draws.normal(), draws.normal(), 0.5).normalized();
    r.pattern = 0;
  }
  for (int w = 0; w < 5; ++w)
    model.walls.push_back({{draws.uniform(0, 20), draws.uniform(0, 15)},
                           {draws.uniform(0, 20), draws.uniform(0, 15)},
                           0.0,
                           draws.uniform(1, 4)});
  model.hearing = {.amplitude_1m_v = 2.0, .threshold_v = 0.1, .absorption_np_per_m = 0.05, .range_m = 11.0};
  return model;
}

TEST(Paths, AreThoseThatAreHeardOneByOne) {
  Random draws(11);
  std::size_t heard = 0, possible = 0;
  for (int world = 0; world < 40; ++world) {
    const SurveyModel model = hall_model(draws);
    const KernelModel kernel = kernel_model(model, model.beacons);
    PoseList poses;
    for (int i = 0; i < 6; ++i)
      poses.add(draws.uniform(0, 20), draws.uniform(0, 15), 0, draws.uniform(-3, 3));
    auto tile = std::make_unique<KernelTile>();
    fill_tile(kernel, model.walls, poses, 0, poses.size(), *tile);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const PoseAt pose{poses.x_m[i], poses.y_m[i], poses.z_m[i], poses.heading_rad[i]};
      std::vector<HeardPath> paths(3);  // what they held is forgotten
      heard_paths(model, *tile, pose, paths);
      const auto expected = test::brute_arrivals(model, pose.x_m, pose.y_m, pose.z_m, pose.heading_rad);
      ASSERT_EQ(paths.size(), expected.size()) << world << " " << i;
      for (std::size_t k = 0; k < paths.size(); ++k) {
        EXPECT_EQ(paths[k].beacon, expected[k].beacon);
        EXPECT_NEAR(paths[k].distance_m, expected[k].distance_m, 1e-12);
        EXPECT_LT((paths[k].row - expected[k].row).norm(), 1e-12);
        EXPECT_NEAR(paths[k].weight * expected[k].sigma_m * expected[k].sigma_m, 1.0, 1e-12);
      }
      heard += paths.size(), possible += model.beacons.size() * model.receivers.size();
    }
  }
  EXPECT_GT(heard, 200U);
  EXPECT_GT(possible, 4 * heard);
}

}  // namespace paths_test
}  // namespace octant::survey
