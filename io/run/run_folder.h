// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/run/read_run_options.h"
#include "models/network/beacon_ranges.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

/// Reads a run folder (contract). Needs at least one of tof.csv, bearings.csv, scans.csv with rows.
/// Errors name file and line. Arrivals that are no measurement (nan, empty, not positive) are in
/// MeasurementLog::rejected, with one warning that names the first line of each kind.
[[nodiscard]] Result<MeasurementLog> read_run(const std::string& folder, const NameTable& names,
                                              const Timing& timing, const ReadRunOptions& options = {});

/// Ranges between beacons (beacon_tof.csv) of a run folder; empty if there is no such file.
struct BeaconFlightLog {
  std::vector<BeaconFlight> flights;
  std::vector<std::string> warnings;
  std::string file, sha256;  ///< empty without a file
};
/// @param run  number of the recording, for BeaconFlight::run
[[nodiscard]] Result<BeaconFlightLog> read_beacon_flights(const std::string& folder, const NameTable& names,
                                                          std::size_t run);

/// Accuracy of a vehicle's odometry without a recording: the block `odometry` of a run.yaml, or of the one in
/// a run folder. Error: the block is missing.
/// @param warnings  warnings about the file are added to it
[[nodiscard]] Result<OdometryAccuracy> read_odometry_accuracy(const std::string& path,
                                                              std::vector<std::string>& warnings);

/// Writes a run folder; truth.tum when the log has truth.
[[nodiscard]] Result<void> write_run(const std::string& folder, const MeasurementLog& log,
                                     const NameTable& names);

}  // namespace octant::io
