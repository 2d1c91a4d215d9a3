// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_folder.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fmt/format.h>

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

namespace fs = std::filesystem;

Result<void> check_run_folder(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    return fail({.file = path,
                 .found = fmt::format("the run folder cannot be read: {}", std::strerror(errno)),
                 .expected = "a folder with tof.csv, bearings.csv or scans.csv",
                 .advice = "check the path"});
  }
  if (S_ISDIR(status.st_mode)) return {};
  return fail({.file = path,
               .found = "this is a file",
               .expected = "a run folder with tof.csv, bearings.csv or scans.csv",
               .advice = "name the folder, not a file within it"});
}

std::string advice_where_no_run_is(const std::string& folder) {
  constexpr std::size_t kMostLookedAt = 1000, kMostNamed = 3;
  std::vector<std::string> runs;
  std::error_code trouble;
  std::size_t looked_at = 0;
  for (fs::directory_iterator at(folder, trouble), end; !trouble && at != end && looked_at < kMostLookedAt;
       at.increment(trouble), ++looked_at) {
    std::error_code ignored;
    for (const char* name : {"tof.csv", "bearings.csv", "scans.csv"})
      if (fs::is_regular_file(at->path() / name, ignored)) {
        runs.push_back(at->path().string());
        break;
      }
  }
  if (runs.empty()) return "is this the run folder?";
  std::ranges::sort(runs);
  std::string names;
  for (std::size_t i = 0; i < std::min(runs.size(), kMostNamed); ++i)
    names += (i == 0 ? "'" : " or '") + runs[i] + "'";
  return "did you mean " + names + "?";
}

}  // namespace octant::io
