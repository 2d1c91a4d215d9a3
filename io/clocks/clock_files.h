// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/clocks/clock_log.h"
#include "models/deployment.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

/// Reads tdoa.csv, toa.csv and displacements.csv of a run folder, as far as they exist. Counters of toa.csv
/// that wrap (2^40 or 2^32 ticks of a DW1000) are unwrapped, with a warning. Errors name file and line.
/// @param inputs  the files that were read, with their digests, are added to it; may be null
[[nodiscard]] Result<ClockLog> read_clock_log(const std::string& folder, const NameTable& names,
                                              std::vector<InputDigest>* inputs = nullptr);

/// Returns true if the folder has tdoa.csv or toa.csv, and no tof.csv, which is read instead of them.
[[nodiscard]] bool has_clock_log(const std::string& folder);

/// Text of a tdoa.csv.
[[nodiscard]] std::string differences_to_csv(const std::vector<TimeDifference>& rows, const NameTable& names);

/// Clocks of the devices of a site: `timing.clock`, `timing.oscillator`, `timing.allan_deviation` and
/// `beacons[].clock` of its file. Without `clock: free` the beacons share one clock.
[[nodiscard]] Result<ClockModel> read_clock_model(const std::string& site_path, const Site& site);

}  // namespace octant::io
