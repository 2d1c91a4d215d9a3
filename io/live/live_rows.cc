// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/live/live_rows.h"

#include <cmath>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/text/text.h"
#include "io/tof/run_parts.h"
#include "io/tof/tof_rows.h"
#include "models/physics/unit_rotation.h"
#include "models/support/largest.h"

namespace octant::io {
namespace {

using LiveObject = nlohmann::json;

tl::unexpected<Error> bad_line(std::string found, std::string expected = "") {
  return fail({.code = Errc::kBadInput, .found = std::move(found), .expected = std::move(expected)});
}

/// Number of a member; NaN if it is not a finite number, the fallback if the member is missing.
double live_number(const LiveObject& object, const char* key, double absent) {
  const auto at = object.find(key);
  if (at == object.end() || at->is_null()) return absent;
  return at->is_number() ? at->get<double>() : std::nan("");
}

/// Text of a member, empty if it is missing; no value if it is not a text (numbers count as names).
std::optional<std::string> live_name(const LiveObject& object, const char* key) {
  const auto at = object.find(key);
  if (at == object.end() || at->is_null()) return "";
  if (at->is_string()) return at->get<std::string>();
  if (at->is_number_integer()) return at->dump();
  return std::nullopt;
}

/// Truncated, with characters that do not print replaced: the text may be anything.
std::string printable_name(std::string_view name) {
  std::string text;
  for (const char c : name.substr(0, 40)) text += c >= ' ' && c <= '~' ? c : '?';
  return "'" + text + (name.size() > 40 ? "...'" : "'");
}

bool is_odometry(const LiveObject& object) {
  return object.contains("dx_m") || object.contains("dheading_rad") || object.contains("qw");
}

/// In the plane, or with dz_m and a quaternion in place of the heading in space.
Result<LiveRow> odometry_row(const LiveObject& object, double time_s, VehicleId vehicle) {
  OdometryStep step{.time_s = time_s,
                    .dx_m = live_number(object, "dx_m", 0.0),
                    .dy_m = live_number(object, "dy_m", 0.0),
                    .dheading_rad = live_number(object, "dheading_rad", 0.0),
                    .vehicle = vehicle,
                    .dz_m = live_number(object, "dz_m", 0.0)};
  if (!step.is_finite()) return bad_line("dx_m, dy_m, dz_m or dheading_rad is no number");
  for (const double metres : {step.dx_m, step.dy_m, step.dz_m})
    if (std::abs(metres) > kLargestLength_m) return bad_line("dx_m, dy_m or dz_m is impossibly large");
  if (!object.contains("qw")) return LiveRow{step};
  if (object.contains("dheading_rad")) return bad_line("both a quaternion and dheading_rad", "one of them");
  const auto part = [&](const char* key) { return live_number(object, key, std::nan("")); };
  const auto rotation = unit_rotation(part("qx"), part("qy"), part("qz"), part("qw"));
  if (!rotation) return bad_line("no rotation", "numbers qx, qy, qz, qw of length 1 (0, 0, 0, 1: no turn)");
  step.set_pose({{step.dx_m, step.dy_m, step.dz_m}, *rotation});
  return LiveRow{step};
}

/// In the plane, or with odometry_z_m and a quaternion in place of the heading in space.
Result<LiveRow> odometry_pose_row(const LiveObject& object, double time_s, VehicleId vehicle) {
  const Eigen::Vector3d p(live_number(object, "odometry_x_m", std::nan("")),
                          live_number(object, "odometry_y_m", std::nan("")),
                          live_number(object, "odometry_z_m", 0.0));
  if (!p.allFinite() || p.cwiseAbs().maxCoeff() > kLargestLength_m)
    return bad_line("odometry_x_m, odometry_y_m or odometry_z_m is missing, no number or impossibly large");
  if (!object.contains("qw")) {
    const double heading_rad = live_number(object, "odometry_heading_rad", std::nan(""));
    if (!std::isfinite(heading_rad)) return bad_line("odometry_heading_rad is missing or no number");
    Pose T = Pose::planar(p.x(), p.y(), heading_rad);
    T.translation_m = p;
    return LiveRow{OdometryPose{time_s, T, vehicle}};
  }
  const auto part = [&](const char* key) { return live_number(object, key, std::nan("")); };
  const auto rotation = unit_rotation(part("qx"), part("qy"), part("qz"), part("qw"));
  if (!rotation) return bad_line("no rotation", "numbers qx, qy, qz, qw of length 1 (0, 0, 0, 1: no turn)");
  return LiveRow{OdometryPose{time_s, {p, *rotation}, vehicle}};
}

}  // namespace

struct LiveReader::Names {
  explicit Names(NameTable from) : table(std::move(from)), lookup(table) {}
  NameTable table;
  NameLookup lookup;
};

LiveReader::LiveReader(NameTable names, double constant_speed_mps)
    : names_(std::make_unique<Names>(std::move(names))), constant_speed_mps_(constant_speed_mps) {}
LiveReader::~LiveReader() = default;
LiveReader::LiveReader(LiveReader&&) noexcept = default;
LiveReader& LiveReader::operator=(LiveReader&&) noexcept = default;

Result<LiveRow> LiveReader::row(std::string_view line) const {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos || line[begin] == '#') return LiveRow{};
  const LiveObject object = LiveObject::parse(line.begin(), line.end(), nullptr, false);
  if (object.is_discarded()) return bad_line("not JSON", "one JSON object a line");
  if (!object.is_object()) return bad_line("not a JSON object", "one JSON object a line");
  if (object.contains("flush")) return LiveRow{LiveFlush{}};

  const double time_s = live_number(object, "time_s", std::nan(""));
  if (!std::isfinite(time_s)) return bad_line("time_s is missing or no number");
  const auto vehicle_name = live_name(object, "vehicle");
  if (!vehicle_name) return bad_line("vehicle is no name");
  const VehicleId vehicle = names_->lookup.vehicle(*vehicle_name);
  if (!vehicle.valid())
    return bad_line(vehicle_name->empty() ? "vehicle is missing, and there are several"
                                          : "unknown vehicle " + printable_name(*vehicle_name));

  if (object.contains("odometry_x_m")) return odometry_pose_row(object, time_s, vehicle);
  if (is_odometry(object)) return odometry_row(object, time_s, vehicle);

  Arrival a;
  a.time_s = time_s;
  a.vehicle = vehicle;
  const auto beacon = live_name(object, "beacon"), receiver = live_name(object, "receiver");
  if (!beacon || beacon->empty())
    return bad_line("neither an arrival nor odometry", "beacon and tof_s, or dx_m, dy_m, dheading_rad");
  a.beacon = names_->lookup.beacon(*beacon);
  if (!a.beacon.valid()) return bad_line("unknown beacon " + printable_name(*beacon));
  a.receiver = receiver ? names_->lookup.receiver(vehicle, *receiver) : ReceiverId();
  if (!a.receiver.valid())
    return bad_line(receiver && receiver->empty()
                        ? "receiver is missing, and there are several"
                        : "unknown receiver " + printable_name(receiver.value_or("")));
  a.tof_s = live_number(object, "tof_s", std::nan(""));
  if (!object.contains("tof_s") && constant_speed_mps_ > 0)
    a.tof_s = live_number(object, "distance_m", std::nan("")) / constant_speed_mps_;
  if (!std::isfinite(a.tof_s)) return bad_line("tof_s is missing or no number");
  if (std::abs(a.tof_s) > kLargestTof_s) return bad_line("tof_s is impossibly large");
  a.amplitude_v = live_number(object, "amplitude_v", a.amplitude_v);
  a.temperature_degC = live_number(object, "temperature_degC", a.temperature_degC);
  if (!is_temperature(a.temperature_degC))
    return bad_line("temperature_degC is beyond 100 degrees Celsius (20 degC are 293 K)");
  if (const auto epoch = object.find("epoch"); epoch != object.end() && !epoch->is_null()) {
    if (!epoch->is_number_integer()) return bad_line("epoch is no integer");
    a.epoch = epoch->get<std::int64_t>();
  }
  return LiveRow{a};
}

}  // namespace octant::io
