// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// bearings.csv, odometry.csv and scans.csv.
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "io/run/run_folder.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"
#include "io/text/open_file.h"
#include "io/tof/order_watch.h"
#include "io/tof/run_parts.h"
#include "models/physics/unit_rotation.h"
#include "models/support/largest.h"

namespace octant::io {
namespace {

Result<void> finish(const CsvReader& csv, std::span<const OrderWatch> order, MeasurementLog& log) {
  if (csv.error()) return fail(*csv.error());
  for (const OrderWatch& watch : order)
    if (const auto restarts = watch.times().restarts.note(csv.file())) log.warnings.push_back(*restarts);
  if (const auto warning = csv.unknown_columns()) log.warnings.push_back(*warning);
  return {};
}

/// Number of a column "range17_m", -1 for other names.
int range_number(const std::string& name) {
  if (!name.starts_with("range") || !name.ends_with("_m") || name.size() < 8 || name.size() > 13) return -1;
  int number = 0;
  for (const char c : name.substr(5, name.size() - 7)) {
    if (c < '0' || c > '9') return -1;
    number = 10 * number + (c - '0');
  }
  return number;
}

/// Columns of range0_m, range1_m, ...; an error where the numbers are not 0, 1, 2, ...
std::vector<int> range_columns(CsvReader& csv) {
  std::vector<int> columns(csv.header().size(), -1);
  std::size_t count = 0;
  for (std::size_t i = 0; i < csv.header().size(); ++i) {
    const int number = range_number(csv.header()[i]);
    if (number < 0) continue;
    csv.mark_known(i);
    ++count;
    if (static_cast<std::size_t>(number) < columns.size())
      columns[static_cast<std::size_t>(number)] = static_cast<int>(i);
  }
  columns.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    if (columns[k] >= 0) continue;
    csv.fail_at(-1, fmt::format("column 'range{}_m' is missing", k), "range0_m, range1_m, ... without a gap");
    return {};
  }
  if (count == 0) csv.fail_at(-1, "there is no column 'range0_m'", "range0_m, range1_m, ...");
  return columns;
}

}  // namespace

Result<void> parse_bearings(std::string_view text, const std::string& file, const NameLookup& names,
                            MeasurementLog& log) {
  CsvReader csv(text, file);
  const int time = csv.require("time_s"), reflector = csv.require("reflector"),
            angle = csv.require("bearing_rad");
  const int epoch = csv.find("epoch"), vehicle = csv.find("vehicle");
  log.has_epochs = log.has_epochs || epoch >= 0;
  OrderWatch order(names.names().vehicles.size(), time, epoch);
  std::size_t skipped = 0;
  std::string first;
  while (csv.next_row()) {
    Bearing row;
    row.line = csv.line();
    if (!csv.number(time, row.time_s) || !order.time(csv, row.time_s)) break;
    if (!csv.number_or_nan(angle, row.bearing_rad)) break;
    if (!csv.field(reflector).empty() && !names.beacon(csv, reflector, row.reflector)) break;
    if (!names.vehicle(csv, vehicle, row.vehicle)) break;
    if (epoch >= 0 && (!csv.integer(epoch, row.epoch) || !order.epoch(csv, row.vehicle, row.epoch))) break;
    if (!std::isfinite(row.bearing_rad)) {
      if (skipped++ == 0) first = csv.place();
      continue;
    }
    if (!csv.check_angle(angle, row.bearing_rad)) break;
    log.bearings.push_back(row);
  }
  if (skipped > 0)
    log.warnings.push_back(fmt::format("{}: bearing_rad is not a number; {} row{} left out", first, skipped,
                                       skipped == 1 ? "" : "s"));
  return finish(csv, {&order, 1}, log);
}

Result<BeaconFlightLog> read_beacon_flights(const std::string& folder, const NameTable& names,
                                            std::size_t run) {
  BeaconFlightLog log;
  const std::string path = (std::filesystem::path(folder) / "beacon_tof.csv").string();
  std::error_code status;
  if (!std::filesystem::exists(path, status)) return log;
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  if (auto ok = check_lines(map->text(), path); !ok) return fail(ok.error());
  log.file = path;
  log.sha256 = sha256_hex(map->text());
  const NameLookup lookup(names);
  CsvReader csv(map->text(), path);
  const int time = csv.require("time_s"), from = csv.require("beacon_from"), to = csv.require("beacon_to"),
            tof = csv.require("tof_s");
  for (const char* optional : {"level_dbm", "temperature_degC"}) static_cast<void>(csv.find(optional));
  std::size_t skipped = 0;
  std::string first;
  while (csv.next_row()) {
    BeaconFlight row;
    row.run = run;
    if (!csv.number(time, row.time_s) || !lookup.beacon(csv, from, row.from) ||
        !lookup.beacon(csv, to, row.to) || !csv.number_or_nan(tof, row.tof_s))
      break;
    if (row.from == row.to) {
      csv.fail_at(to, "a beacon that ranges to itself", "two beacons");
      break;
    }
    if (row.tof_s > 0.0 && row.tof_s <= kLargestTof_s)
      log.flights.push_back(row);
    else if (skipped++ == 0)
      first = csv.place();
  }
  if (csv.error()) return fail(*csv.error());
  if (skipped > 0)
    log.warnings.push_back(
        fmt::format("{}: tof_s is not a positive number of at most {:g} s; {} row{} left out", first,
                    kLargestTof_s, skipped, skipped == 1 ? "" : "s"));
  if (const auto warning = csv.unknown_columns()) log.warnings.push_back(*warning);
  return log;
}

namespace {

/// Columns of a row's motion: in the plane, or with dz_m and a quaternion in place of the heading in space.
class OdometryColumns {
 public:
  explicit OdometryColumns(CsvReader& csv) : dx_(csv.require("dx_m")), dy_(csv.require("dy_m")) {
    dz_ = csv.find("dz_m");
    in_space_ = csv.find("qw") >= 0 || csv.find("qx") >= 0 || csv.find("qy") >= 0 || csv.find("qz") >= 0;
    if (!in_space_) {
      turn_ = csv.require("dheading_rad");
      return;
    }
    for (std::size_t i = 0; i < 4; ++i) q_[i] = csv.require(kQuaternion[i]);
    if (const int turn = csv.find("dheading_rad"); turn >= 0)
      csv.fail_at(turn, "both a quaternion and dheading_rad", "one of them", "leave the other out");
  }

  bool read(CsvReader& csv, OdometryStep& row) const {
    if (!csv.length(dx_, row.dx_m) || !csv.length(dy_, row.dy_m)) return false;
    if (dz_ >= 0 && !csv.length(dz_, row.dz_m)) return false;
    if (!in_space_) return csv.number(turn_, row.dheading_rad) && csv.check_angle(turn_, row.dheading_rad);
    std::array<double, 4> xyzw{};
    for (std::size_t i = 0; i < 4; ++i)
      if (!csv.number(q_[i], xyzw[i])) return false;
    const auto rotation = unit_rotation(xyzw[0], xyzw[1], xyzw[2], xyzw[3]);
    if (!rotation)
      return csv.fail_at(q_[3], "a quaternion of no length",
                         "qx, qy, qz, qw of length 1 (0, 0, 0, 1: no turn)");
    row.set_pose({{row.dx_m, row.dy_m, row.dz_m}, *rotation});
    return true;
  }

 private:
  static constexpr std::array<const char*, 4> kQuaternion = {"qx", "qy", "qz", "qw"};
  int dx_, dy_, dz_ = -1, turn_ = -1;
  std::array<int, 4> q_{};
  bool in_space_ = false;
};

}  // namespace

Result<void> parse_odometry(std::string_view text, const std::string& file, const NameLookup& names,
                            MeasurementLog& log) {
  CsvReader csv(text, file);
  const int time = csv.require("time_s");
  const OdometryColumns columns(csv);
  const int vehicle = csv.find("vehicle");
  // The rows of each vehicle are a chain of their own, with their own order of time.
  std::vector<OrderWatch> order(names.names().vehicles.size(), OrderWatch(0, time, -1));
  std::vector<bool> begun(names.names().vehicles.size(), false);
  log.odometry.reserve(csv.rows_left_estimate());
  while (csv.next_row()) {
    OdometryStep row;
    if (!csv.number(time, row.time_s) || !names.vehicle(csv, vehicle, row.vehicle)) break;
    if (!order[row.vehicle.index()].time(csv, row.time_s)) break;
    if (!columns.read(csv, row)) break;
    if (!begun[row.vehicle.index()] && !row.is_zero()) {
      log.warnings.push_back(fmt::format(
          "{}: the first row is the anchor, its motion is not used; expected zeros", csv.place()));
    }
    begun[row.vehicle.index()] = true;
    log.odometry.push_back(row);
  }
  return finish(csv, order, log);
}

Result<void> parse_scans(std::string_view text, const std::string& file, double range_max_m,
                         MeasurementLog& log) {
  CsvReader csv(text, file);
  const int time = csv.require("time_s"), first = csv.require("angle_min_rad"),
            step = csv.require("angle_increment_rad");
  const std::vector<int> ranges = range_columns(csv);
  OrderWatch order(0, time, -1);
  while (csv.next_row()) {
    Scan scan;
    if (!csv.number(time, scan.time_s) || !order.time(csv, scan.time_s)) break;
    if (!csv.number(first, scan.angle_min_rad) || !csv.check_angle(first, scan.angle_min_rad)) break;
    if (!csv.number(step, scan.angle_increment_rad) || !csv.check_angle(step, scan.angle_increment_rad))
      break;
    scan.range_m.resize(ranges.size());
    for (std::size_t k = 0; k < ranges.size(); ++k) {
      if (!csv.number_or_nan(ranges[k], scan.range_m[k])) break;
      const double range_m = scan.range_m[k];
      if (!(range_m > 0.0) || range_m > range_max_m || std::isinf(range_m))
        scan.range_m[k] = std::numeric_limits<double>::quiet_NaN();
    }
    if (csv.error()) break;
    log.scans.push_back(std::move(scan));
  }
  return finish(csv, {&order, 1}, log);
}

}  // namespace octant::io
