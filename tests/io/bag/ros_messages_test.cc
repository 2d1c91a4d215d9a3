// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/ros_messages.h"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "tests/io/bag/bag_support.h"

namespace octant::io {
namespace ros_messages_test {

using testing::HasSubstr;

Pose some_pose() {
  const auto angle = [] { return 3.0 * (2 * test::some_fraction() - 1); };
  const Eigen::Vector3d turn(angle(), angle(), angle());
  return {{test::some_number(), test::some_number(), test::some_number()}, exp_rotation(turn)};
}

TEST(RosTime, NanosecondsAreTheSameDoubleBack) {
  EXPECT_TRUE(rc::check("for times of at most nine decimals", [] {
    const auto whole = *rc::gen::inRange<std::int64_t>(-4'000'000'000, 4'000'000'000);
    const auto decimals = *rc::gen::inRange<std::int64_t>(0, 1'000'000'000);
    const std::int64_t ns = whole * 1'000'000'000 + decimals;
    const double time_s = seconds_of(ns);
    RC_ASSERT(seconds_of(nanoseconds_of(time_s)) == time_s);
    // A second of 1e9 s is known to 1e-7 s; near zero it is exact.
    const double error_ns = static_cast<double>(nanoseconds_of(time_s) - ns);
    RC_ASSERT(std::abs(error_ns) <= 1 + std::abs(static_cast<double>(whole)) * 1.2e-16 * 1e9);
  }));
  EXPECT_EQ(nanoseconds_of(1.5), 1'500'000'000);
  EXPECT_EQ(nanoseconds_of(-1.5), -1'500'000'000);
  EXPECT_EQ(nanoseconds_of(0.999'999'999'6), 1'000'000'000) << "the nearest";
  EXPECT_EQ(seconds_of(1'234'567'890'123'456'789), 1234567890.123456789);
  EXPECT_EQ(seconds_of(-1), -1e-9);
}

TEST(RosPoses, ReadBackWithTheirStampAndFrames) {
  EXPECT_TRUE(rc::check("PoseStamped and Odometry", [] {
    const Pose T = some_pose();
    const auto ns = *rc::gen::inRange<std::int64_t>(-2'000'000'000'000'000'000, 2'000'000'000'000'000'000);
    const auto poses = poses_of(kRosPose, ros_pose(ns, "map", T));
    RC_ASSERT(poses.has_value() && poses->size() == 1U);
    const RosPose& p = poses->front();
    RC_ASSERT(p.frame == "map" && p.child.empty());
    RC_ASSERT(p.stamp_s == seconds_of(ns));
    RC_ASSERT(p.T_frame_child.translation_m == T.translation_m);
    RC_ASSERT(p.T_frame_child.rotation.angularDistance(T.rotation) < 1e-7);
    const auto odometry = poses_of(kRosOdometry, ros_odometry(ns, "odom", "base", T));
    RC_ASSERT(odometry.has_value() && odometry->front().child == "base");
    RC_ASSERT(odometry->front().T_frame_child.translation_m == T.translation_m);
  }));
}

TEST(RosPoses, QuaternionsAreNormalisedAndThoseOfNoLengthAreNone) {
  const auto message = [](double x, double y, double z, double w, double place = 0.0) {
    CdrWriter out;
    out.value(std::int32_t{1}), out.value(std::uint32_t{0}), out.text("map");
    for (const double v : {place, 2.0, 3.0, x, y, z, w}) out.value(v);
    return out.message();
  };
  const auto poses = poses_of(kRosPose, message(0, 0, 3, 4));
  ASSERT_TRUE(poses);
  EXPECT_NEAR(poses->front().T_frame_child.rotation.norm(), 1.0, 1e-15);
  EXPECT_NEAR(poses->front().T_frame_child.heading_rad(), 2 * std::atan2(3, 4), 1e-15);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(poses_of(kRosPose, message(0, 0, 0, 0)));
  EXPECT_FALSE(poses_of(kRosPose, message(0, 0, 0, nan)));
  EXPECT_FALSE(poses_of(kRosPose, message(inf, 0, 0, 1)));
  EXPECT_FALSE(poses_of(kRosPose, message(1e300, 1e300, 0, 1))) << "its length is beyond a double";
  EXPECT_FALSE(poses_of(kRosPose, message(0, 0, 0, 1, nan)));
}

TEST(RosPoses, AMessageThatEndsEarlyIsNone) {
  const std::string pose = ros_pose(5, "map", Pose::planar(1, 2, 3));
  for (std::size_t size = 0; size < pose.size(); ++size)
    EXPECT_FALSE(poses_of(kRosPose, std::string_view(pose).substr(0, size))) << size;
}

TEST(RosPoses, TransformsAreSeveral) {
  CdrWriter out;
  out.value(std::uint32_t{2});
  for (const char* child : {"base", "laser"}) {
    out.value(std::int32_t{7}), out.value(std::uint32_t{500'000'000}), out.text("map"), out.text(child);
    for (const double v : {1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0}) out.value(v);
  }
  const auto poses = poses_of(kRosTransforms, out.message());
  ASSERT_TRUE(poses);
  ASSERT_EQ(poses->size(), 2U);
  EXPECT_EQ((*poses)[1].child, "laser");
  EXPECT_EQ((*poses)[1].stamp_s, 7.5);
  CdrWriter none;
  none.value(std::uint32_t{0});
  EXPECT_TRUE(poses_of(kRosTransforms, none.message())->empty());
  CdrWriter lie;
  lie.value(std::uint32_t{1'000'000'000});
  EXPECT_FALSE(poses_of(kRosTransforms, lie.message()));
}

/// The 36 numbers behind the pose.
Eigen::Matrix<double, 6, 6> covariance_in(const std::string& message) {
  CdrReader in(message);
  (void)in.value<std::int32_t>(), (void)in.value<std::uint32_t>(), (void)in.text();
  for (int i = 0; i < 7; ++i) (void)in.value<double>();
  Eigen::Matrix<double, 6, 6> C;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) C(i, j) = in.value<double>();
  EXPECT_TRUE(in.ok());
  return C;
}

/// A small turn about the vehicle's axes is one about the map's: e = R t. So is the covariance of many.
TEST(RosPoses, CovariancesOfRotationsAreAboutTheMapsAxes) {
  Eigen::Matrix<double, 6, 6> root;
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = std::sin(1.7 * i + 0.3);
  const Pose T{{1, 2, 3}, exp_rotation({0.3, -0.7, 1.9})};
  Eigen::Matrix<double, 6, 6> turned = root;
  for (int k = 0; k < 6; ++k) turned.col(k).tail<3>() = T.rotation * Eigen::Vector3d(root.col(k).tail<3>());
  const auto C = covariance_in(ros_pose_with_covariance(0, "map", T, root * root.transpose()));
  EXPECT_LT((C - turned * turned.transpose()).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(RosPoses, AFlatCovarianceIsThatOfXYAndYaw) {
  const Pose T = Pose::planar(1, 2, 0.5);
  PoseCovariance flat = PoseCovariance::Zero(3, 3);
  flat << 4, 1, 0.5, 1, 9, 0.25, 0.5, 0.25, 16;
  const auto C = covariance_in(ros_pose_with_covariance(0, "map", T, flat));
  const int at[] = {0, 1, 5};
  Eigen::Matrix<double, 6, 6> expected = Eigen::Matrix<double, 6, 6>::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) expected(at[i], at[j]) = flat(i, j);
  EXPECT_EQ(C, expected);
  EXPECT_TRUE(covariance_in(ros_pose_with_covariance(0, "map", T, PoseCovariance())).isZero(0.0))
      << "not known";
}

TEST(RosRanges, WhatIsOutsideTheSensorsReachWasNotMeasured) {
  const auto measured = [](float range_m, float least_m, float most_m) {
    const auto range = range_of(test::range_message(2'500'000'000, "B7", range_m, least_m, most_m));
    EXPECT_TRUE(range);
    EXPECT_EQ(range->frame, "B7");
    EXPECT_EQ(range->stamp_s, 2.5);
    return range->measured;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(measured(3.0F, 0.2F, 30.0F));
  EXPECT_TRUE(measured(0.2F, 0.2F, 30.0F) && measured(30.0F, 0.2F, 30.0F)) << "the ends belong to it";
  EXPECT_FALSE(measured(0.1F, 0.2F, 30.0F) || measured(31.0F, 0.2F, 30.0F));
  EXPECT_TRUE(measured(31.0F, 0.0F, 0.0F)) << "a driver that knows no limits";
  for (const float none : {0.0F, -1.0F, nan, inf, -inf}) EXPECT_FALSE(measured(none, 0.0F, 0.0F)) << none;
  const std::string message = test::range_message(0, "B7", 3.0F);
  EXPECT_FALSE(range_of(std::string_view(message).substr(0, message.size() - 1)));
  EXPECT_FALSE(range_of("no message"));
}

/// Every type that a definition names is defined in it (a `ros2msg` schema is complete).
TEST(RosDefinitions, HoldAllTheyStandOn) {
  for (const auto type : {kRosPose, kRosPoseWithCovariance, kRosOdometry}) {
    const std::string text = ros_definition(type);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("=") || line.starts_with("MSG:") || line.empty()) continue;
      std::string name = line.substr(0, line.find_first_of(" ["));
      if (name.find_first_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ") == std::string::npos) continue;  // float64
      name = name.substr(name.rfind('/') + 1);
      EXPECT_THAT(text, HasSubstr("/" + name + "\n")) << line << " of " << type;
    }
    EXPECT_TRUE(is_pose_type(type));
  }
  EXPECT_TRUE(is_pose_type(kRosTransforms));
  EXPECT_FALSE(is_pose_type(kRosRange));
}

}  // namespace ros_messages_test
}  // namespace octant::io
