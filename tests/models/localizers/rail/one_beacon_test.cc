// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/rail/one_beacon.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/localizers/ranging_support.h"
#include "tests/support/allocation_count.h"
#include "tests/support/statistics.h"

namespace octant {
namespace one_beacon_test {

using Point = Eigen::Vector2d;

constexpr std::uint64_t kSeed = 288;
/// Rounding of ranges of some metres, 1e-15, magnified by distance over baseline (30) and by the flattest
/// position (10).
constexpr double kExact_m = 1e-9;

/// Receivers 0.4 m apart along x at uneven heights; beacons on both sides.
Deployment site(const std::vector<Eigen::Vector3d>& beacons) {
  return test::ranging_site(beacons, {{-0.2, 0.03, 0.5}, {0.2, 0.03, 0.6}});
}

std::vector<Arrival> arrivals_at(const Deployment& d, const Pose& truth, double noise_s = 0.0,
                                 std::uint64_t seed = kSeed) {
  std::mt19937_64 random(seed);
  return test::hear(d, truth, {.range_m = 100.0, .noise_s = noise_s}, random, 4, 1.0);
}

Fix locate(OneBeacon& localizer, const std::vector<Arrival>& arrivals) {
  const Fix fix = localizer.locate({.arrivals = arrivals, .bearings = {}});
  EXPECT_TRUE(test::has_no_nan(fix));
  return fix;
}

Fix locate(const Deployment& d, const std::vector<Arrival>& arrivals, OneBeaconOptions options = {}) {
  OneBeacon localizer(d, options);
  return locate(localizer, arrivals);
}

void expect_pose(const Fix& fix, const Pose& truth) {
  ASSERT_TRUE(fix.ok()) << to_string(fix.status);
  EXPECT_LT((fix.T_map_vehicle.translation_m - truth.translation_m).norm(), kExact_m);
  EXPECT_LT(std::abs(wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad())), kExact_m);
}

bool on_the_left(const Pose& truth, const Eigen::Vector3d& beacon) {
  return (truth.inverse() * beacon).y() > 0.5;
}

TEST(BeaconInRobotFrame, SolvesEquation4) {
  for (double x = -6; x < 6; x += 0.37) {
    for (double y = 0.4; y < 8; y += 0.31) {
      for (const double sign : {1.0, -1.0}) {
        const Point p(x, sign * y);
        const auto found =
            beacon_in_robot_frame(0.2, (p - Point(-0.2, 0)).norm(), (p - Point(0.2, 0)).norm(), sign > 0);
        ASSERT_TRUE(found);
        // Rounding times distance over baseline, and over the height where it is small.
        EXPECT_LT((*found - p).norm(), 1e-11);
      }
    }
  }
}

TEST(BeaconInRobotFrame, CirclesThatDoNotMeetGiveNothing) {
  EXPECT_FALSE(beacon_in_robot_frame(0.2, 3.0, 3.5));
  EXPECT_FALSE(beacon_in_robot_frame(0.2, 0.1, 0.2));
  EXPECT_FALSE(beacon_in_robot_frame(0.0, 3.0, 3.0));
  EXPECT_FALSE(beacon_in_robot_frame(0.2, std::nan(""), 3.0));
}

TEST(RobotInMap, TurnsAndShifts) {
  const Pose truth = Pose::planar(3, 4, 0.7);
  const Eigen::Vector3d beacon(1, 6, 0);
  const Point in_robot = (truth.inverse() * beacon).head<2>();
  EXPECT_LT((robot_in_map(in_robot, beacon.head<2>(), 0.7) - Point(3, 4)).norm(), 1e-14);
}

TEST(OneBeacon, IsExactWithKnownHeading) {
  const Deployment d = site({{0.3, -0.2, 2.0}});
  for (double x = -6; x < 6.1; x += 1.1) {
    for (double y = -6; y < 6.1; y += 1.3) {
      for (int k = 0; k < 8; ++k) {
        const Pose truth = Pose::planar(x, y, wrap_angle(0.2 + k * M_PI / 4));
        const double side_m = (truth.inverse() * d.beacons[0].position_m).y();
        if (std::abs(side_m) < 0.5) continue;  // in line with the receivers nothing is left of the height
        const Fix fix = locate(d, arrivals_at(d, truth),
                               {.heading_rad = truth.heading_rad(),
                                .facing = side_m > 0 ? Facing::kLeft : Facing::kRight,
                                .max_sigma_m = 100.0});
        expect_pose(fix, truth);
        EXPECT_EQ(fix.arrivals_used, 2);
        EXPECT_EQ(fix.epoch, 4);
      }
    }
  }
}

TEST(OneBeacon, TwoBeaconsTellTheHeading) {
  const Deployment d = site({{0, 5, 2.0}, {6, 5.5, 1.8}});
  for (double x = -1; x < 7; x += 1.1) {
    for (double y = 0; y < 4; y += 0.7) {
      for (int k = 0; k < 12; ++k) {
        const Pose truth = Pose::planar(x, y, wrap_angle(k * M_PI / 6));
        if (!on_the_left(truth, d.beacons[0].position_m) || !on_the_left(truth, d.beacons[1].position_m))
          continue;
        expect_pose(locate(d, arrivals_at(d, truth)), truth);
      }
    }
  }
}

TEST(OneBeacon, EitherSideIsToldByTheBeaconsAmongThemselves) {
  const Deployment d = site({{0, 5, 2.0}, {6, 5.5, 1.8}, {2, -4, 2.2}});
  int ambiguous = 0, tried = 0;
  for (int k = 0; k < 24; ++k) {
    const Pose truth = Pose::planar(2.3, 0.4, wrap_angle(0.1 + k * M_PI / 12));
    const Fix fix = locate(d, arrivals_at(d, truth), {.facing = Facing::kEither});
    ++tried;
    if (fix.status == FixStatus::kAmbiguous) {
      ++ambiguous;
    } else {
      expect_pose(fix, truth);
    }
  }
  EXPECT_LT(ambiguous, tried / 4);
}

TEST(OneBeacon, EitherSideOfASingleBeaconNeedsTheLastPosition) {
  const Deployment d = site({{0, 5, 2.0}});
  OneBeacon localizer(d, {.heading_rad = 0.1, .facing = Facing::kEither, .max_speed_mps = 1.0});
  const Pose truth = Pose::planar(1, 1, 0.1);
  EXPECT_EQ(locate(localizer, arrivals_at(d, truth)).status, FixStatus::kAmbiguous);
  // No state remains of that; two beacons fix it, and then one is enough.
  Deployment both = site({{0, 5, 2.0}, {5, 4, 2.0}});
  OneBeacon remembering(both, {.heading_rad = 0.1, .facing = Facing::kEither});
  auto two = arrivals_at(both, truth);
  expect_pose(locate(remembering, two), truth);
  std::vector<Arrival> one(two.begin(), two.begin() + 2);
  expect_pose(locate(remembering, one), truth);
}

TEST(OneBeacon, TheHeadingOfAStraightRailAndOfOdometryServe) {
  Deployment d = site({{3, 4, 2.0}});
  const Pose truth = Pose::planar(2, 1, 0.25);
  EXPECT_EQ(locate(d, arrivals_at(d, truth)).status, FixStatus::kTooFewArrivals)
      << "two ranges for three unknowns";
  OneBeacon told(d);
  told.set_heading(0.25, 1e-3);
  expect_pose(locate(told, arrivals_at(d, truth)), truth);
  d.vehicles[0].rail = Rail{.from_m = {2, 1}, .to_m = {2 + 10 * std::cos(0.25), 1 + 10 * std::sin(0.25)}};
  expect_pose(locate(d, arrivals_at(d, truth)), truth);
}

TEST(OneBeacon, OfManyReceiversTheWidestPairIsUsed) {
  Deployment d = test::with_octagon(test::hall(0));
  DeploymentBeacon b;
  b.position_m = {0, 5, 1.0};
  d.beacons.push_back(b);
  const Pose truth = Pose::planar(0.5, 1, 0.0);
  std::mt19937_64 random(kSeed);
  const auto arrivals = test::hear(d, truth, {.half_angle_rad = M_PI}, random);
  const Fix fix = locate(d, arrivals, {.heading_rad = 0.0, .facing = Facing::kRight});
  expect_pose(fix, truth);
  EXPECT_EQ(fix.arrivals_used, 2);
  EXPECT_EQ(std::count(fix.rejections.begin(), fix.rejections.end(), Rejection::kNotNeeded), 6);
}

TEST(OneBeacon, CovarianceIsThatOfNumericDerivatives) {
  Deployment one = site({{0, 5, 2.0}}), two = site({{0, 5, 2.0}, {6, 5.5, 1.8}});
  one.noise.tof_sigma_s = two.noise.tof_sigma_s = 1e-7;
  for (double x = 0.3; x < 5; x += 0.9) {
    const Pose truth = Pose::planar(x, 1, 0.2);
    OneBeacon known(one, {.heading_rad = 0.2, .heading_sigma_rad = 1e-9}), solved(two);
    for (auto* localizer : {&known, &solved}) {
      const auto arrivals = arrivals_at(localizer == &known ? one : two, truth);
      const Fix fix = locate(*localizer, arrivals);
      ASSERT_TRUE(fix.ok());
      const Eigen::Matrix3d numeric = test::numeric_covariance(*localizer, arrivals, 1e-7);
      // Central differences over 1e-8 s; the exact heading has a weight of 1e18; noise of 1e-7 s has no
      // nonlinear effect.
      EXPECT_LT((Eigen::Matrix3d(fix.covariance) - numeric).norm(), 1e-4 * numeric.norm());
    }
  }
}

TEST(OneBeacon, NoiseStaysWithinWhatIsStated) {
  const Deployment one = site({{0, 5, 2.0}}), two = site({{0, 5, 2.0}, {6, 5.5, 1.8}});
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> x(0.0, 5.0), y(-1.0, 2.0), heading(-0.4, 0.4);
  std::normal_distribution<double> normal;
  constexpr int kFixes = 1000;
  double sum_one = 0, sum_two = 0;
  OneBeacon known(one), solved(two);
  for (int i = 0; i < kFixes; ++i) {
    const Pose truth = Pose::planar(x(random), y(random), heading(random));
    known.set_heading(truth.heading_rad() + 2e-3 * normal(random), 2e-3);
    for (auto* localizer : {&known, &solved}) {
      auto arrivals =
          test::hear(localizer == &known ? one : two, truth, {.range_m = 100.0, .noise_s = 1e-5}, random);
      localizer->forget();
      const Fix fix = locate(*localizer, arrivals);
      ASSERT_TRUE(fix.ok()) << i << " " << to_string(fix.status);
      (localizer == &known ? sum_one : sum_two) += test::nees(fix, truth);
    }
  }
  RecordProperty("nees_one", std::to_string(sum_one / kFixes / 3));
  RecordProperty("nees_two", std::to_string(sum_two / kFixes / 3));
  for (const double sum : {sum_one, sum_two}) {  // two-sided at 0.1 %
    EXPECT_GT(sum, test::chi2_quantile(0.0005, 3 * kFixes));
    EXPECT_LT(sum, test::chi2_quantile(0.9995, 3 * kFixes));
  }
}

TEST(OneBeacon, AnEchoAmongThreeBeaconsIsOutvoted) {
  const Deployment d = site({{0, 5, 2.0}, {6, 5.5, 1.8}, {3, 6, 1.9}});
  const Pose truth = Pose::planar(2, 1, 0.1);
  auto arrivals = arrivals_at(d, truth);
  for (Arrival& a : arrivals)
    if (a.beacon.index() == 1) a.tof_s += 1e-3;  // both receivers alike: the circles still meet
  const Fix fix = locate(d, arrivals);
  expect_pose(fix, truth);
  EXPECT_EQ(fix.rejections[2], Rejection::kOutvoted);
  EXPECT_EQ(fix.rejections[3], Rejection::kOutvoted);
  EXPECT_EQ(fix.arrivals_used, 4);
}

TEST(OneBeacon, TheLastPositionTellsWhichOfTwoBeaconsIsAnEcho) {
  const Deployment d = site({{0, 5, 2.0}, {6, 5.5, 1.8}});
  OneBeacon localizer(d, {.heading_rad = 0.1, .max_speed_mps = 0.5});
  const Pose truth = Pose::planar(2, 1, 0.1);
  auto arrivals = arrivals_at(d, truth);
  for (Arrival& a : arrivals)
    if (a.beacon.index() == 0) a.tof_s += 6e-3;
  EXPECT_EQ(locate(localizer, arrivals).status, FixStatus::kNoConsensus);
  expect_pose(locate(localizer, arrivals_at(d, truth)), truth);
  const Fix fix = locate(localizer, arrivals);
  expect_pose(fix, truth);
  EXPECT_EQ(fix.rejections[0], Rejection::kOutvoted);
  EXPECT_EQ(fix.arrivals_used, 2);
}

TEST(OneBeacon, TwoBeaconsThatBothAreWithinReachAreNotToldApart) {
  const Deployment d = site({{0, 5, 2.0}, {6, 5.5, 1.8}});
  OneBeacon localizer(d, {.heading_rad = 0.1, .max_speed_mps = 10.0});
  const Pose truth = Pose::planar(2, 1, 0.1);
  auto arrivals = arrivals_at(d, truth);
  expect_pose(locate(localizer, arrivals), truth);
  for (Arrival& a : arrivals) {
    a.time_s += 1.0;
    if (a.beacon.index() == 0) a.tof_s += 6e-3;
  }
  EXPECT_EQ(locate(localizer, arrivals).status, FixStatus::kNoConsensus);
}

TEST(OneBeacon, TheRulesTakeEchoesOut) {
  const Deployment d = site({{0, 5, 2.0}});
  const Pose truth = Pose::planar(1, 1, 0.1);
  auto arrivals = arrivals_at(d, truth);
  for (const std::size_t i : {0u, 1u}) {  // right behind the direct signal, and far behind
    Arrival echo = arrivals[i];
    echo.tof_s += 1.2e-3;
    echo.time_s += 1.2e-3;
    arrivals.push_back(echo);
    echo.tof_s += 0.03;
    echo.time_s += 0.03;
    arrivals.push_back(echo);
  }
  std::sort(arrivals.begin(), arrivals.end(),
            [](const Arrival& a, const Arrival& b) { return a.time_s < b.time_s; });
  const Fix fix =
      locate(d, arrivals, {.heading_rad = 0.1, .ranges = {.gates = {.min_m = 0.6, .max_m = 9.0}}});
  expect_pose(fix, truth);
  EXPECT_EQ(std::count(fix.rejections.begin(), fix.rejections.end(), Rejection::kReflection), 2);
  EXPECT_EQ(std::count(fix.rejections.begin(), fix.rejections.end(), Rejection::kOutOfRange), 2);
}

TEST(OneBeacon, WhereNothingIsKnownTheReasonIs) {
  const Deployment d = site({{0, 5, 2.0}});
  const Pose truth = Pose::planar(1, 1, 0.1);
  const OneBeaconOptions known{.heading_rad = 0.1};
  const auto both = arrivals_at(d, truth);
  EXPECT_EQ(locate(d, {}, known).status, FixStatus::kTooFewArrivals);
  EXPECT_EQ(locate(d, {both[0]}, known).status, FixStatus::kTooFewArrivals);
  auto echo = both;
  echo[0].tof_s += 3e-3;  // a metre, and the receivers are 0.4 m apart
  EXPECT_EQ(locate(d, echo, known).status, FixStatus::kNoConsensus);
  auto nan = both;
  nan[1].tof_s = std::nan("");
  EXPECT_EQ(locate(d, nan, known).status, FixStatus::kTooFewArrivals);
  const Pose in_line = Pose::planar(0, 2, M_PI / 2);
  EXPECT_EQ(locate(d, arrivals_at(d, in_line), {.heading_rad = M_PI / 2}).status, FixStatus::kPoorGeometry);
  const Deployment coincident = test::ranging_site({{0, 5, 2.0}}, {{0, 0, 0.5}, {0, 0, 0.5}});
  EXPECT_EQ(locate(coincident, arrivals_at(coincident, truth), known).status, FixStatus::kTooFewArrivals);
  const Deployment two = site({{0, 5, 2.0}, {6, 5.5, 1.8}});
  auto echoes = arrivals_at(two, Pose::planar(2, 1, 0.1));
  for (std::size_t i = 2; i < 4; ++i) echoes[i].tof_s += 4e-3;
  EXPECT_EQ(locate(two, echoes).status, FixStatus::kNoConsensus);
}

TEST(OneBeacon, AllocatesNothing) {
  const Deployment d = site({{0, 5, 2.0}, {6, 5.5, 1.8}, {3, 6, 1.9}});
  const auto arrivals = arrivals_at(d, Pose::planar(2, 1, 0.1), 1e-5);
  for (const Facing facing : {Facing::kLeft, Facing::kEither}) {
    OneBeacon localizer(d, {.facing = facing});
    Fix fix = OneBeacon(d, {.facing = facing}).locate({.arrivals = arrivals, .bearings = {}});
    const std::size_t before = test::allocations();
    localizer.locate({.arrivals = arrivals, .bearings = {}}, fix);
    EXPECT_EQ(test::allocations(), before);
    EXPECT_TRUE(fix.ok());
  }
}

TEST(OneBeacon, SaysWhatADeploymentLacks) {
  const auto words = [](const Deployment& d, OneBeaconOptions options = {}) {
    const auto fits = one_beacon_fits(d, options);
    return fits ? std::string() : fits.error().message();
  };
  EXPECT_EQ(words(site({{0, 5, 2.0}, {6, 5.5, 1.8}})), "");
  EXPECT_EQ(words(site({{0, 5, 2.0}}), {.heading_rad = 0.0}), "");
  EXPECT_NE(words(site({{0, 5, 2.0}})).find("does not determine the heading"), std::string::npos);
  EXPECT_NE(words(site({})).find("no usable beacon"), std::string::npos);
  EXPECT_NE(words(test::ranging_site({{0, 5, 2}, {6, 5, 2}}, {{0, 0, 1}})).find("two receivers"),
            std::string::npos);
}

}  // namespace one_beacon_test
}  // namespace octant
