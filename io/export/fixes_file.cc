// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>

#include "io/export/exported.h"
#include "io/run/tum.h"
#include "io/text/csv.h"
#include "io/text/open_file.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr FixStatus kStatuses[] = {FixStatus::kOk,           FixStatus::kTooFewArrivals,
                                   FixStatus::kPoorGeometry, FixStatus::kAmbiguous,
                                   FixStatus::kNoConsensus,  FixStatus::kNotConverged};

/// Rows of fixes.csv.
class FixesReader {
 public:
  FixesReader(std::string_view text, const std::string& path) : csv_(text, path) {}

  Result<ExportedFixes> read() {
    time_ = csv_.require("time_s");
    status_ = csv_.require("status");
    const char* names[] = {"x_m",
                           "y_m",
                           "z_m",
                           "heading_rad",
                           "sigma_x_m",
                           "sigma_y_m",
                           "sigma_heading_rad",
                           "protection_level_m"};
    for (std::size_t i = 0; i < std::size(names); ++i) columns_[i] = csv_.require(names[i]);
    vehicle_ = csv_.find("vehicle");
    used_ = csv_.find("arrivals_used");
    rejected_ = csv_.find("arrivals_rejected");
    while (csv_.next_row())
      if (!row()) break;
    if (csv_.error()) return fail(*csv_.error());
    return std::move(out_);
  }

 private:
  bool row() {
    Fix fix;
    if (!csv_.number(time_, fix.time_s) || !status(fix.status)) return false;
    if (const std::string_view name = csv_.field(vehicle_); !name.empty()) fix.vehicle = vehicle(name);
    double values[8];
    for (std::size_t i = 0; i < 8; ++i)
      if (!csv_.number_or_nan(columns_[i], values[i])) return false;
    if (fix.ok()) {
      for (std::size_t i = 0; i < 4; ++i)
        if (!std::isfinite(values[i]))
          return csv_.fail_at(columns_[i], "a fix that is ok without a pose",
                              "x_m, y_m, z_m and heading_rad");
      fix.T_map_vehicle = Pose::planar(values[0], values[1], values[3]);
      fix.T_map_vehicle.translation_m.z() = values[2];
      fix.covariance = PoseCovariance::Zero(3, 3);
      for (int i = 0; i < 3; ++i)
        fix.covariance(i, i) = std::isfinite(values[4 + i]) ? values[4 + i] * values[4 + i] : 0.0;
      fix.protection_level_m = std::isfinite(values[7]) ? values[7] : 0.0;
    }
    std::int64_t count = 0;
    if (used_ >= 0) {
      if (!csv_.integer(used_, count)) return false;
      fix.arrivals_used = static_cast<int>(std::clamp<std::int64_t>(count, 0, 1 << 30));
    }
    if (rejected_ >= 0) {
      if (!csv_.integer(rejected_, count)) return false;
      fix.arrivals_rejected = static_cast<int>(std::clamp<std::int64_t>(count, 0, 1 << 30));
    }
    out_.fixes.push_back(std::move(fix));
    return true;
  }

  bool status(FixStatus& status) {
    for (const FixStatus known : kStatuses)
      if (csv_.field(status_) == to_string(known)) return status = known, true;
    return csv_.fail_at(status_, in_quotes(csv_.field(status_)),
                        "a status as octant localize --csv writes it");
  }

  VehicleId vehicle(std::string_view name) {
    auto& known = out_.names.vehicles;
    for (std::size_t v = 0; v < known.size(); ++v)
      if (known[v] == name) return VehicleId(v);
    known.emplace_back(name);
    return VehicleId(known.size() - 1);
  }

  CsvReader csv_;
  ExportedFixes out_;
  int time_ = -1, status_ = -1, vehicle_ = -1, used_ = -1, rejected_ = -1;
  int columns_[8] = {};
};

}  // namespace

Result<ExportedFixes> read_fixes(const std::string& path) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  const std::string_view text = without_bom(map->text());
  const std::string_view head = text.substr(0, text.find('\n'));
  if (head.find("time_s") != std::string_view::npos && head.find(',') != std::string_view::npos)
    return FixesReader(map->text(), path).read();
  const auto poses = tum_from_text(map->text(), path);
  if (!poses) return fail(poses.error());
  ExportedFixes out;
  for (const TimedPose& pose : *poses) {
    Fix& fix = out.fixes.emplace_back();
    fix.status = FixStatus::kOk;
    fix.time_s = pose.time_s;
    fix.T_map_vehicle = pose.T_map_vehicle;
  }
  return out;
}

}  // namespace octant::io
