// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/text/atomic_file.h"
#include "models/run.h"
#include "models/support/result.h"

// What logs of other programs and devices hold, before a site file knows their names.
namespace octant::io {

inline constexpr std::size_t kMostImportedNames = 10'000;

/// Names as small numbers, in the order in which they came.
class ImportedNames {
 public:
  /// -1 where there are more than kMostImportedNames.
  int number_of(std::string_view name);
  [[nodiscard]] const std::vector<std::string>& all() const { return names_; }

 private:
  std::map<std::string, int, std::less<>> numbers_;
  std::vector<std::string> names_;
};

struct ImportedArrival {
  double time_s = 0.0;
  double value = 0.0;  ///< time of flight [s] or distance [m]
  bool is_distance = false;
  int beacon = -1, receiver = -1, vehicle = -1;  ///< numbers of names; -1: not named
  std::int64_t epoch = kNoEpoch;
  double amplitude_v = std::numeric_limits<double>::quiet_NaN();
  double temperature_degC = std::numeric_limits<double>::quiet_NaN();
};

struct ImportedLog {
  std::string path;
  ImportedNames names;
  std::vector<ImportedArrival> arrivals;
  std::vector<TimedPose> odometry;  ///< poses in a frame of its own, as odometry counts them
  std::vector<TimedPose> poses, truth;
  std::string run_yaml;                        ///< as it stands; empty: none
  std::map<std::string, std::size_t> ignored;  ///< rows of beacons that were to be ignored
  std::size_t not_heard = 0;                   ///< rows without a distance: none was measured
  std::vector<std::string> warnings;

  [[nodiscard]] std::size_t ignored_rows() const;
};

/// The run folder's files of a log, in the order of time. Where `speed_mps` is given, distances become the
/// times of flight that the device had measured if it took that speed; otherwise tof.csv has distance_m.
/// Adds warnings: rows that ran backwards in time, poses of one instant, rows of ignored beacons.
/// Errors: kBadInput: nothing to write; both times and distances without a speed.
[[nodiscard]] Result<std::vector<FileContent>> run_files(ImportedLog& log, const std::string& folder,
                                                         std::optional<double> speed_mps);

}  // namespace octant::io
