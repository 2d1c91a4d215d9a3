// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pose_readings.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace pose_readings_test {

// For any reflection of a frame, distances stay, turns change their sign, and a second reflection restores
// the original.
TEST(Reflections, KeepDistancesAndUndoThemselves) {
  Random draws(3);
  std::vector<MeasurementLog> runs(1);
  runs[0].poses.resize(1);
  for (const calib::Reading& frame : calib::other_pose_frames(runs)) {
    SCOPED_TRACE(frame.what.found);
    const auto read = [&](const Pose& pose) {
      MeasurementLog run = runs[0];
      run.poses[0].T_map_vehicle = pose;
      frame.log(0, run);
      return run.poses[0].T_map_vehicle;
    };
    for (int i = 0; i < 20; ++i) {
      const Pose a = Pose::planar(5 * draws.normal(), 5 * draws.normal(), draws.uniform(-3, 3)),
                 b = Pose::planar(5 * draws.normal(), 5 * draws.normal(), draws.uniform(-3, 3));
      const Pose A = read(a), B = read(b);
      EXPECT_NEAR((A.translation_m - B.translation_m).norm(), (a.translation_m - b.translation_m).norm(),
                  1e-12);
      EXPECT_NEAR(wrap_angle(B.heading_rad() - A.heading_rad() + b.heading_rad() - a.heading_rad()), 0.0,
                  1e-12);
      EXPECT_LT((A.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ()).norm(), 1e-12)
          << "z stays up";
      const Pose again = read(A);
      EXPECT_LT((again.translation_m - a.translation_m).norm(), 1e-12);
      EXPECT_NEAR(wrap_angle(again.heading_rad() - a.heading_rad()), 0.0, 1e-12);
    }
  }
}

TEST(OtherPoseFrames, AreNoneWithoutPoses) {
  EXPECT_TRUE(calib::other_pose_frames({}).empty());
  EXPECT_TRUE(calib::other_pose_frames(std::vector<MeasurementLog>(2)).empty());
}

TEST(OtherPoseFrames, MirrorEveryPoseOfEveryRun) {
  std::vector<MeasurementLog> runs(2);
  runs[1].poses = {{0.0, Pose::planar(1, 2, 0.3)}, {1.0, Pose::planar(3, -1, 2.0)}};
  const auto readings = calib::other_pose_frames(runs);
  ASSERT_EQ(readings.size(), 5U);
  MeasurementLog run = runs[1];
  readings[0].log(1, run);
  EXPECT_EQ(run.poses[0].T_map_vehicle.translation_m, Eigen::Vector3d(1, -2, 0));
  EXPECT_EQ(run.poses[1].T_map_vehicle.translation_m, Eigen::Vector3d(3, 1, 0));
}

/// A vehicle on a straight path, with ten poses and ten arrivals a second.
MeasurementLog straight_on(double speed_mps) {
  MeasurementLog run;
  for (int i = 0; i < 50; ++i) {
    run.poses.push_back({0.1 * i, Pose::planar(speed_mps * 0.1 * i, 1.0, 0.0)});
    run.arrivals.push_back({});
    run.arrivals.back().time_s = 0.1 * i;
  }
  return run;
}

TEST(PosesStampedLate, MatterWhereTheVehicleMovesWhileItIsMeasured) {
  const auto families_of = [](const MeasurementLog& run) {
    return calib::poses_stamped_late(std::vector<MeasurementLog>(1, run)).size();
  };
  EXPECT_EQ(families_of({}), 0U);
  EXPECT_EQ(families_of(straight_on(0.0)), 0U);
  EXPECT_EQ(families_of(straight_on(0.3)), 1U);
  MeasurementLog stops = straight_on(0.3);  // one pose and arrival a stop, nothing between
  for (std::size_t i = 0; i < stops.poses.size(); ++i)
    stops.poses[i].time_s = stops.arrivals[i].time_s = 60.0 * static_cast<double>(i);
  EXPECT_EQ(families_of(stops), 0U);
}

// An arrival at the start of a stop and one at its end: a lag would remove the poses of the last second.
TEST(PosesStampedLate, MayNotBeLost) {
  const std::vector<MeasurementLog> runs = {straight_on(0.5)};
  const auto families = calib::poses_stamped_late(runs);
  ASSERT_EQ(families.size(), 1U);
  EXPECT_TRUE(families[0].may_be(0.3));
  EXPECT_FALSE(families[0].may_be(0.95)) << "of five seconds";
  EXPECT_FALSE(families[0].may_be(1.5));
}

TEST(PosesStampedLate, AreReadAsTheArrivalsClockWouldHaveThem) {
  std::vector<MeasurementLog> runs = {straight_on(0.3)};
  runs[0].path = "run";
  const calib::ReadingFamily family = calib::poses_stamped_late(runs).at(0);
  const calib::Reading late = family.reading(0.25), early = family.reading(-0.25);
  MeasurementLog run = runs[0];
  late.log(0, run);
  EXPECT_NEAR(run.poses[10].time_s, 0.75, 1e-12);
  EXPECT_NEAR(run.poses[10].T_map_vehicle.translation_m.x(), 0.3, 1e-12);
  early.log(0, run);
  EXPECT_NEAR(run.poses[10].time_s, 1.0, 1e-12);
  EXPECT_NE(late.what.found.find("0.25 s late"), std::string::npos);
  EXPECT_NE(late.what.remedy.find("subtract 0.25 s from each time of run/poses.tum"), std::string::npos);
  EXPECT_NE(early.what.remedy.find("add 0.25 s to each time of run/poses.tum"), std::string::npos);
}

TEST(PosesOfOtherPoint, AreReadAsTheOriginHasThem) {
  std::vector<MeasurementLog> runs(1);
  const Pose origin = Pose::planar(1, 2, M_PI / 2);
  const Eigen::Vector3d prism(0.4, 0.1, 0.0);
  runs[0].poses = {{1.0, {origin * prism, origin.rotation}}};
  calib::poses_of_other_point(runs, prism).log(0, runs[0]);
  EXPECT_LT((runs[0].poses[0].T_map_vehicle.translation_m - origin.translation_m).norm(), 1e-12);
}

TEST(WithoutPoses, LeavesThoseOfDrives) {
  MeasurementLog stops, drive;
  stops.has_epochs = true;
  stops.poses.resize(3);
  drive.poses.resize(3);
  EXPECT_TRUE(calib::without_poses({drive}).empty());
  const auto readings = calib::without_poses({drive, stops});
  ASSERT_EQ(readings.size(), 1U);
  readings[0].log(0, drive);
  readings[0].log(1, stops);
  EXPECT_EQ(drive.poses.size(), 3U);
  EXPECT_TRUE(stops.poses.empty());
}

TEST(FrameBetween, IsTheOneThatTookThePointsThere) {
  Random draws(4);
  for (int trial = 0; trial < 20; ++trial) {
    Pose T = Pose::planar(5 * draws.normal(), 5 * draws.normal(), draws.uniform(-3, 3));
    T.translation_m.z() = draws.normal();
    std::vector<Eigen::Vector3d> from, to;
    for (int i = 0; i < 2 + trial % 4; ++i) {
      from.emplace_back(10 * draws.normal(), 10 * draws.normal(), draws.normal());
      to.push_back(T * from.back());
    }
    const auto found = calib::frame_between(from, to);
    ASSERT_TRUE(found);
    EXPECT_LT((found->translation_m - T.translation_m).norm(), 1e-9);
    EXPECT_NEAR(wrap_angle(found->heading_rad() - T.heading_rad()), 0.0, 1e-9);
  }
}

// Independent errors of points cannot be reduced much by a common rotation.
TEST(FrameBetween, IsOfLeastSquares) {
  const std::vector<Eigen::Vector3d> from = {{0, 0, 2}, {10, 0, 2}, {10, 6, 2}, {0, 6, 3}};
  std::vector<Eigen::Vector3d> to = from;
  to[1].y() += 0.3;
  to[2].z() += 0.2;
  const auto found = calib::frame_between(from, to);
  ASSERT_TRUE(found);
  const auto squares = [&](const Pose& T) {
    double sum = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) sum += (to[i] - T * from[i]).squaredNorm();
    return sum;
  };
  for (const double step : {-1e-3, 1e-3}) {
    EXPECT_LT(squares(*found), squares(Pose::planar(0, 0, step) * *found));
    for (int i = 0; i < 3; ++i) {
      Pose other = *found;
      other.translation_m[i] += step;
      EXPECT_LT(squares(*found), squares(other));
    }
  }
}

TEST(FrameBetween, NeedsPointsThatTellATurn) {
  EXPECT_FALSE(calib::frame_between({}, {}));
  EXPECT_FALSE(calib::frame_between({{1, 2, 3}}, {{1, 2, 3}}));
  EXPECT_FALSE(calib::frame_between({{1, 2, 3}, {1, 2, 4}}, {{1, 2, 3}, {1, 2, 4}})) << "one above the other";
}

/// Stops with measured poses in a frame that is turned and shifted against the control points'.
World surveyed_in(const Pose& T_frame_map) {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  s.log_poses = true;
  World world = must(simulate(s, 3));
  for (TimedPose& pose : world.run.poses) pose.T_map_vehicle = T_frame_map * pose.T_map_vehicle;
  return world;
}

// All control points were blamed, one by one.
TEST(FrameOfPoses, IsNamedInPlaceOfTheControlPoints) {
  EXPECT_THAT(explained(surveyed_in(Pose{})), ::testing::IsEmpty());
  const auto found = explained(surveyed_in(Pose::planar(0.2, -0.1, -0.03)));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kPoses);
  EXPECT_EQ(found[0].stated, "in the frame of the control points");
  EXPECT_THAT(found[0].found, ::testing::HasSubstr("turned by 1.7"));
}

// A point that is elsewhere is no frame.
TEST(FrameOfPoses, IsRightWhereOneControlPointIsWrong) {
  World world = surveyed_in(Pose{});
  for (SiteBeacon& b : world.site.beacons)
    if (b.is_control_point()) {
      *b.position_m[0] += 0.3;
      break;
    }
  const auto found = explained(world);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, ContradictionKind::kControlPoint);
}

}  // namespace pose_readings_test
}  // namespace octant::test
