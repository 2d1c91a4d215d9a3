// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "io/text/text.h"
#include "io/tof/run_parts.h"

namespace octant::io {
namespace {

using Out = std::back_insert_iterator<std::string>;

bool several_vehicles(const NameTable& names) { return names.vehicles.size() > 1; }

template <class Rows, class Test>
bool any(const Rows& rows, Test test) {
  return std::ranges::any_of(rows, test);
}

std::vector<std::string> fields_of(const std::vector<std::string>& names) {
  std::vector<std::string> fields;
  fields.reserve(names.size());
  for (const std::string& name : names) fields.push_back(csv_field(name));
  return fields;
}

}  // namespace

std::string tof_to_csv(const MeasurementLog& log, const NameTable& names) {
  const auto& rows = log.arrivals;
  const bool epoch = any(rows, [](const Arrival& a) { return a.epoch != kNoEpoch; });
  const bool vehicle = several_vehicles(names);
  const bool receiver = names.receivers.size() > 1;
  const bool amplitude = any(rows, [](const Arrival& a) { return std::isfinite(a.amplitude_v); });
  const bool temperature = any(rows, [](const Arrival& a) { return std::isfinite(a.temperature_degC); });
  const bool received = any(rows, [](const Arrival& a) { return std::isfinite(a.received_after_s); });
  const auto beacons = fields_of(names.beacons), vehicles = fields_of(names.vehicles);
  std::vector<std::string> receivers;
  for (const auto& r : names.receivers) receivers.push_back(csv_field(r.name));

  std::string text = "time_s,beacon,tof_s";
  if (epoch) text += ",epoch";
  if (vehicle) text += ",vehicle";
  if (receiver) text += ",receiver";
  if (amplitude) text += ",amplitude_v";
  if (temperature) text += ",temperature_degC";
  if (received) text += ",received_s";
  text += '\n';
  text.reserve(text.size() + rows.size() * 64);
  const Out out = std::back_inserter(text);
  for (const Arrival& a : rows) {
    fmt::format_to(out, "{},{},{}", a.time_s, beacons[a.beacon.index()], a.tof_s);
    if (epoch) fmt::format_to(out, ",{}", a.epoch);
    if (vehicle) fmt::format_to(out, ",{}", vehicles[a.vehicle.index()]);
    if (receiver) fmt::format_to(out, ",{}", receivers[a.receiver.index()]);
    if (amplitude) fmt::format_to(out, ",{}", number_field(a.amplitude_v));
    if (temperature) fmt::format_to(out, ",{}", number_field(a.temperature_degC));
    if (received) fmt::format_to(out, ",{}", number_field(a.time_s + a.received_after_s));
    text += '\n';
  }
  return text;
}

std::string bearings_to_csv(const MeasurementLog& log, const NameTable& names) {
  const bool epoch = any(log.bearings, [](const Bearing& b) { return b.epoch != kNoEpoch; });
  const bool vehicle = several_vehicles(names);
  std::string text = "time_s,reflector,bearing_rad";
  if (epoch) text += ",epoch";
  if (vehicle) text += ",vehicle";
  text += '\n';
  const Out out = std::back_inserter(text);
  for (const Bearing& b : log.bearings) {
    fmt::format_to(out, "{},{},{}", b.time_s,
                   b.reflector.valid() ? csv_field(names.beacons[b.reflector.index()]) : "", b.bearing_rad);
    if (epoch) fmt::format_to(out, ",{}", b.epoch);
    if (vehicle) fmt::format_to(out, ",{}", csv_field(names.vehicles[b.vehicle.index()]));
    text += '\n';
  }
  return text;
}

std::string odometry_to_csv(const MeasurementLog& log, const NameTable& names) {
  const bool vehicle = several_vehicles(names);
  const bool in_space = any(log.odometry, [](const auto& o) { return !o.is_planar(); });
  std::string text = in_space ? "time_s,dx_m,dy_m,dz_m,qx,qy,qz,qw" : "time_s,dx_m,dy_m,dheading_rad";
  text += vehicle ? ",vehicle\n" : "\n";
  const Out out = std::back_inserter(text);
  for (const OdometryStep& o : log.odometry) {
    const Eigen::Quaterniond q = o.pose().rotation;
    if (in_space)
      fmt::format_to(out, "{},{},{},{},{},{},{},{}", o.time_s, o.dx_m, o.dy_m, o.dz_m, q.x(), q.y(), q.z(),
                     q.w());
    else
      fmt::format_to(out, "{},{},{},{}", o.time_s, o.dx_m, o.dy_m, o.dheading_rad);
    if (vehicle) fmt::format_to(out, ",{}", csv_field(names.vehicles[o.vehicle.index()]));
    text += '\n';
  }
  return text;
}

std::string scans_to_csv(const MeasurementLog& log) {
  std::size_t beams = 0;
  for (const Scan& scan : log.scans) beams = std::max(beams, scan.range_m.size());
  std::string text = "time_s,angle_min_rad,angle_increment_rad";
  const Out out = std::back_inserter(text);
  for (std::size_t k = 0; k < beams; ++k) fmt::format_to(out, ",range{}_m", k);
  text += '\n';
  for (const Scan& scan : log.scans) {
    fmt::format_to(out, "{},{},{}", scan.time_s, scan.angle_min_rad, scan.angle_increment_rad);
    for (std::size_t k = 0; k < beams; ++k) {
      fmt::format_to(out, ",{}", k < scan.range_m.size() ? number_field(scan.range_m[k]) : "");
    }
    text += '\n';
  }
  return text;
}

}  // namespace octant::io
