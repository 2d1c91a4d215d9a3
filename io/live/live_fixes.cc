// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/live/live_fixes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/bag/ros_messages.h"

namespace octant::io {
namespace {

std::string vehicle_name(VehicleId vehicle, const NameTable& names) {
  return vehicle.valid() && vehicle.index() < names.vehicles.size() ? names.vehicles[vehicle.index()] : "";
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

const char* kind_name(WatchKind kind) {
  switch (kind) {
    case WatchKind::kBeaconLate: return "beacon_late";
    case WatchKind::kBeaconMoved: return "beacon_moved";
    case WatchKind::kBeaconSilent: return "beacon_silent";
    case WatchKind::kReceiverLate: return "receiver_late";
    case WatchKind::kReceiverMoved: return "receiver_moved";
  }
  return "beacon_late";
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
  const Eigen::Matrix<double, 6, 6> C = covariance_in_map(fix.covariance, fix.T_map_vehicle);
  std::string line = fmt::format(
      "{{\"header\":{{\"stamp\":{{\"sec\":{},\"nanosec\":{}}},\"frame_id\":\"map\"}},\"child_frame_id\":{},"
      "\"pose\":{{\"pose\":{{\"position\":{{\"x\":{:.6f},\"y\":{:.6f},\"z\":{:.6f}}},"
      "\"orientation\":{{\"x\":{:.9f},\"y\":{:.9f},\"z\":{:.9f},\"w\":{:.9f}}}}},\"covariance\":[",
      static_cast<std::int64_t>(std::clamp(sec, -9e15, 9e15)),
      static_cast<std::int64_t>((fix.time_s - sec) * 1e9), quoted(child), p.x(), p.y(), p.z(), q.x(), q.y(),
      q.z(), q.w());
  for (int i = 0; i < 36; ++i) line += fmt::format("{}{:.6g}", i == 0 ? "" : ",", C(i / 6, i % 6));
  line +=
      "]},\"twist\":{\"twist\":{\"linear\":{\"x\":0,\"y\":0,\"z\":0},\"angular\":{\"x\":0,\"y\":0,\"z\":0}},"
      "\"covariance\":[-1";
  for (int i = 1; i < 36; ++i) line += ",0";
  return line + "]}}\n";
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
  const Eigen::Matrix2d C = fix.covariance.topLeftCorner<2, 2>();
  const bool spatial = fix.covariance.rows() == 6;
  text += with_checksum(fmt::format(
      "GPGST,{},,,,,{:.4f},{:.4f},{:.4f}", time, std::sqrt(std::max(north.dot(C * north), 0.0)),
      std::sqrt(std::max(east.dot(C * east), 0.0)), spatial ? sigma_of_fix(fix.covariance, 2) : 0.0));
  const Eigen::Index h = heading_row(fix.covariance);
  if (fix.covariance(h, h) < kUnknownRotationVariance) {
    // Compass heading: clockwise from north.
    double heading_deg = (origin.north_rad - fix.T_map_vehicle.heading_rad()) * 180 / std::numbers::pi;
    heading_deg -= 360 * std::floor(heading_deg / 360);
    text += with_checksum(fmt::format("GPHDT,{:.3f},T", heading_deg >= 359.9995 ? 0.0 : heading_deg));
  }
  return text;
}

std::string alarm_as_json(const WatchAlarm& alarm, const NameTable& names) {
  std::string line = fmt::format(
      "{{\"type\":\"alarm\",\"time_s\":{:.6f},\"kind\":\"{}\",\"{}\":{}", alarm.time_s, kind_name(alarm.kind),
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
  return with_checksum(fmt::format("POCT,ALARM,{},{},{:.4f}", kind_name(alarm.kind), subject, alarm.size_m));
}

}  // namespace octant::io
