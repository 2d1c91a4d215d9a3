// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

/// Files of a run folder.
inline constexpr std::string_view kRunFiles[] = {"tof.csv",      "bearings.csv", "scans.csv",  "odometry.csv",
                                                 "odometry.tum", "poses.tum",    "points.csv", "truth.tum",
                                                 "truth.csv",    "run.yaml"};

struct ReadRunOptions {
  bool read_truth = false;  ///< open truth.tum; only verify does
  bool read_poses = true;   ///< open poses.tum
  /// Speed of a medium with constant speed [m/s]; a column distance_m may then replace tof_s. 0: it may not.
  double constant_speed_mps = 0.0;
  int threads = 1;  ///< threads that read tof.csv; the result does not depend on their number
};

/// Reads a run folder (contract). Needs at least one of tof.csv, bearings.csv, scans.csv with rows.
/// Errors name file and line. Arrivals that are no measurement (nan, empty, not positive) are in
/// MeasurementLog::rejected, with one warning that names the first line of each kind.
[[nodiscard]] Result<MeasurementLog> read_run(const std::string& folder, const NameTable& names,
                                              const Timing& timing, const ReadRunOptions& options = {});

/// Accuracy of a vehicle's odometry without a recording: the block `odometry` of a run.yaml, or of the one in
/// a run folder. Error: the block is missing.
/// @param warnings  warnings about the file are added to it
[[nodiscard]] Result<OdometryAccuracy> read_odometry_accuracy(const std::string& path,
                                                              std::vector<std::string>& warnings);

/// Writes a run folder; truth.tum when the log has truth.
[[nodiscard]] Result<void> write_run(const std::string& folder, const MeasurementLog& log,
                                     const NameTable& names);

/// Errors: there is no such folder, it may not be read, it is a file.
[[nodiscard]] Result<void> check_run_folder(const std::string& path);

/// Advice for a folder without a recording: names the recordings in its subfolders, if there are any.
[[nodiscard]] std::string advice_where_no_run_is(const std::string& folder);

}  // namespace octant::io
