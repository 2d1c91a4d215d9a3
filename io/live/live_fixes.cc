// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/live/live_fixes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>

namespace octant::io {
namespace {

std::string vehicle_name(VehicleId vehicle, const NameTable& names) {
  return vehicle.valid() && vehicle.index() < names.vehicles.size() ? names.vehicles[vehicle.index()] : "";
}

/// Numbers, separated by commas. Most numbers of a covariance in the plane are zero.
template <class Numbers>
std::string listed(const Numbers& numbers) {
  std::string text;
  for (const double x : numbers.reshaped()) {
    if (!text.empty()) text += ',';
    if (x == 0.0) {
      text += '0';
    } else {
      fmt::format_to(std::back_inserter(text), "{:.6g}", x);
    }
  }
  return text;
}

/// In quotes, escaped.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

double sigma_of_fix(const PoseCovariance& C, Eigen::Index i) { return std::sqrt(std::max(C(i, i), 0.0)); }

Eigen::Index heading_row(const PoseCovariance& C) { return C.rows() == 6 ? 5 : 2; }

std::string with_checksum(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  return fmt::format("${}*{:02X}\r\n", body, sum);
}

std::string time_of_day(double time_s) {
  constexpr double kDay_s = 86400.0;
  // Truncated to a hundredth, so that 59.999 does not become 60.
  double s = std::floor(100 * (time_s - kDay_s * std::floor(time_s / kDay_s))) / 100;
  s = std::min(s, kDay_s - 0.01);
  const int minutes = static_cast<int>(s / 60);
  return fmt::format("{:02d}{:02d}{:05.2f}", minutes / 60, minutes % 60, s - 60.0 * minutes);
}

/// ddmm.mmmmmmm of an angle that is not negative; a tenth of a millimetre is 5e-8 minutes.
std::string degrees_minutes(double angle_deg, int digits) {
  const double all = std::round(angle_deg * 60e7) / 1e7;  // minutes
  const int degrees = static_cast<int>(all / 60);
  return fmt::format("{:0{}d}{:010.7f}", degrees, digits, all - 60.0 * degrees);
}

/// Angle in degrees, in [0, full_turn_deg).
double compass_deg(double angle_rad, double full_turn_deg) {
  const double angle_deg = angle_rad * 180 / std::numbers::pi,
               in_turn_deg = angle_deg - full_turn_deg * std::floor(angle_deg / full_turn_deg);
  return in_turn_deg >= full_turn_deg - 0.0005 ? 0.0 : in_turn_deg;
}

bool of_beacon(WatchKind kind) {
  return kind != WatchKind::kReceiverLate && kind != WatchKind::kReceiverMoved;
}

std::string subject_of(const WatchAlarm& alarm, const NameTable& names) {
  if (of_beacon(alarm.kind))
    return alarm.beacon.valid() && alarm.beacon.index() < names.beacons.size()
               ? names.beacons[alarm.beacon.index()]
               : "";
  if (!alarm.receiver.valid() || alarm.receiver.index() >= names.receivers.size()) return "";
  const auto& receiver = names.receivers[alarm.receiver.index()];
  return vehicle_name(receiver.vehicle, names) + "/" + receiver.name;
}

}  // namespace

std::string fix_as_json(const Fix& fix, const NameTable& names) {
  std::string line = fmt::format("{{\"type\":\"fix\",\"time_s\":{:.6f},\"vehicle\":{},\"status\":\"{}\"",
                                 fix.time_s, quoted(vehicle_name(fix.vehicle, names)), to_string(fix.status));
  if (fix.epoch != kNoEpoch) line += fmt::format(",\"epoch\":{}", fix.epoch);
  if (fix.ok()) {
    const Eigen::Vector3d& p = fix.T_map_vehicle.translation_m;
    const Eigen::Quaterniond& q = fix.T_map_vehicle.rotation;
    line += fmt::format(
        ",\"x_m\":{:.6f},\"y_m\":{:.6f},\"z_m\":{:.6f},\"heading_rad\":{:.6f},\"quaternion_xyzw\":[{:.7f},{:."
        "7f},{:.7f},"
        "{:.7f}],\"sigma_x_m\":{:.3g},\"sigma_y_m\":{:.3g},\"sigma_heading_rad\":{:.3g}",
        p.x(), p.y(), p.z(), fix.T_map_vehicle.heading_rad(), q.x(), q.y(), q.z(), q.w(),
        sigma_of_fix(fix.covariance, 0), sigma_of_fix(fix.covariance, 1),
        std::min(sigma_of_fix(fix.covariance, heading_row(fix.covariance)), std::numbers::pi));
    if (fix.protection_level_m > 0)
      line += fmt::format(",\"protection_level_m\":{:.4g}", fix.protection_level_m);
    line += fmt::format(",\"covariance\":[{}]", listed(covariance_in_map(fix.covariance, fix.T_map_vehicle)));
    if (fix.velocity) {
      const Velocity &v = fix.velocity->mean, sigma = fix.velocity->variance.cwiseSqrt();
      line += fmt::format(
          ",\"velocity_mps\":[{}],\"turn_rate_radps\":[{}],\"sigma_velocity_mps\":[{}],"
          "\"sigma_turn_rate_radps\":[{}]",
          listed(v.head<3>()), listed(v.tail<3>()), listed(sigma.head<3>()), listed(sigma.tail<3>()));
    }
  }
  return line + fmt::format(
                    ",\"arrivals_used\":{},\"arrivals_rejected\":{},\"integrity\":\"{}\",\"integrity_"
                    "reason\":\"{}\"}}\n",
                    fix.arrivals_used, fix.arrivals_rejected, to_string(integrity(fix)),
                    integrity_reason(fix));
}

std::string fix_as_ros(const Fix& fix, const NameTable& names) {
  if (!fix.ok()) return "";
  const std::string child =
      names.vehicles.size() > 1 ? vehicle_name(fix.vehicle, names) + "/base_link" : "base_link";
  const double sec = std::floor(fix.time_s);
  const Eigen::Vector3d& p = fix.T_map_vehicle.translation_m;
  const Eigen::Quaterniond& q = fix.T_map_vehicle.rotation;
  std::string line = fmt::format(
      "{{\"header\":{{\"stamp\":{{\"sec\":{},\"nanosec\":{}}},\"frame_id\":\"map\"}},\"child_frame_id\":{},"
      "\"pose\":{{\"pose\":{{\"position\":{{\"x\":{:.6f},\"y\":{:.6f},\"z\":{:.6f}}},"
      "\"orientation\":{{\"x\":{:.9f},\"y\":{:.9f},\"z\":{:.9f},\"w\":{:.9f}}}}},\"covariance\":[",
      static_cast<std::int64_t>(std::clamp(sec, -9e15, 9e15)),
      static_cast<std::int64_t>((fix.time_s - sec) * 1e9), quoted(child), p.x(), p.y(), p.z(), q.x(), q.y(),
      q.z(), q.w());
  line += listed(covariance_in_map(fix.covariance, fix.T_map_vehicle));
  const VelocityEstimate velocity = fix.velocity.value_or(VelocityEstimate{});
  Eigen::Matrix<double, 6, 6> twist_covariance = velocity.variance.asDiagonal();
  if (!fix.velocity) twist_covariance(0, 0) = -1.0;
  const Velocity& v = velocity.mean;
  return line + fmt::format(
                    "]}},\"twist\":{{\"twist\":{{\"linear\":{{\"x\":{:.6g},\"y\":{:.6g},\"z\":{:.6g}}},"
                    "\"angular\":{{\"x\":{:.6g},\"y\":{:.6g},\"z\":{:.6g}}}}},\"covariance\":[{}]}}}}\n",
                    v[0], v[1], v[2], v[3], v[4], v[5], listed(twist_covariance));
}

std::string fix_as_nmea(const Fix& fix, const EarthOrigin& origin) {
  const std::string time = time_of_day(fix.time_s);
  if (!fix.ok()) return with_checksum(fmt::format("GPGGA,{},,,,,0,00,,,M,,M,,", time));
  const EarthPlace at = place_on_earth(fix.T_map_vehicle.translation_m, origin);
  std::string text = with_checksum(fmt::format(
      "GPGGA,{},{},{},{},{},1,{:02d},1.0,{:.3f},M,0.0,M,,", time,
      degrees_minutes(std::abs(at.latitude_deg), 2), at.latitude_deg < 0 ? 'S' : 'N',
      degrees_minutes(std::abs(at.longitude_deg), 3), at.longitude_deg < 0 ? 'W' : 'E',
      std::clamp(fix.arrivals_used, 0, 99), origin.altitude_m + fix.T_map_vehicle.translation_m.z()));
  // Along north and east.
  const Eigen::Vector2d north(std::cos(origin.north_rad), std::sin(origin.north_rad)),
      east(north.y(), -north.x());
  Eigen::Matrix2d to_earth;
  to_earth << north.transpose(), east.transpose();
  const Eigen::Matrix2d C = to_earth * fix.covariance.topLeftCorner<2, 2>() * to_earth.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(C);
  const Eigen::Vector2d major = axes.eigenvectors().col(1);
  const bool spatial = fix.covariance.rows() == 6;
  text += with_checksum(fmt::format(
      "GPGST,{},,{:.4f},{:.4f},{:.1f},{:.4f},{:.4f},{:.4f}", time,
      std::sqrt(std::max(axes.eigenvalues()[1], 0.0)), std::sqrt(std::max(axes.eigenvalues()[0], 0.0)),
      compass_deg(std::atan(major.y() / major.x()), 180.0), std::sqrt(std::max(C(0, 0), 0.0)),
      std::sqrt(std::max(C(1, 1), 0.0)), spatial ? sigma_of_fix(fix.covariance, 2) : 0.0));
  const Eigen::Index h = heading_row(fix.covariance);
  if (fix.covariance(h, h) < kUnknownRotationVariance) {
    text += with_checksum(fmt::format(
        "GPHDT,{:.3f},T", compass_deg(origin.north_rad - fix.T_map_vehicle.heading_rad(), 360.0)));
  }
  if (fix.velocity) {
    const Eigen::Vector2d v =
        to_earth * (fix.T_map_vehicle.rotation * fix.velocity->mean.head<3>()).head<2>();
    text += with_checksum(fmt::format("GPVTG,{:.3f},T,,M,{:.3f},N,{:.3f},K,A",
                                      compass_deg(std::atan2(v.y(), v.x()), 360.0), v.norm() * 3600 / 1852,
                                      v.norm() * 3.6));
  }
  return text;
}

std::string alarm_as_json(const WatchAlarm& alarm, const NameTable& names) {
  std::string line = fmt::format(
      "{{\"type\":\"alarm\",\"time_s\":{:.6f},\"kind\":\"{}\",\"{}\":{}", alarm.time_s, to_string(alarm.kind),
      of_beacon(alarm.kind) ? "beacon" : "receiver", quoted(subject_of(alarm, names)));
  if (alarm.kind == WatchKind::kBeaconMoved || alarm.kind == WatchKind::kReceiverMoved)
    line += fmt::format(",\"axis\":\"{}\",\"shift_m\":[{:.4g},{:.4g},{:.4g}]",
                        "xyz"[std::clamp(alarm.axis, 0, 2)], alarm.shift_m.x(), alarm.shift_m.y(),
                        alarm.shift_m.z());
  return line + fmt::format(",\"size_m\":{:.4g},\"sigma_m\":{:.3g},\"since_s\":{:.6f}}}\n", alarm.size_m,
                            alarm.sigma_m, alarm.since_s);
}

std::string alarm_as_nmea(const WatchAlarm& alarm, const NameTable& names) {
  std::string subject;
  for (const char c : subject_of(alarm, names))
    subject += c > ' ' && c <= '~' && c != '*' && c != ',' && c != '$' ? c : '_';
  return with_checksum(fmt::format("POCT,ALARM,{},{},{:.4f}", to_string(alarm.kind), subject, alarm.size_m));
}

}  // namespace octant::io
