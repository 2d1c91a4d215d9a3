// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/common_errors.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/readings/cart.h"
#include "tests/calib/statements/adjusted.h"

namespace octant::test {
namespace common_errors_test {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Kind = calib::CommonError::Kind;

/// With an error in it, by what takes it back.
World with_error(World world, calib::CommonError error) {
  error.size = -error.size;
  calib::take_back(error, calib::span_of(world.run.arrivals), world.run);
  return world;
}

double middle_s(const World& world) { return world.run.arrivals[world.run.arrivals.size() / 2].time_s; }

TEST(CommonErrors, AreNoneWhereThereAreNone) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    EXPECT_THAT(solution_of(must(simulate(drive_scenario(), seed))).common_errors, IsEmpty()) << seed;
    EXPECT_THAT(solution_of(cart(40, seed)).common_errors, IsEmpty()) << seed;
  }
}

TEST(CommonErrors, AreToldApartAndSized) {
  const World drive = must(simulate(drive_scenario(), 5)), stops = cart(60, 5);
  // In the middle of a recording a small jump looks much like a drift.
  const double late_s = stops.run.arrivals[stops.run.arrivals.size() * 4 / 5].time_s;
  const std::pair<World, calib::CommonError> cases[] = {
      {drive, {.kind = Kind::kTurns, .size = 0.03}},
      {drive, {.kind = Kind::kTurns, .size = -0.03}},
      {drive, {.kind = Kind::kSpeed, .size = 0.004}},
      {stops, {.kind = Kind::kSpeed, .size = -0.003}},
      {stops, {.kind = Kind::kDrift, .size = 1e-4}},
      {stops, {.kind = Kind::kJump, .time_s = late_s, .size = 5e-5}}};
  for (const auto& [world, error] : cases) {
    const calib::Solution solution = solution_of(with_error(world, error));
    const auto& found = solution.common_errors;
    SCOPED_TRACE(testing::Message() << static_cast<int>(error.kind) << " of " << error.size);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().kind, error.kind);
    EXPECT_GT(found.front().size / error.size, 0.6);
    EXPECT_LT(found.front().size / error.size, 1.3);
  }
}

/// Makes ranges longer in front of each receiver, and shorter behind it.
World with_pattern(World world, double amplitude_m) {
  const double speed = speed_mps(world.site.medium);
  for (Arrival& a : world.run.arrivals) {
    Pose pose;
    EXPECT_TRUE(interpolate_poses(world.run.truth, a.time_s, 10.0, pose));
    const Eigen::Vector3d& p_m = world.site.receivers[a.receiver.index()].position_m;
    const Eigen::Vector3d to_beacon_m = world.truth.beacons[a.beacon.index()].position_m - pose * p_m,
                          outwards = pose.rotation * Eigen::Vector3d(p_m.x(), p_m.y(), 0.0).normalized();
    a.tof_s += amplitude_m * outwards.dot(to_beacon_m.normalized()) / speed;
  }
  return world;
}

// The receivers were blamed, each of them a little further in than stated.
TEST(CommonErrors, APatternOfTheReceiversIsNoPlaceOfReceivers) {
  for (const double amplitude_m : {0.03, -0.03}) {
    const calib::Solution solution = solution_of(with_pattern(cart(60, 4, 0.0), amplitude_m));
    EXPECT_THAT(solution.contradictions, IsEmpty());
    ASSERT_FALSE(solution.common_errors.empty());
    EXPECT_EQ(solution.common_errors.front().kind, Kind::kPattern);
    EXPECT_NEAR(solution.common_errors.front().size, amplitude_m, 0.2 * std::abs(amplitude_m));
    EXPECT_THAT(solution.warnings, Contains(HasSubstr("patterns of antennas and transducers")));
  }
}

// Its sigmas were a tenth of the errors of the beacons, and the grade was Good.
TEST(CommonErrors, OdometryThatTurnsTooFarIsContradicted) {
  const World world = with_error(must(simulate(drive_scenario(), 6)), {.kind = Kind::kTurns, .size = 0.02});
  const calib::Solution solution = explained_solution(world);
  ASSERT_EQ(solution.contradictions.size(), 1U);
  EXPECT_EQ(solution.contradictions[0].kind, ContradictionKind::kLog);
  EXPECT_THAT(solution.contradictions[0].found, HasSubstr("its turns are"));
  EXPECT_THAT(solution.contradictions[0].found, HasSubstr("% too large"));
}

// On a straight drive most of the measured turns are noise, which is correlated with itself: a correct drive
// was Contradicted, with its turns 64 % too large.
TEST(CommonErrors, NoiseOfOdometryIsNoError) {
  Scenario s = drive_scenario(60.0);
  s.path.waypoints_m = {{2.0, 6.0}, {18.0, 6.5}};
  s.odometry_accuracy.heading_sigma_rad_per_sqrt_m = 0.04;
  s.site.noise.tof_sigma_s = 3e-6;  // two receivers far apart tell the heading to two thousandths
  s.hearing_half_angle_rad = 3.2;
  s.site.receivers.resize(2);
  for (std::size_t i = 0; i < 2; ++i) {
    s.site.receivers[i].position_m = Eigen::Vector3d(i == 0 ? -0.3 : 0.4, i == 0 ? -0.3 : 0.2, 0.6);
    s.site.receivers[i].axis.reset();
  }
  s.site.vehicles[0].receiver_count = 2;
  s.site.vehicles[0].array.reset();
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (const calib::CommonError& e : solution_of(must(simulate(s, seed))).common_errors)
      EXPECT_FALSE(calib::is_of_odometry(e)) << seed << ": " << e.size << ", " << e.sigmas << " sigma";
}

// All recordings of one vehicle have its odometry's scale.
TEST(CommonErrors, OdometryOfTwoRunsHasOneError) {
  Scenario s = drive_scenario(40.0);
  s.heldout_path = s.path;
  World world = must(simulate(s, 6));
  const calib::CommonError turns{.kind = Kind::kTurns, .size = -0.03};
  for (MeasurementLog* run : {&world.run, &world.heldout}) calib::take_back(turns, calib::span_of({}), *run);
  const auto found = [&](const std::vector<MeasurementLog>& runs) {
    const auto all = calib::solve(must(calib::make_problem(world.site, runs)), {}).common_errors;
    const auto of_turns = std::ranges::find(all, Kind::kTurns, &calib::CommonError::kind);
    return of_turns == all.end() ? calib::CommonError{} : *of_turns;
  };
  const calib::CommonError one = found({world.run}), both = found({world.run, world.heldout});
  EXPECT_GT(both.sigmas, 1.1 * one.sigmas);
  EXPECT_NEAR(both.size, 0.03, 0.012);
}

// Exact poses show the curvature between two rows as a scale error; it has no effect with them.
TEST(CommonErrors, OdometryIsNotJudgedBesideMeasuredPoses) {
  Scenario s = drive_scenario(40.0);
  s.log_poses = true;
  const World world = with_error(must(simulate(s, 6)), {.kind = Kind::kTurns, .size = 0.03});
  const calib::Solution solution = solution_of(world);
  for (const calib::CommonError& e : solution.common_errors) EXPECT_FALSE(calib::is_of_odometry(e));
}

/// A cart whose poses were measured.
World posed_cart(std::uint64_t seed) {
  Scenario s = hall_scenario();
  s.log_poses = true;
  return must(simulate(s, seed));
}

// An instrument was set up again some centimetres from its earlier position: beacons had errors of twenty of
// their sigmas, and the grade was Good.
TEST(CommonErrors, PosesThatShiftMidwayAreNamed) {
  for (const double size_m : {0.02, 0.05}) {
    World world = posed_cart(9);
    calib::CommonError shift{.kind = Kind::kShift, .time_s = middle_s(world), .size = size_m};
    shift.along = Eigen::Vector3d(0.6, -0.8, 0.0);
    world = with_error(world, shift);
    const calib::Solution solution = explained_solution(world);
    ASSERT_EQ(solution.contradictions.size(), 1U);
    EXPECT_EQ(solution.contradictions[0].kind, ContradictionKind::kPoses);
    EXPECT_THAT(solution.contradictions[0].found, HasSubstr("they are shifted by"));
    ASSERT_FALSE(solution.common_errors.empty());
    const calib::CommonError& found = solution.common_errors.front();
    EXPECT_EQ(found.kind, Kind::kShift);
    EXPECT_NEAR(found.size, size_m, 0.3 * size_m);
    EXPECT_GT(found.along.dot(shift.along), 0.95);
  }
}

TEST(CommonErrors, PosesThatDoNotShiftAreNotNamed) {
  Scenario drive = drive_scenario(40.0);
  drive.log_poses = true;
  for (std::uint64_t seed = 10; seed < 18; ++seed) {
    EXPECT_THAT(solution_of(posed_cart(seed)).common_errors, IsEmpty()) << seed;
    EXPECT_THAT(solution_of(must(simulate(drive, seed))).common_errors, IsEmpty()) << seed;
  }
}

// By 5 K control points were blamed.
TEST(CommonErrors, AHallThatWarmsIsNamedAndNoStatementIsBlamed) {
  for (const double size : {0.003, 0.009}) {
    const calib::Solution solution =
        explained_solution(with_error(cart(60, 7), {.kind = Kind::kSpeed, .size = size}));
    ASSERT_EQ(solution.contradictions.size(), 1U) << size;
    EXPECT_EQ(solution.contradictions[0].kind, ContradictionKind::kLog);
    EXPECT_THAT(solution.contradictions[0].found,
                AllOf(HasSubstr("faster at its end than at its beginning"), HasSubstr("air that warms by")));
  }
}

// With all beacons fixed, a drift was modelled as correlated noise, and the grade was Good.
TEST(CommonErrors, AClockThatDriftsAmongHeldBeaconsIsNamed) {
  World world = cart(60, 7);
  for (std::size_t b = 0; b < world.site.beacons.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i) {
      world.site.beacons[b].position_m[i] = world.truth.beacons[b].position_m[static_cast<int>(i)];
      world.site.beacons[b].sigma_m[i] = 0.0;
    }
  const calib::Solution solution =
      explained_solution(with_error(world, {.kind = Kind::kDrift, .size = 4e-4}));
  ASSERT_EQ(solution.contradictions.size(), 1U);
  EXPECT_THAT(solution.contradictions[0].found, HasSubstr("that it drifts"));
}

TEST(CommonErrors, PosesThatAreStampedLateAreNamed) {
  Scenario drive = drive_scenario(40.0);
  drive.log_poses = true;
  const World world = with_error(must(simulate(drive, 11)), {.kind = Kind::kLag, .size = 0.2});
  const calib::Solution solution = explained_solution(world);
  ASSERT_EQ(solution.contradictions.size(), 1U);
  EXPECT_THAT(solution.contradictions[0].found, HasSubstr("s late"));
}

// Control points that bend to it were blamed.
TEST(CommonErrors, AClockThatJumpedDuringADriveIsNamed) {
  World world = must(simulate(drive_scenario(40.0), 8));
  world = with_error(world, {.kind = Kind::kJump, .time_s = middle_s(world), .size = 1.5e-4});
  const calib::Solution solution = explained_solution(world);
  ASSERT_EQ(solution.contradictions.size(), 1U);
  EXPECT_THAT(solution.contradictions[0].found, HasSubstr("that it jumped: from"));
}

TEST(CommonErrors, AreSaidWithWhatToDo) {
  std::vector<MeasurementLog> runs(1);
  runs[0].path = "hall/run";
  Site site;
  site.medium.model = MediumModel::kCramer1993;
  const auto said = [&](const calib::CommonError& error) {
    const Contradiction c = calib::contradiction_of(error, site, runs);
    return in_words(c) + "; " + c.remedy;
  };
  EXPECT_THAT(said({.kind = Kind::kWay, .size = 0.02, .sigmas = 9.0}),
              AllOf(HasSubstr("hall/run/odometry.csv"), HasSubstr("its way is 2 % too long (9.0 sigma)"),
                    HasSubstr("multiply dx_m and dy_m by 0.9804")));
  EXPECT_THAT(said({.kind = Kind::kSpeed, .size = -0.0035}),
              AllOf(HasSubstr("0.35 % slower"), HasSubstr("air that cools by 1.9 degC")));
  EXPECT_THAT(said({.kind = Kind::kDrift, .size = 5e-5}), HasSubstr("0.05 ms longer at its end"));
  EXPECT_THAT(said({.kind = Kind::kJump, .time_s = 12.5, .size = -5e-5}),
              HasSubstr("from 12.5 s on times of flight are 0.05 ms shorter"));
  EXPECT_THAT(said({.kind = Kind::kShift, .time_s = 12.5, .size = 0.5, .along = {0.6, -0.8, 0.0}}),
              AllOf(HasSubstr("from 12.5 s on they are shifted by (0.300, -0.400) m"),
                    HasSubstr("shift the later poses by (-0.300, 0.400) m")));
  site.medium.model = MediumModel::kConstant;
  EXPECT_THAT(said({.kind = Kind::kSpeed, .size = 0.001}), Not(HasSubstr("degC by")));
}

// The speed of light does not depend on the temperature.
TEST(CommonErrors, RadioHasNoWeather) {
  const World world = cart(60, 7);
  const calib::Solution solution = solution_of(with_error(world, {.kind = Kind::kSpeed, .size = 0.003}));
  std::vector<Trajectory> radio = solution.trajectories;
  for (Trajectory& of_radio : radio) of_radio.nominal_speed_mps = 3e8;
  const auto is_of_speed = [](const calib::CommonError& e) { return e.kind == Kind::kSpeed; };
  const Adjusted adjusted(world, solution);
  EXPECT_TRUE(std::ranges::any_of(solution.common_errors, is_of_speed));
  EXPECT_TRUE(
      std::ranges::none_of(calib::common_errors(radio, solution.state, adjusted.parameters()), is_of_speed));
}

}  // namespace common_errors_test
}  // namespace octant::test
