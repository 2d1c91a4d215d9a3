// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/live/mavlink.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>

namespace octant::io {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// Fields of the wire, little-endian; real numbers in single precision.
template <std::unsigned_integral T>
void append(std::string& bytes, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes += static_cast<char>((value >> (8 * i)) & 0xFF);
}
void append(std::string& bytes, double value) {
  append(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}
template <int N>
void append(std::string& bytes, const Eigen::Matrix<double, N, 1>& numbers) {
  for (const double x : numbers) append(bytes, x);
}
/// The upper triangle, row by row.
void append(std::string& bytes, const Eigen::Matrix<double, 6, 6>& C) {
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) append(bytes, C(i, j));
}

template <class... Fields>
std::string packed(const Fields&... fields) {
  std::string bytes;
  (append(bytes, fields), ...);
  return bytes;
}

/// Pose with x north, y east, z down of a vehicle with x forward, y right, z down.
struct NedPose {
  Eigen::Vector3d position_m, roll_pitch_yaw_rad;
  Eigen::Quaterniond rotation;
  Eigen::Matrix<double, 6, 6> covariance;  ///< x, y, z, roll, pitch, yaw
};

/// Rotation from the map to north, east and down.
Eigen::Matrix3d ned_of_map(double north_rad) {
  const double c = std::cos(north_rad), s = std::sin(north_rad);
  Eigen::Matrix3d turn;
  turn << c, s, 0, s, -c, 0, 0, 0, -1;
  return turn;
}

NedPose ned_pose(const Fix& fix, double north_rad) {
  const Eigen::Matrix3d to_ned = ned_of_map(north_rad), R_map = fix.T_map_vehicle.rotation.toRotationMatrix(),
                        to_frd = Eigen::Vector3d(1, -1, -1).asDiagonal(), R = to_ned * R_map * to_frd;
  NedPose pose{
      .position_m = to_ned * fix.T_map_vehicle.translation_m,
      .roll_pitch_yaw_rad = {std::atan2(R(2, 1), R(2, 2)), std::asin(std::clamp(0.0 - R(2, 0), -1.0, 1.0)),
                             std::atan2(R(1, 0), R(0, 0))},
      .rotation = Eigen::Quaterniond(R),
      .covariance = {}};
  // Derivatives of roll, pitch and yaw by small rotations about the axes of the vehicle.
  const double roll = pose.roll_pitch_yaw_rad[0],
               cos_pitch =
                   std::max(std::hypot(R(0, 0), R(1, 0)), std::numeric_limits<float>::epsilon() * 1.0),
               tan_pitch = -R(2, 0) / cos_pitch, c = std::cos(roll), s = std::sin(roll);
  Eigen::Matrix3d angles;
  angles << 1, s * tan_pitch, c * tan_pitch, 0, c, -s, 0, s / cos_pitch, c / cos_pitch;
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J.topLeftCorner<3, 3>() = to_ned;
  J.bottomRightCorner<3, 3>() = angles * to_frd * R_map.transpose();
  pose.covariance = J * covariance_in_map(fix.covariance, fix.T_map_vehicle) * J.transpose();
  for (int i = 0; i < 3; ++i) {
    constexpr double kRounding = 1e-9;
    if (pose.covariance(3 + i, 3 + i) < kUnknownRotationVariance * (1 - kRounding)) continue;
    pose.roll_pitch_yaw_rad[i] = kNotANumber;
    pose.covariance.row(3 + i).setConstant(kNotANumber);
    pose.covariance.col(3 + i).setConstant(kNotANumber);
  }
  if (std::isnan(pose.roll_pitch_yaw_rad[2])) pose.rotation.coeffs().setConstant(kNotANumber);
  return pose;
}

std::uint64_t time_usec(double time_s) {
  constexpr double kLargest_s = 9e12;
  return static_cast<std::uint64_t>(std::round(1e6 * std::clamp(time_s, 0.0, kLargest_s)));
}

std::string vision_of(const Fix& fix, const NedPose& pose, std::uint8_t resets) {
  return packed(time_usec(fix.time_s), pose.position_m, pose.roll_pitch_yaw_rad, pose.covariance, resets);
}

std::string odometry_of(const Fix& fix, const NedPose& pose, std::uint8_t resets, bool north_known) {
  constexpr std::uint8_t kLocalNed = 1, kEstimatorVision = 2, kBodyFrd = 12, kLocalFrd = 20;
  Velocity velocity = Velocity::Constant(kNotANumber), variance = velocity;
  if (fix.velocity) {
    velocity << 1, -1, -1, 1, -1, -1;
    velocity.array() *= fix.velocity->mean.array();
    variance = fix.velocity->variance;
  }
  const Eigen::Quaterniond& q = pose.rotation;
  // Quality from 1 to 100: the percentage of the arrivals that agree with the pose.
  const int arrivals = std::max(fix.arrivals_used + fix.arrivals_rejected, 1),
            quality = std::max(1, 100 * fix.arrivals_used / arrivals);
  return packed(time_usec(fix.time_s), pose.position_m, q.w(), q.x(), q.y(), q.z(), velocity, pose.covariance,
                Eigen::Matrix<double, 6, 6>(variance.asDiagonal()), north_known ? kLocalNed : kLocalFrd,
                kBodyFrd, resets, kEstimatorVision, static_cast<std::uint8_t>(quality));
}

std::string gps_of(const Fix& fix, const NedPose& pose, const EarthOrigin& origin) {
  constexpr unsigned kNoDop = 2 + 4, kNoVelocity = 8 + 16 + 32, kNoVertical = 128;  // fields to be ignored
  constexpr double kDopUnknown = 65535.0;
  constexpr std::uint8_t kFirst = 0, kGnssFix3d = 3;
  constexpr std::uint16_t kWeekUnknown = 0;
  constexpr std::uint32_t kTimeOfWeekUnknown = 0;
  const EarthPlace at = place_on_earth(fix.T_map_vehicle.translation_m, origin);
  const auto scaled = [](double degrees) { return static_cast<std::uint32_t>(std::lround(1e7 * degrees)); };
  const VelocityEstimate velocity = fix.velocity.value_or(VelocityEstimate{});
  const Eigen::Vector3d variance = pose.covariance.diagonal().head<3>().cwiseMax(0.0),
                        velocity_ned = ned_of_map(origin.north_rad) *
                                       (fix.T_map_vehicle.rotation * velocity.mean.head<3>());
  const unsigned ignored =
      kNoDop + (fix.velocity ? 0 : kNoVelocity) + (fix.covariance.rows() == 6 ? 0 : kNoVertical);
  // Hundredths of a degree from 1 to 36000, which is north; 0 is unknown.
  const double yaw_deg = pose.roll_pitch_yaw_rad[2] * 180 / std::numbers::pi;
  const long yaw = std::isnan(yaw_deg) ? 0 : (std::lround(100 * yaw_deg) + 71999) % 36000 + 1;
  return packed(time_usec(fix.time_s), kTimeOfWeekUnknown, scaled(at.latitude_deg), scaled(at.longitude_deg),
                origin.altitude_m - pose.position_m.z(), kDopUnknown, kDopUnknown, velocity_ned,
                std::sqrt(velocity.variance.head<3>().maxCoeff()), std::sqrt(variance[0] + variance[1]),
                std::sqrt(variance[2]), static_cast<std::uint16_t>(ignored), kWeekUnknown, kFirst, kGnssFix3d,
                static_cast<std::uint8_t>(std::clamp(fix.arrivals_used, 0, 254)),
                static_cast<std::uint16_t>(yaw));
}

}  // namespace

std::uint16_t mavlink_crc(std::string_view bytes, std::uint16_t crc) {
  for (const char byte : bytes) {
    unsigned x = (static_cast<unsigned char>(byte) ^ crc) & 0xFFU;
    x = (x ^ (x << 4)) & 0xFFU;
    crc = static_cast<std::uint16_t>((crc >> 8) ^ (x << 8) ^ (x << 3) ^ (x >> 4));
  }
  return crc;
}

std::uint8_t MavlinkWriter::count_resets(const Fix& fix) {
  const std::size_t vehicle = fix.vehicle.valid() ? fix.vehicle.index() : 0;
  if (tracks_.size() <= vehicle) tracks_.resize(vehicle + 1);
  Track& track = tracks_[vehicle];
  if (!fix.ok()) {
    track.lost = track.seen;
  } else {
    if (track.lost || (track.seen && fix.time_s < track.time_s)) ++track.resets;
    track = {.seen = true, .lost = false, .time_s = fix.time_s, .resets = track.resets};
  }
  return track.resets;
}

void MavlinkWriter::lose_track() {
  for (Track& track : tracks_) track.lost = track.seen;
}

std::string MavlinkWriter::frame(const Fix& fix) {
  const std::uint8_t resets = count_resets(fix);
  if (!fix.ok()) return {};
  const bool vision = message_ == MavlinkMessage::kVision, gps = message_ == MavlinkMessage::kGps;
  const std::uint16_t id = vision ? 102 : gps ? 232 : 331;
  const unsigned char crc_extra = vision ? 158 : gps ? 151 : 91;
  const NedPose pose = ned_pose(fix, origin_.north_rad);
  std::string payload = vision ? vision_of(fix, pose, resets)
                        : gps  ? gps_of(fix, pose, origin_)
                               : odometry_of(fix, pose, resets, north_known_);
  // Zeros at the end of the payload are left out, except for its first byte.
  payload.resize(std::max<std::size_t>(payload.find_last_not_of('\0') + 1, 1));
  constexpr std::uint8_t kMagic = 0xFD, kNoFlags = 0, kVisualOdometry = 197, kThirdByteOfId = 0;
  const std::size_t vehicle = fix.vehicle.valid() ? fix.vehicle.index() : 0;
  const std::string body =
      packed(static_cast<std::uint8_t>(payload.size()), kNoFlags, kNoFlags, sequence_++,
             static_cast<std::uint8_t>(vehicle % 255 + 1), kVisualOdometry, id, kThirdByteOfId) +
      payload;
  return packed(kMagic) + body + packed(mavlink_crc(body + static_cast<char>(crc_extra)));
}

}  // namespace octant::io
