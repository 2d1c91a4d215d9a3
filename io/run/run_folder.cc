// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_folder.h"

#include <filesystem>
#include <system_error>

#include "io/run/run_reader.h"
#include "io/run/tum.h"
#include "io/text/atomic_file.h"
#include "io/tof/run_parts.h"

namespace octant::io {

Result<MeasurementLog> read_run(const std::string& folder, const NameTable& names, const Timing& timing,
                                const ReadRunOptions& options) {
  RunReader reader(folder, names, timing, options);
  // In the order in which errors are reported: the files on which all rows depend, the arrivals, the others.
  if (auto ok = reader.begin(); !ok) return fail(ok.error());
  if (auto ok = reader.read_arrivals(); !ok) return fail(ok.error());
  if (auto ok = reader.read_others(); !ok) return fail(ok.error());
  if (auto ok = reader.finish(); !ok) return fail(ok.error());
  return reader.take_log();
}

Result<void> write_run(const std::string& folder, const MeasurementLog& log, const NameTable& names) {
  struct RunFile {
    const char* name;
    std::string text;  // empty: not part of this run
  };
  // run.yaml is written last, so that a program that watches the folder finds the other files complete.
  const RunFile files[] = {{"tof.csv", log.arrivals.empty() ? "" : tof_to_csv(log, names)},
                           {"bearings.csv", log.bearings.empty() ? "" : bearings_to_csv(log, names)},
                           {"scans.csv", log.scans.empty() ? "" : scans_to_csv(log)},
                           {"odometry.csv", log.odometry.empty() ? "" : odometry_to_csv(log, names)},
                           {"poses.tum", log.poses.empty() ? "" : poses_to_tum(log.poses)},
                           {"truth.tum", log.truth.empty() ? "" : poses_to_tum(log.truth)},
                           {"run.yaml", run_to_yaml(log, names)}};
  const std::filesystem::path root(folder);
  std::error_code status;
  for (const RunFile& file : files) {
    if (!file.text.empty() || !std::filesystem::exists(root / file.name, status)) continue;
    return fail({.code = Errc::kOutput,
                 .file = (root / file.name).string(),
                 .found = "the folder holds a file that is not part of this run, and would become part of it",
                 .advice = "remove it, or choose another folder"});
  }
  std::filesystem::create_directory(root, status);
  if (status) {
    return fail({.code = Errc::kOutput,
                 .file = folder,
                 .found = "the run folder cannot be made: " + status.message(),
                 .advice = "check that the folder above it exists and may be written"});
  }
  for (const RunFile& file : files) {
    if (file.text.empty()) continue;
    if (auto ok = write_file((root / file.name).string(), file.text); !ok) return ok;
  }
  return {};
}

}  // namespace octant::io
