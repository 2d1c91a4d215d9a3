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

// Content of logs of other programs and devices, before a site file defines their names.
namespace octant::io {

inline constexpr std::size_t kMostImportedNames = 10'000;

/// Numbers of names, in the order of their first use.
class ImportedNames {
 public:
  /// Returns -1 for more than kMostImportedNames.
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
  double received_after_s = std::numeric_limits<double>::quiet_NaN();  ///< time since time_s
};

struct ImportedLog {
  std::string path;
  ImportedNames names;
  std::vector<ImportedArrival> arrivals;
  std::vector<TimedPose> odometry;  ///< poses in the frame of the odometry
  std::vector<TimedPose> poses, truth;
  std::string run_yaml;                        ///< content of run.yaml; empty: not written
  std::map<std::string, std::size_t> ignored;  ///< number of rows of ignored beacons
  std::size_t not_heard = 0;                   ///< rows without a distance, where no measurement was made
  std::vector<std::string> warnings;

  [[nodiscard]] std::size_t ignored_rows() const;
};

/// Options of the readers of kits' logs.
struct VendorLogOptions {
  std::vector<std::string> ignore{};  ///< beacons whose rows are left out, such as those of a neighbour
  std::optional<double> period_s{};   ///< time between lines without a time
};

/// Removes the names of receivers, or of vehicles, if all arrivals have the same one.
void remove_only_receiver(ImportedLog& log);
void remove_only_vehicle(ImportedLog& log);

/// Files of a run folder for a log, in the order of time. With `speed_mps`, distances are converted to the
/// times of flight from which the device computed them with this speed; otherwise tof.csv has distance_m.
/// Adds warnings about rows that ran backwards in time, repeated poses of one time, and rows of ignored
/// beacons. Errors: kBadInput: an empty log; both times and distances without a speed.
[[nodiscard]] Result<std::vector<FileContent>> run_files(ImportedLog& log, const std::string& folder,
                                                         std::optional<double> speed_mps);

}  // namespace octant::io
