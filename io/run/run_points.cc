// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// points.csv and truth.csv: poses measured by hand, one a stop.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "io/tof/run_parts.h"

namespace octant::io {
namespace {

struct Span {
  double first_s = 0.0, last_s = 0.0;
};

/// Time span of each epoch of a vehicle.
std::map<std::int64_t, Span> epochs_of(const MeasurementLog& log, VehicleId vehicle) {
  std::map<std::int64_t, Span> spans;
  const auto add = [&](const auto& rows) {
    for (const auto& row : rows) {
      if (row.vehicle != vehicle || row.epoch == kNoEpoch) continue;
      const auto [at, added] = spans.try_emplace(row.epoch, Span{row.time_s, row.time_s});
      if (added) continue;
      at->second.first_s = std::min(at->second.first_s, row.time_s);
      at->second.last_s = std::max(at->second.last_s, row.time_s);
    }
  };
  add(log.arrivals);
  add(log.bearings);
  return spans;
}

/// Columns of a table of points.
struct PointColumns {
  int epoch, x, y, z, heading, sigma, heading_sigma, vehicle;
  explicit PointColumns(CsvReader& csv)
      : epoch(csv.require("epoch")),
        x(csv.require("x_m")),
        y(csv.require("y_m")),
        z(csv.find("z_m")),
        heading(csv.find("heading_rad")),
        sigma(csv.find("sigma_m")),
        heading_sigma(csv.find("heading_sigma_rad")),
        vehicle(csv.find("vehicle")) {}
};

struct Point {
  std::int64_t epoch = kNoEpoch;
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  double heading_rad = NAN, sigma_m = NAN, heading_sigma_rad = NAN;  // NaN: not given
};

bool read_sigma(CsvReader& csv, int column, const char* name, double& sigma) {
  if (!csv.number_or_nan(column, sigma)) return false;
  if (std::isnan(sigma) || (sigma >= 0.0 && !std::isinf(sigma))) return true;
  return csv.fail_at(column, fmt::format("{} is {}", name, exact(sigma)), "a standard deviation, 0 or more");
}

bool read_point(CsvReader& csv, const PointColumns& columns, const NameLookup& names, VehicleId of_run,
                Point& point) {
  VehicleId vehicle;
  if (!csv.integer(columns.epoch, point.epoch) || !names.vehicle(csv, columns.vehicle, vehicle)) return false;
  if (of_run.valid() && vehicle != of_run)
    return csv.fail_at(columns.vehicle, "a point of another vehicle than that of the run",
                       "points of one vehicle", "name it in run.yaml (vehicle), or split the run");
  if (!csv.length(columns.x, point.p_m.x()) || !csv.length(columns.y, point.p_m.y())) return false;
  if (columns.z >= 0 && !csv.field(columns.z).empty() && !csv.length(columns.z, point.p_m.z())) return false;
  if (columns.heading >= 0 && !csv.number_or_nan(columns.heading, point.heading_rad)) return false;
  return csv.check_angle(columns.heading, point.heading_rad) &&
         read_sigma(csv, columns.sigma, "sigma_m", point.sigma_m) &&
         read_sigma(csv, columns.heading_sigma, "heading_sigma_rad", point.heading_sigma_rad);
}

/// Sets the only sigma of a run's poses: the root mean square of the stated ones, with a warning if they
/// differ by much.
void set_sigma(const std::vector<Point>& points, double Point::*sigma, const char* name,
               const std::string& file, double& common, MeasurementLog& log) {
  double square = 0.0, least = INFINITY, most = 0.0;
  std::size_t count = 0;
  for (const Point& point : points) {
    const double s = point.*sigma;
    if (std::isnan(s)) continue;
    square += s * s;
    least = std::min(least, s);
    most = std::max(most, s);
    ++count;
  }
  if (count == 0) return;
  common = std::sqrt(square / static_cast<double>(count));
  if (most > 2.0 * least)
    log.warnings.push_back(fmt::format("{}: {} goes from {} to {}; all points are weighed alike, by {}", file,
                                       name, exact(least), exact(most), exact(common)));
}

void set_accuracy(const std::vector<Point>& points, const std::string& file, PoseAccuracy& accuracy,
                  MeasurementLog& log) {
  set_sigma(points, &Point::sigma_m, "sigma_m", file, accuracy.position_sigma_m, log);
  set_sigma(points, &Point::heading_sigma_rad, "heading_sigma_rad", file, accuracy.heading_sigma_rad, log);
  const auto without =
      std::ranges::count_if(points, [](const Point& p) { return std::isnan(p.heading_rad); });
  if (without > 0) {
    accuracy.heading_known = false;
    if (static_cast<std::size_t>(without) < points.size())
      log.warnings.push_back(
          fmt::format("{}: {} of {} points are without heading_rad; the others' headings are not used either",
                      file, without, points.size()));
  }
  accuracy.attitude_sigma_rad = M_PI;  // nobody measures roll and pitch by hand
}

}  // namespace

Result<std::vector<TimedPose>> parse_points(std::string_view text, const std::string& file,
                                            const NameLookup& names, MeasurementLog& log,
                                            PoseAccuracy& accuracy) {
  CsvReader csv(text, file);
  const PointColumns columns(csv);
  if (csv.error()) return fail(*csv.error());
  VehicleId vehicle = log.vehicle;
  if (!vehicle.valid()) vehicle = log.arrivals.empty() ? VehicleId(0) : log.arrivals.front().vehicle;
  const std::map<std::int64_t, Span> epochs = epochs_of(log, vehicle);
  std::vector<Point> points;
  std::set<std::int64_t> seen;
  std::size_t unheard = 0;
  std::string first_unheard;
  while (csv.next_row()) {
    Point point;
    if (!read_point(csv, columns, names, vehicle, point)) break;
    if (!seen.insert(point.epoch).second) {
      csv.fail_at(columns.epoch, fmt::format("epoch {} is there a second time", point.epoch),
                  "one point an epoch");
      break;
    }
    if (epochs.count(point.epoch) > 0) {
      points.push_back(point);
    } else if (unheard++ == 0) {
      first_unheard = csv.place();
    }
  }
  if (csv.error()) return fail(*csv.error());
  if (epochs.empty())
    return fail({.file = file,
                 .found = "points by epoch, but rows without epochs",
                 .expected = "a column epoch in tof.csv or bearings.csv: which rows belong to which stop"});
  if (unheard > 0)
    log.warnings.push_back(fmt::format("{}: {} point{} of epochs without arrivals, not used", first_unheard,
                                       unheard, unheard == 1 ? "" : "s"));
  if (const auto warning = csv.unknown_columns()) log.warnings.push_back(*warning);
  set_accuracy(points, file, accuracy, log);
  std::vector<TimedPose> poses;
  double longest_s = 0.0;
  for (const Point& point : points) {
    const Span span = epochs.at(point.epoch);
    Pose T = Pose::planar(0.0, 0.0, std::isnan(point.heading_rad) ? 0.0 : point.heading_rad);
    T.translation_m = point.p_m;
    poses.push_back({span.first_s, T});
    if (span.last_s > span.first_s) poses.push_back({span.last_s, T});
    longest_s = std::max(longest_s, span.last_s - span.first_s);
  }
  std::ranges::stable_sort(poses, {}, &TimedPose::time_s);
  accuracy.max_gap_s = longest_s * (1.0 + 1e-12);
  return poses;
}

}  // namespace octant::io
