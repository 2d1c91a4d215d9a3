// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_files.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace octant::io {

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
