// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the files of a run folder, one function each; run_folder.cc combines them.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/text/csv.h"
#include "io/text/name_index.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

/// Converts names in rows to ids. Its views point into the NameTable, which must outlive it.
class NameLookup {
 public:
  explicit NameLookup(const NameTable& names);

  /// Vehicle of rows without a name: run.yaml's, else "robot", else the only one; not valid() if there are
  /// several.
  VehicleId default_vehicle;

  // Id of a name, not valid() if unknown. An empty name means the default, or the only one.
  [[nodiscard]] BeaconId beacon(std::string_view name) const { return BeaconId(beacons_.find(name)); }
  [[nodiscard]] VehicleId vehicle(std::string_view name) const {
    return name.empty() ? default_vehicle : VehicleId(vehicles_.find(name));
  }
  [[nodiscard]] ReceiverId receiver(VehicleId vehicle, std::string_view name) const {
    const Receivers& known = receivers_[vehicle.index()];
    if (name.empty()) return known.only;
    const std::int32_t found = known.names.find(name);
    return found < 0 ? ReceiverId() : known.ids[static_cast<std::size_t>(found)];
  }

  // Reads the name in a cell of the current row; false after logging an error at the column.
  bool beacon(CsvReader& csv, int column, BeaconId& id) const;
  bool vehicle(CsvReader& csv, int column, VehicleId& id) const;
  bool receiver(CsvReader& csv, int column, VehicleId vehicle, ReceiverId& id) const;
  [[nodiscard]] const NameTable& names() const { return names_; }

 private:
  [[nodiscard]] std::string other_unknown_beacons(const CsvReader& csv, int column) const;

  struct Receivers {
    NameIndex names;
    std::vector<ReceiverId> ids;  // by place in names
    ReceiverId only;              // not valid() if there are several
  };
  const NameTable& names_;
  NameIndex beacons_, vehicles_;
  std::vector<Receivers> receivers_;  // by vehicle
};

/// Content of run.yaml that is not stored in the log.
struct RunHeader {
  std::string vehicle;  ///< empty: not named
  double range_max_m;   ///< infinite: not given
};

// Each adds to the log; `text` is the content of `file`.
[[nodiscard]] Result<RunHeader> parse_run_yaml(std::string_view text, const std::string& file,
                                               MeasurementLog& log);
[[nodiscard]] Result<void> parse_bearings(std::string_view text, const std::string& file,
                                          const NameLookup& names, MeasurementLog& log);
[[nodiscard]] Result<void> parse_odometry(std::string_view text, const std::string& file,
                                          const NameLookup& names, MeasurementLog& log);
[[nodiscard]] Result<void> parse_scans(std::string_view text, const std::string& file, double range_max_m,
                                       MeasurementLog& log);

/// Poses measured by hand, one for each epoch (points.csv, truth.csv): the same pose at the first and at the
/// last time of the epoch, in the order of time. `accuracy` limits their interpolation to an epoch, and has
/// the sigmas of the rows if they are stated. Needs the log's arrivals and bearings. Errors: those of the
/// rows; a run without epochs.
[[nodiscard]] Result<std::vector<TimedPose>> parse_points(std::string_view text, const std::string& file,
                                                          const NameLookup& names, MeasurementLog& log,
                                                          PoseAccuracy& accuracy);

// Texts of the files of write_run().
[[nodiscard]] std::string run_to_yaml(const MeasurementLog& log, const NameTable& names);
[[nodiscard]] std::string tof_to_csv(const MeasurementLog& log, const NameTable& names);
[[nodiscard]] std::string bearings_to_csv(const MeasurementLog& log, const NameTable& names);
[[nodiscard]] std::string odometry_to_csv(const MeasurementLog& log, const NameTable& names);
[[nodiscard]] std::string scans_to_csv(const MeasurementLog& log);
}  // namespace octant::io
