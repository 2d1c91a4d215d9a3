// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/search_problem.h"

#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/start/rigid_path.h"
#include "tests/models/localizers/exact_drive.h"

namespace octant::test {
namespace search_problem_test {

const Pose kTruth = Pose::planar(7.0, 5.0, 0.6);

struct Stop {
  Deployment d;
  EpochFixModel model;
  Trajectory t;

  explicit Stop(Deployment deployment) : d(std::move(deployment)), model(epoch_fix_model(d)) {
    std::mt19937_64 random(5);
    set_epoch(t, hear(d, kTruth, {}, random), {}, trajectory_model(d));
  }
  [[nodiscard]] SearchProblem problem(double uncertainty_m = 0.0) const {
    return make_search_problem(t, t.segments[0], model, uncertainty_m);
  }
};

TEST(SearchProblem, RangesReachFromTheTrueLeversToTheBeacons) {
  const Stop stop(with_octagon(hall()));
  const SearchProblem problem = stop.problem();
  ASSERT_EQ(problem.ranges.size(), stop.t.arrivals.size());
  for (const SearchRange& r : problem.ranges) {
    EXPECT_NEAR((kTruth * r.p_lever_m - r.p_beacon_map_m).norm(), r.range_m, 1e-9);
    EXPECT_NEAR(r.sigma_m, 1e-5 * 343.7, 1e-12);
    const ArrivalObservation& a = stop.t.arrivals[r.observation];
    EXPECT_EQ(r.beacon, a.beacon);
    const Eigen::Vector2d axis = stop.d.receivers[a.receiver.index()].axis->head<2>().normalized();
    EXPECT_LT((r.axis - axis).norm(), 1e-12);
  }
  EXPECT_TRUE(problem.sees_heading());
  EXPECT_FALSE(problem.has_offset);
  EXPECT_NEAR(problem.speed_mps, 343.7, 1e-12);
}

TEST(SearchProblem, GroupsAreTheArrivalsOfABeacon) {
  const Stop stop(with_octagon(hall()));
  const SearchProblem problem = stop.problem(0.2);
  std::set<BeaconId> seen;
  std::size_t longest = 0;
  for (std::size_t g = 0; g < problem.groups(); ++g) {
    EXPECT_EQ(problem.group_bias_m[g], 0.2);
    EXPECT_TRUE(seen.insert(problem.ranges[problem.group_first[g]].beacon).second);
    for (std::size_t i = problem.group_first[g]; i < problem.group_first[g + 1]; ++i) {
      EXPECT_EQ(problem.ranges[i].beacon, problem.ranges[problem.group_first[g]].beacon);
      if (problem.ranges[i].range_m > problem.ranges[longest].range_m) longest = i;
    }
  }
  EXPECT_EQ(problem.group_first.back(), problem.ranges.size());
  EXPECT_EQ(problem.span_m, problem.ranges[longest].range_m);
}

TEST(SearchProblem, LeavesOutUnusableBeaconsAndTimesThatAreNoDistance) {
  Stop stop(with_octagon(hall()));
  const std::size_t all = stop.problem().ranges.size();
  std::size_t of_first = 0;
  for (const ArrivalObservation& a : stop.t.arrivals) of_first += a.beacon == stop.t.arrivals[0].beacon;
  stop.model.beacon_usable[stop.t.arrivals[0].beacon.index()] = false;
  EXPECT_EQ(stop.problem().ranges.size(), all - of_first);
  stop.t.arrivals.back().tof_s = -1.0;
  EXPECT_EQ(stop.problem().ranges.size(), all - of_first - 1);
  stop.t.has_cycle_offset = true;  // then a negative one may be
  EXPECT_EQ(stop.problem().ranges.size(), all - of_first);
}

TEST(SearchProblem, OfNothingIsEmpty) {
  Stop stop(with_octagon(hall()));
  stop.model.beacon_usable.assign(8, false);
  const SearchProblem problem = stop.problem();
  EXPECT_EQ(problem.groups(), 0U);
  EXPECT_TRUE(problem.ranges.empty());
  EXPECT_FALSE(problem.sees_heading());
}

TEST(SearchProblem, AReceiverOnTheAxisSeesNoHeading) {
  Stop stop(with_receiver(hall(), {0.0, 0.0, 0.4}));
  EXPECT_FALSE(stop.problem().sees_heading());
  stop.t.bearings.push_back({0, 0.0, 0, BeaconId(2), 0.3, 0.01, Rejection::kUsed});
  stop.t.segments[0].last_bearing = 1;
  EXPECT_TRUE(stop.problem().sees_heading()) << "a bearing tells it";
  stop.t.bearings[0].reflector = BeaconId();
  EXPECT_FALSE(stop.problem().sees_heading()) << "not one of nobody";
}

// The uncertainty of a beacon's position and delay, and of the speed, affects all its ranges together.
TEST(SearchProblem, CalibrationCountsAsABiasOfTheGroup) {
  Stop stop(with_octagon(hall()));
  stop.model.beacon_covariance.assign(8, Eigen::Matrix<double, 5, 5>::Zero());
  for (auto& C : stop.model.beacon_covariance) C.diagonal() << 3e-4, 3e-4, 3e-4, 1e-10, 0.04;
  const SearchProblem problem = stop.problem(0.1);
  const double c = stop.model.nominal_speed_mps;
  for (std::size_t g = 0; g < problem.groups(); ++g) {
    const double range_m = problem.ranges[problem.group_first[g]].range_m;
    const double want2 = 0.01 + 3e-4 + c * c * 1e-10 + range_m * range_m / (c * c) * 0.04;
    EXPECT_NEAR(problem.group_bias_m[g], std::sqrt(want2), 1e-12);
  }
}

TEST(SearchProblem, OfADriveIsThatOfItsAnchor) {
  const ExactDrive drive;
  const RigidPath path = rigid_path(drive.t, drive.t.segments[0], 5);
  const SearchProblem problem = make_search_problem(drive.t, drive.t.segments[0], drive.model, 0.0, path);
  EXPECT_FALSE(problem.common_bias);
  ASSERT_EQ(problem.ranges.size(), 11U);
  for (const SearchRange& r : problem.ranges) {
    EXPECT_NEAR((drive.truth[5] * r.p_lever_m - r.p_beacon_map_m).norm(), r.range_m, 1e-9);
    EXPECT_NEAR(r.sigma_m, std::hypot(3.437e-3, path.drift_m[drive.t.arrivals[r.observation].node]), 1e-9);
  }
}

}  // namespace search_problem_test
}  // namespace octant::test
