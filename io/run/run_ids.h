// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

/// Names in a recording, before a site file defines them.
struct RunIds {
  struct Vehicle {
    std::string name;                    ///< "robot" if rows have no name
    std::vector<std::string> receivers;  ///< empty if rows have no name
  };
  std::vector<std::string> beacons;  ///< and reflectors; sorted with numbers by value: B2 before B10
  std::vector<Vehicle> vehicles;     ///< at least one
  bool has_epochs = false;
  bool has_amplitudes = false;
  std::vector<std::string> warnings = {};
};

/// Reads the names in tof.csv and bearings.csv of a run folder. Errors: both files are missing, no row in
/// either, errors of CSV readers, more than 10,000 names.
[[nodiscard]] Result<RunIds> read_run_ids(const std::string& folder);

}  // namespace octant::io
