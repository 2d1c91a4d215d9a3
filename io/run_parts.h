// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the files of a run folder, one function each; run_folder.cc puts them together.

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "io/csv.h"
#include "models/result.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::io {

/// Names in rows to ids. Views in the maps point into the NameTable, which must outlive it.
class NameLookup {
 public:
  explicit NameLookup(const NameTable& names);

  /// Vehicle of rows that name none: run.yaml's, else "robot", else the only one; not valid() if there are several.
  VehicleId default_vehicle;

  [[nodiscard]] VehicleId vehicle(std::string_view name) const;  ///< not valid() if unknown
  // Ids of a row; false after logging an error at the column. Empty names stand for the default, or for the only one.
  bool beacon(CsvReader& csv, int column, BeaconId& id) const;
  bool vehicle(CsvReader& csv, int column, VehicleId& id) const;
  bool receiver(CsvReader& csv, int column, VehicleId vehicle, ReceiverId& id) const;
  [[nodiscard]] const NameTable& names() const { return names_; }

 private:
  const NameTable& names_;
  std::unordered_map<std::string_view, BeaconId> beacons_;
  std::unordered_map<std::string_view, VehicleId> vehicles_;
  std::vector<std::unordered_map<std::string_view, ReceiverId>> receivers_;  // by vehicle
  std::vector<ReceiverId> only_receiver_;                                    // by vehicle; not valid() if it has several
};

/// Watches that time does not decrease and that each epoch is one block for each vehicle.
class OrderWatch {
 public:
  OrderWatch(std::size_t vehicles, int time_column, int epoch_column);
  bool time(CsvReader& csv, double time_s);
  bool epoch(CsvReader& csv, VehicleId vehicle, std::int64_t epoch);

 private:
  int time_column_, epoch_column_;
  double last_time_s_;
  std::vector<std::int64_t> current_;                       // by vehicle
  std::vector<std::unordered_set<std::int64_t>> finished_;  // by vehicle
};

/// What run.yaml says beside what goes into the log.
struct RunHeader {
  std::string vehicle;  ///< empty: not named
  double range_max_m;   ///< infinite: not given
};

// Each adds to the log; `text` is the content of `file`.
[[nodiscard]] Result<RunHeader> parse_run_yaml(std::string_view text, const std::string& file, MeasurementLog& log);
[[nodiscard]] Result<void> parse_tof(std::string_view text, const std::string& file, const NameLookup& names, Clock clock,
                                     MeasurementLog& log);
[[nodiscard]] Result<void> parse_bearings(std::string_view text, const std::string& file, const NameLookup& names,
                                          MeasurementLog& log);
[[nodiscard]] Result<void> parse_odometry(std::string_view text, const std::string& file, const NameLookup& names,
                                          MeasurementLog& log);
[[nodiscard]] Result<void> parse_scans(std::string_view text, const std::string& file, double range_max_m, MeasurementLog& log);

// The texts that write_run writes.
[[nodiscard]] std::string run_to_yaml(const MeasurementLog& log, const NameTable& names);
[[nodiscard]] std::string tof_to_csv(const MeasurementLog& log, const NameTable& names);
[[nodiscard]] std::string bearings_to_csv(const MeasurementLog& log, const NameTable& names);
[[nodiscard]] std::string odometry_to_csv(const MeasurementLog& log, const NameTable& names);
[[nodiscard]] std::string scans_to_csv(const MeasurementLog& log);
/// A CSV field, in quotes where it needs them.
[[nodiscard]] std::string csv_field(std::string_view text);

}  // namespace octant::io
