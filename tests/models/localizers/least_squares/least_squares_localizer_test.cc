// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The localizer of single poses: its memory, and large numbers of rows.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/models/localizers/hall.h"
#include "tests/support/allocation_count.h"

namespace octant {
namespace least_squares_localizer_test {

using test::hall;
using test::hear;
using test::Hearing;
using test::position_error_m;
using test::random_pose;
using test::with_octagon;
using test::with_receiver;

constexpr std::uint64_t kSeed = 20260;

/// Fixes of a second epoch with the same number of rows allocate no memory.
void expect_no_allocation(Deployment d, const Hearing& how, const std::vector<Bearing>& bearings,
                          std::mt19937_64& random, bool spatial) {
  LeastSquaresLocalizer localizer(d);
  const auto pose = [&] {
    if (!spatial) return random_pose(random);
    return Pose{Eigen::Vector3d(9, 5, 0.8),
                Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()))};
  };
  std::vector<std::vector<Arrival>> epochs;
  for (int k = 0; k < 5; ++k) epochs.push_back(hear(d, pose(), how, random));
  Fix fix;
  fix.rejections.reserve(4 * d.beacons.size() * d.receivers.size());
  const std::size_t before = test::allocations();
  int ok = 0;
  for (const auto& arrivals : epochs) {
    localizer.locate(Observations{arrivals, bearings}, fix);
    ok += fix.ok();
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GE(ok, 1);
}

TEST(LeastSquaresLocalizer, AllocatesNothing) {
  std::mt19937_64 random(kSeed);
  Deployment d = with_octagon(hall());
  // Uncertainty of the calibration, so that its part of the covariance is computed too.
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    for (std::size_t i = 0; i < 2; ++i) d.covariance.parameters.push_back(parameters::beacon_position(b, i));
    d.covariance.parameters.push_back(parameters::beacon_delay(b));
  }
  d.covariance.parameters.push_back(parameters::speed());
  d.covariance.matrix = 1e-8 * Eigen::MatrixXd::Identity(25, 25);
  expect_no_allocation(d,
                       {
                           .noise_s = 1e-5,
                       },
                       {}, random, false);
  Deployment offset = d;
  offset.timing.clock = Clock::kCycleOffset;
  expect_no_allocation(offset, {.noise_s = 1e-5}, {}, random, false);
  Deployment spatial = with_receiver(d, {0.2, 0.1, 0.6});
  spatial.motion = Motion::kSpatial;
  expect_no_allocation(spatial, {.noise_s = 1e-5}, {}, random, true);
  Deployment sees = d;
  sees.noise.bearing_sigma_rad = 0.01;
  const Pose truth = random_pose(random);
  std::vector<Bearing> bearings;
  for (std::size_t i = 0; i < d.beacons.size(); ++i) {
    const Eigen::Vector3d p = truth.inverse() * d.beacons[i].position_m;
    bearings.push_back({.bearing_rad = std::atan2(p.y(), p.x()),
                        .reflector = BeaconId(i),
                        .vehicle = VehicleId(0),
                        .epoch = 3});
  }
  LeastSquaresLocalizer localizer(sees);
  Fix fix;
  const std::size_t before = test::allocations();
  localizer.locate(Observations{{}, bearings}, fix);
  EXPECT_EQ(test::allocations(), before);
  ASSERT_TRUE(fix.ok()) << to_string(fix.status);
  EXPECT_LT(position_error_m(fix.T_map_vehicle, truth), 1e-6);  // by bearings alone
}

/// Memory that a fix needs beyond its scratch comes from the heap: it is slower, not worse.
TEST(LeastSquaresLocalizer, ManyRowsAreNoFault) {
  std::mt19937_64 random(kSeed);
  const Deployment d = with_octagon(hall(40));
  const Pose truth = random_pose(random);
  std::vector<Arrival> arrivals;
  for (int ping = 0; ping < 20; ++ping)
    for (const Arrival& a : hear(d, truth, {.noise_s = 1e-5}, random)) arrivals.push_back(a);
  LeastSquaresLocalizer localizer(d);
  const Fix fix = localizer.locate(arrivals);
  ASSERT_TRUE(fix.ok());
  EXPECT_LT(position_error_m(fix.T_map_vehicle, truth), 1e-3);
}

// Gauss-Newton steps overshoot where residuals are large beside the distances, as by WiFi in a room.
TEST(LeastSquaresLocalizer, ConvergesWithResidualsAsLargeAsTheDistances) {
  Deployment d = with_receiver(hall(6), {0.0, 0.0, 0.0});
  constexpr double kSigma_s = 2.5 / 343.7;
  d.noise.tof_sigma_s = kSigma_s;
  LeastSquaresLocalizer localizer(d);
  std::mt19937_64 random(kSeed);
  int not_converged = 0;
  for (int epoch = 0; epoch < 1000; ++epoch) {
    const auto arrivals = hear(d, random_pose(random), {.range_m = 30.0, .noise_s = kSigma_s}, random);
    Fix fix;
    localizer.locate({arrivals, {}}, fix);
    not_converged += fix.status == FixStatus::kNotConverged;
  }
  EXPECT_LE(not_converged, 2);
}

}  // namespace least_squares_localizer_test
}  // namespace octant
