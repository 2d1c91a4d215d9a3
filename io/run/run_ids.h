// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

/// Who is named in a recording, before there is a site file that knows them.
struct RunIds {
  struct Vehicle {
    std::string name;                    ///< "robot" where rows name none
    std::vector<std::string> receivers;  ///< empty: rows name none
  };
  std::vector<std::string> beacons;  ///< and reflectors; numbers within names in their order: B2 before B10
  std::vector<Vehicle> vehicles;     ///< at least one
  bool has_epochs = false;
  bool has_amplitudes = false;
  std::vector<std::string> warnings = {};
};

/// Of the tof.csv and bearings.csv of a run folder. Errors: neither is there, no row in either, what CSV
/// readers refuse, more than 10,000 names.
[[nodiscard]] Result<RunIds> read_run_ids(const std::string& folder);

}  // namespace octant::io
