// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/linear_ranges.h"

#include <gtest/gtest.h>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/make_trajectory.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {
namespace linear_ranges_test {

Trajectory stop_of(const Deployment& d, const std::vector<Arrival>& arrivals) {
  MeasurementLog log;
  log.arrivals = arrivals;
  log.has_epochs = true;
  return make_trajectory(log, 0, VehicleId(0), trajectory_model(d));
}

TEST(LinearRanges, FindTheStopOfAnArray) {
  const Deployment d = with_octagon(hall());
  const EpochFixModel model = epoch_fix_model(d);
  std::mt19937_64 random(51);
  int placed = 0;
  for (int k = 0; k < 50; ++k) {
    const Pose truth = random_pose(random);
    Trajectory t = stop_of(d, hear(d, truth, {.noise_s = 0.0}, random));
    if (!place_by_linear_ranges(t, t.segments.front(), model.state, model.beacon_usable)) continue;
    ++placed;
    const Pose& found = t.nodes.front().T_map_vehicle;
    EXPECT_TRUE(t.nodes.front().placed);
    // Means over receivers 0.1 m apart replace the ranges of the centre, then one linear correction.
    EXPECT_LT((found.translation_m - truth.translation_m).norm(), 0.03);
    EXPECT_LT(std::abs(wrap_angle(found.heading_rad() - truth.heading_rad())), 0.1);
  }
  EXPECT_GT(placed, 45);
}

// With a receiver at the origin of the vehicle the equations hold exactly.
TEST(LinearRanges, AreExactForOneReceiverWithoutNoise) {
  const Deployment d = with_receiver(hall(), {0, 0, 0.3});
  const EpochFixModel model = epoch_fix_model(d);
  std::mt19937_64 random(52);
  for (int k = 0; k < 20; ++k) {
    const Pose truth = random_pose(random);
    Trajectory t = stop_of(d, hear(d, truth, {.range_m = 50.0}, random));
    ASSERT_TRUE(place_by_linear_ranges(t, t.segments.front(), model.state, model.beacon_usable));
    EXPECT_LT((t.nodes.front().T_map_vehicle.translation_m - truth.translation_m).norm(), 1e-6);
  }
}

TEST(LinearRanges, SayNothingOfBeaconsInLineOrTooFew) {
  Deployment line = with_receiver(hall(4), {0, 0, 0.3});
  for (std::size_t b = 0; b < 4; ++b)
    line.beacons[b].position_m = {1.0 + 4.0 * static_cast<double>(b), 2.0, 2.5};
  std::mt19937_64 random(53);
  const Pose truth = Pose::planar(5, 7, 0.4);
  const std::vector<Arrival> heard = hear(line, truth, {.range_m = 50.0}, random);
  Trajectory t = stop_of(line, heard);
  const EpochFixModel model = epoch_fix_model(line);
  EXPECT_FALSE(place_by_linear_ranges(t, t.segments.front(), model.state, model.beacon_usable));
  EXPECT_FALSE(t.nodes.front().placed);
  const Deployment d = with_receiver(hall(), {0, 0, 0.3});
  Trajectory two = stop_of(d, {heard[0], heard[1]});
  EXPECT_FALSE(place_by_linear_ranges(two, two.segments.front(), epoch_fix_model(d).state,
                                      std::vector<bool>(8, true)));
}

TEST(LinearRanges, DetoursAreLongerThanTheOtherReceiverAllows) {
  Deployment d = with_receiver(with_receiver(hall(), {0.1, 0, 0.3}), {-0.1, 0, 0.3});
  const EpochFixModel model = epoch_fix_model(d);
  std::mt19937_64 random(54);
  std::vector<Arrival> arrivals = hear(d, Pose::planar(8, 5, 0.2), {.range_m = 50.0}, random);
  ASSERT_EQ(arrivals[4].beacon, arrivals[5].beacon);
  {
    Trajectory t = stop_of(d, arrivals);
    EXPECT_FALSE(reject_detours(t, t.segments.front(), model.state, 4.0));
  }
  // 0.2 m apart, so 0.25 m more are too much (four sigmas of 1e-5 s each are 19 mm); a single one cannot be
  // tested.
  arrivals[4].tof_s += 0.45 / 343.7;
  arrivals[6].tof_s += 0.1 / 343.7;
  Trajectory t = stop_of(d, arrivals);
  EXPECT_TRUE(reject_detours(t, t.segments.front(), model.state, 4.0));
  for (std::size_t i = 0; i < t.arrivals.size(); ++i)
    EXPECT_EQ(t.arrivals[i].rejection, i == 4 ? Rejection::kTriangle : Rejection::kUsed) << i;
}

}  // namespace linear_ranges_test
}  // namespace octant::test
