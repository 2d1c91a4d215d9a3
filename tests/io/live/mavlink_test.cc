// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/live/mavlink.h"

#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "models/physics/pose.h"

namespace octant::io {
namespace mavlink_test {

constexpr double kPi = std::numbers::pi;

std::string hex(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) text += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return text;
}

/// A number at this offset of the payload, which begins after ten bytes.
template <class T>
T field(std::string frame, std::size_t offset) {
  const std::size_t end = 10 + static_cast<unsigned char>(frame[1]);
  frame.resize(end);
  frame.resize(10 + 255, '\0');
  T value;
  std::memcpy(&value, frame.data() + 10 + offset, sizeof(T));
  return value;
}
double real(const std::string& frame, std::size_t offset) { return field<float>(frame, offset); }

Fix some_fix() {
  Fix fix;
  fix.status = FixStatus::kOk;
  fix.time_s = 86399.999;
  fix.vehicle = VehicleId(0);
  fix.T_map_vehicle = Pose::planar(10.0, 20.0, 0.5);
  fix.covariance = Eigen::Vector3d(1e-4, 4e-4, 1e-6).asDiagonal().toDenseMatrix();
  fix.covariance(0, 1) = fix.covariance(1, 0) = 5e-5;
  fix.covariance(1, 2) = fix.covariance(2, 1) = 2e-6;
  fix.arrivals_used = 3;
  fix.arrivals_rejected = 1;
  return fix;
}

MavlinkWriter writer(MavlinkMessage message = MavlinkMessage::kVision, double north_rad = kPi / 2,
                     bool north_known = false) {
  return {message,
          {.latitude_deg = 48.0, .longitude_deg = -17.0, .altitude_m = 150.0, .north_rad = north_rad},
          north_known};
}

TEST(Mavlink, CrcIsThatOfTheStandard) {
  EXPECT_EQ(mavlink_crc("123456789"), 0x6F91);
  EXPECT_EQ(mavlink_crc("6789", mavlink_crc("12345")), 0x6F91);
}

/// The bytes were packed by the struct module of Python. North is along +x, so y, z and yaw change their
/// sign.
TEST(Mavlink, VisionPositionEstimateHasTheseBytes) {
  auto to = writer(MavlinkMessage::kVision, 0.0);
  EXPECT_EQ(hex(to.frame(some_fix())),
            "fd7400000001c5660000185cd71d14000000000020410000a0c10000000000000000000000000000"
            "00bf17b7d13817b751b80000000000000000000000000000000017b7d13900000000000000000000"
            "0000bd37063600000000000000000000000000000000000000000000000000000000000000000000"
            "0000bd378635e1fc");
  // With an exact heading, the zeros after the covariance of y and yaw are left out.
  Fix exact = some_fix();
  exact.covariance(2, 2) = 0.0;
  const std::string second = to.frame(exact);
  EXPECT_EQ(second[1], 32 + 11 * 4);
  EXPECT_EQ(second[4], 1) << "sequence";
}

TEST(Mavlink, OdometryHasTheFrames) {
  Fix fix = some_fix();
  auto to = writer(MavlinkMessage::kOdometry);
  const std::string unknown = to.frame(fix);
  EXPECT_EQ(hex(unknown.substr(7, 3)), "4b0100");  // 331
  EXPECT_EQ(static_cast<unsigned char>(unknown[1]), 233);
  EXPECT_TRUE(std::isnan(real(unknown, 36)) && std::isnan(real(unknown, 144)));
  EXPECT_EQ(hex(unknown.substr(10 + 228, 5)), "140c00024b");  // LOCAL_FRD, BODY_FRD, resets, vision, 75 %
  fix.velocity = VelocityEstimate{};
  fix.velocity->mean << 2.0, 0.25, 0.5, 0.1, 0.2, 0.3;
  fix.velocity->variance << 1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4;
  const std::string frame = writer(MavlinkMessage::kOdometry, kPi / 2, true).frame(fix);
  EXPECT_EQ(frame[10 + 228], 1) << "LOCAL_NED";
  const double yaw = kPi / 2 - 0.5,
               expected[] = {20.0, 10.0, 0.0, std::cos(yaw / 2), 0, 0, std::sin(yaw / 2), 2.0, -0.25, -0.5,
                             0.1,  -0.2, -0.3};
  for (std::size_t i = 0; i < std::size(expected); ++i)
    EXPECT_NEAR(real(frame, 8 + 4 * i), expected[i], 1e-6) << i;
  EXPECT_NEAR(real(frame, 144 + 4 * 6), 2e-4, 1e-9);   // along y
  EXPECT_NEAR(real(frame, 144 + 4 * 20), 6e-4, 1e-9);  // of the yaw rate
}

/// North is at 30 degrees from +x; the vehicle is rolled, pitched and turned in space.
TEST(Mavlink, AnglesInSpaceAreThoseOfAircraft) {
  const double north = kPi / 6, roll = 0.3, pitch = -0.4, yaw = 2.0;
  const auto turn = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  Fix fix = some_fix();
  // In Octant's axes yaw is counter-clockwise and a raised nose turns about -y.
  fix.T_map_vehicle = {{1.0, 2.0, 3.0}, turn(north - yaw, z) * turn(-pitch, y) * turn(roll, x)};
  fix.covariance = PoseCovariance::Identity(6, 6) * 1e-4;
  fix.covariance(3, 3) = 4e-4;
  const std::string frame = writer(MavlinkMessage::kVision, north).frame(fix);
  const double c = std::cos(north), s = std::sin(north),
               expected[] = {c + 2 * s, s - 2 * c, -3.0, roll, pitch, yaw};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(real(frame, 8 + 4 * i), expected[i], 1e-6) << i;
  EXPECT_NEAR(real(frame, 32 + 4 * 15), 4e-4 + 1e-4 * std::pow(std::tan(pitch), 2), 1e-9);
  EXPECT_NEAR(real(frame, 32 + 4 * 18), 1e-4, 1e-9);
  EXPECT_NEAR(real(frame, 32 + 4 * 20), 1e-4 / std::pow(std::cos(pitch), 2), 1e-9);
}

TEST(Mavlink, AnUnknownYawIsNotANumber) {
  Fix fix = some_fix();
  fix.covariance(2, 2) = kUnknownRotationVariance;
  const std::string frame = writer().frame(fix);
  EXPECT_EQ(real(frame, 8), 20.0);
  EXPECT_EQ(real(frame, 24), 0.0) << "pitch";
  EXPECT_TRUE(std::isnan(real(frame, 28))) << "yaw";
  EXPECT_NEAR(real(frame, 32), 4e-4, 1e-9);
  EXPECT_TRUE(std::isnan(real(frame, 32 + 4 * 20)));
  EXPECT_TRUE(std::isnan(real(writer(MavlinkMessage::kOdometry).frame(fix), 20))) << "quaternion";
  EXPECT_EQ(field<std::uint16_t>(writer(MavlinkMessage::kGps).frame(fix), 63), 0);
}

TEST(Mavlink, ResetsAreCountedForEachVehicle) {
  auto to = writer(MavlinkMessage::kOdometry);
  Fix fix = some_fix(), none = some_fix(), other = some_fix();
  none.status = FixStatus::kPoorGeometry;
  other.vehicle = VehicleId(1);
  const auto resets = [&](const Fix& next) { return to.frame(next)[10 + 230]; };
  EXPECT_EQ(to.frame(none), "") << "before the first pose";
  EXPECT_EQ(resets(fix), 0);
  EXPECT_EQ(resets(other), 0);
  EXPECT_EQ(to.frame(none) + to.frame(none), "");
  EXPECT_EQ(resets(other), 0);
  EXPECT_EQ(resets(fix), 1);
  EXPECT_EQ(resets(fix), 1);
  fix.time_s -= 1000.0;
  EXPECT_EQ(resets(fix), 2);
  to.lose_track();
  EXPECT_EQ(resets(fix), 3);
  const std::string last = to.frame(other);
  EXPECT_EQ(last[10 + 230], 1);
  EXPECT_EQ(last[4], 7) << "empty frames have no sequence number";
  EXPECT_EQ(last[5], 2) << "system id of the second vehicle";
}

TEST(Mavlink, GpsInputIsOnTheEarth) {
  Fix fix = some_fix();
  fix.velocity = VelocityEstimate{};
  fix.velocity->mean[0] = 2.0;
  fix.velocity->variance[0] = 0.01;
  const std::string frame = writer(MavlinkMessage::kGps).frame(fix);
  EXPECT_EQ(hex(frame.substr(7, 3)), "e80000");  // 232
  const EarthPlace at = place_on_earth({10, 20, 0}, {48.0, -17.0, 150.0, kPi / 2});
  EXPECT_EQ(field<std::int32_t>(frame, 12), std::lround(1e7 * at.latitude_deg));
  EXPECT_EQ(field<std::int32_t>(frame, 16), std::lround(1e7 * at.longitude_deg));
  EXPECT_EQ(real(frame, 20), 150.0);
  EXPECT_NEAR(real(frame, 32), 2 * std::sin(0.5), 1e-6);
  EXPECT_NEAR(real(frame, 36), 2 * std::cos(0.5), 1e-6);
  EXPECT_NEAR(real(frame, 44), 0.1, 1e-6);
  EXPECT_NEAR(real(frame, 48), std::sqrt(5e-4), 1e-6);
  EXPECT_EQ(field<std::uint16_t>(frame, 56), 2 + 4 + 128);  // no DOP, no height
  EXPECT_EQ(frame[10 + 61], 3);
  EXPECT_EQ(frame[10 + 62], 3);
  EXPECT_EQ(field<std::uint16_t>(frame, 63), 6135);  // 90 degrees - 0.5 rad
  fix.T_map_vehicle = Pose::planar(0, 0, kPi / 2);
  EXPECT_EQ(field<std::uint16_t>(writer(MavlinkMessage::kGps).frame(fix), 63), 36000) << "north";
}

}  // namespace mavlink_test
}  // namespace octant::io
