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

/// The files that a run folder gives meaning to.
inline constexpr std::string_view kRunFiles[] = {"tof.csv",      "bearings.csv", "scans.csv",  "odometry.csv",
                                                 "odometry.tum", "poses.tum",    "points.csv", "truth.tum",
                                                 "truth.csv",    "run.yaml"};

struct ReadRunOptions {
  bool read_truth = false;  ///< open truth.tum; only verify does
  bool read_poses = true;   ///< open poses.tum
  /// Of a medium whose speed is constant: then a column distance_m may stand for tof_s [m/s]. 0: it may not.
  double constant_speed_mps = 0.0;
  int threads = 1;  ///< that read tof.csv; the result does not depend on it
};

/// Reads a run folder (contract). Needs at least one of tof.csv, bearings.csv, scans.csv with rows.
/// Errors name file and line. Arrivals that are no measurement (nan, empty, not positive) are in
/// MeasurementLog::rejected, with one warning that names the first line of each kind.
[[nodiscard]] Result<MeasurementLog> read_run(const std::string& folder, const NameTable& names,
                                              const Timing& timing, const ReadRunOptions& options = {});

/// How good a vehicle's odometry is, without a recording of it: the block `odometry` of a run.yaml, or of
/// that in a run folder. Error: there is none. @param warnings  of the file, added to
[[nodiscard]] Result<OdometryAccuracy> read_odometry_accuracy(const std::string& path,
                                                              std::vector<std::string>& warnings);

/// Writes a run folder; truth.tum when the log has truth.
[[nodiscard]] Result<void> write_run(const std::string& folder, const MeasurementLog& log,
                                     const NameTable& names);

/// Errors: there is no such folder, it may not be read, it is a file.
[[nodiscard]] Result<void> check_run_folder(const std::string& path);

/// What to say where a folder holds no recording: the recordings right below it, if there are any.
[[nodiscard]] std::string advice_where_no_run_is(const std::string& folder);

}  // namespace octant::io
