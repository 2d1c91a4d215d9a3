// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Paths in space among level beacons that are known to some decimetres, against the truth.
#include "models/localizers/start/rough_path.h"

#include <gtest/gtest.h>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/start/space_follow.h"
#include "models/simulator/random.h"
#include "models/trajectory/make_trajectory.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace rough_path_test {

constexpr double kSlack_m = 0.3;

struct Flight {
  World world;
  Deployment said;  ///< beacons as people have them
  Trajectory trajectory;
};

Flight flight(std::uint64_t seed, double echoes = 0.0) {
  Scenario s = drive_scenario(150.0);
  s.odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.02, .heading_sigma_rad_per_sqrt_m = 0.02};
  s.site.motion = Motion::kSpatial;
  s.log_odometry = true;
  s.echo_fraction = echoes;
  Flight f{must(simulate(s, seed)), {}, {}};
  f.said = f.world.truth;
  Random random(seed, 7);
  for (DeploymentBeacon& b : f.said.beacons) b.position_m += kSlack_m * random.normal3();
  f.trajectory = make_trajectory(f.world.run, 0, VehicleId(0), trajectory_model(f.said));
  return f;
}

/// Largest distances from the truth.
struct Largest {
  double plane_m = 0.0, attitude_rad = 0.0;
  double highest_m = -INFINITY;
};

Largest largest_off(const Trajectory& t, const std::vector<TimedPose>& truth) {
  Largest off;
  for (const Node& node : t.nodes) {
    Pose T;
    if (!interpolate_poses(truth, node.time_s, 1.0, T)) continue;
    EXPECT_TRUE(node.placed);
    off.plane_m =
        std::max(off.plane_m, (node.T_map_vehicle.translation_m - T.translation_m).head<2>().norm());
    off.attitude_rad = std::max(off.attitude_rad, node.T_map_vehicle.rotation.angularDistance(T.rotation));
    off.highest_m = std::max(off.highest_m, node.T_map_vehicle.translation_m.z());
  }
  return off;
}

void expect_placed(std::uint64_t seed, double echoes) {
  Flight f = flight(seed, echoes);
  const EpochFixModel model = epoch_fix_model(f.said);
  ASSERT_EQ(f.trajectory.segments.size(), 1U);
  ASSERT_TRUE(place_roughly(f.trajectory, f.trajectory.segments[0], model,
                            TrackerOptions{.range_uncertainty_m = kSlack_m}));
  // Heights among level beacons are weakly observable: of them only the side of the beacons' plane.
  const Largest off = largest_off(f.trajectory, f.world.run.truth);
  EXPECT_LT(off.plane_m, 0.7) << "seed " << seed;
  EXPECT_LT(off.attitude_rad, 0.3) << "seed " << seed << ": a tilted image is beyond it";
  EXPECT_LT(off.highest_m, 2.2) << "seed " << seed << ": the receivers would be among the beacons";
}

TEST(RoughPath, IsNoTiltedImageOfItself) {
  for (const std::uint64_t seed : {1, 3, 4, 5, 6, 8}) expect_placed(seed, 0.0);
}

// In the last one, the first window's likeliest pose is not the right one.
TEST(RoughPath, NorAmongEchoes) {
  for (const std::uint64_t seed : {1, 2, 3, 19}) expect_placed(seed, 0.05);
}

TEST(RoughPath, HasNoKinksBetweenItsPieces) {
  Flight f = flight(1);
  const EpochFixModel model = epoch_fix_model(f.said);
  ASSERT_TRUE(place_roughly(f.trajectory, f.trajectory.segments[0], model,
                            TrackerOptions{.range_uncertainty_m = kSlack_m}));
  const Trajectory& t = f.trajectory;
  for (const OdometryObservation& o : t.odometry) {
    const Pose step = t.nodes[o.node].T_map_vehicle.inverse() * t.nodes[o.node + 1].T_map_vehicle;
    EXPECT_LT((step.translation_m - o.T_before_after.translation_m).norm(), 5 * o.distance_sigma_m);
    EXPECT_LT(step.rotation.angularDistance(o.T_before_after.rotation), 5 * o.heading_sigma_rad);
  }
  EXPECT_TRUE(t.poses.empty()) << "what held them is gone";
}

TEST(RoughPath, NothingHeardIsNoPath) {
  Flight f = flight(1);
  Segment unheard = f.trajectory.segments[0];
  unheard.last_arrival = unheard.first_arrival;
  EXPECT_FALSE(place_roughly(f.trajectory, unheard, epoch_fix_model(f.said),
                             TrackerOptions{.range_uncertainty_m = kSlack_m}));
}

/// Two poses at the ends and the odometry between them share their disagreement according to their variances.
TEST(JoinPieces, SharesADisagreementByVariances) {
  constexpr double kStep_m = 5e-3, kOff_m = 0.2;
  Flight f = flight(1);
  Trajectory& t = f.trajectory;
  const Segment& s = t.segments[0];
  for (OdometryObservation& o : t.odometry) {
    o.T_before_after = {{0.01, 0, 0},
                        Eigen::Quaterniond::Identity()};  // straight on: no turn takes any of it
    o.distance_sigma_m = kStep_m;
    o.heading_sigma_rad = 1e-3;
  }
  for (std::size_t k = 0; k < t.nodes.size(); ++k) {
    t.nodes[k].placed = true;
    t.nodes[k].T_map_vehicle = {{0.01 * static_cast<double>(k), 3.0, 1.0}, Eigen::Quaterniond::Identity()};
  }
  const Pose before = t.nodes.back().T_map_vehicle;
  std::vector<PoseObservation> pieces = {rough_pose(t, s.last_node - 1, kSlack_m),
                                         rough_pose(t, s.first_node, kSlack_m)};
  const Eigen::Vector3d along = Eigen::Vector3d::UnitX();
  pieces[0].T_map_vehicle.translation_m += kOff_m * along;
  join_pieces(t, s, epoch_fix_model(f.said).state, pieces, 1);
  const double of_pose = kSlack_m * kSlack_m,
               of_odometry = kStep_m * kStep_m * static_cast<double>(t.odometry.size());
  const double moved_m = kOff_m * (of_pose + of_odometry) / (2 * of_pose + of_odometry);
  EXPECT_LT((t.nodes.back().T_map_vehicle.translation_m - before.translation_m - moved_m * along).norm(),
            0.01 * moved_m);
  EXPECT_TRUE(t.poses.empty());
}

}  // namespace rough_path_test
}  // namespace octant::test
