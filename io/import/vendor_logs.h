// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/import/imported_log.h"
#include "models/support/result.h"

// Logs of the kits of some manufacturers. Distances are in metres, and beacons have the names that the kit
// uses.
namespace octant::io {

/// Marvelmind's dashboard, CSV without a header (its operating manual, "CSV format"): UNIX time [ms] (older
/// dashboards leave it out), time since the record before [ms], time since the dashboard's start [ms],
/// address of the hedgehog, its x, y, z, then address and raw distance [m] of each stationary beacon.
/// Receivers are the hedgehogs, named where there are several. Errors: kBadInput with the line.
[[nodiscard]] Result<ImportedLog> read_marvelmind_log(const std::string& path,
                                                      const VendorLogOptions& options = {});

/// Bitcraze's client for the Crazyflie, CSV: Timestamp [ms] and log variables, of which ranging.distance0 to
/// ranging.distance7 [m] are the distances to the anchors (two-way ranging). If ranging.state is logged,
/// anchors whose bit is not set were not received. The client repeats the last value, so a distance that is
/// exactly equal to the one before is not a new one. Errors: kBadInput: no such column (for a log of time
/// differences the message says so), cells that are not numbers.
[[nodiscard]] Result<ImportedLog> read_crazyflie_log(const std::string& path,
                                                     const VendorLogOptions& options = {});

/// Serial output of a Decawave/Qorvo DWM1001 after `les` or `lec`, one fix a line, logged by any terminal:
/// after a time in seconds or milliseconds, a date and time, or a time of day; or without a time,
/// options.period_s apart. Garbled groups are left out and counted. Errors: kBadInput: a line without a time
/// and no period; no line of the two kinds.
[[nodiscard]] Result<ImportedLog> read_dwm1001_log(const std::string& path,
                                                   const VendorLogOptions& options = {});

/// Reads the log of a kit: marvelmind, crazyflie, dwm1001, trek1000, makerfabs, pozyx or linktrack. Kits of
/// the last four: io/import/kit_lines.h and linktrack.h. Tags are receivers, named where there are several.
[[nodiscard]] Result<ImportedLog> read_kit_log(std::string_view kit, const std::string& path,
                                               const VendorLogOptions& options = {});

/// The kit whose log a file seems to be, by its content; empty if it is another file.
[[nodiscard]] std::string kit_of(const std::string& path);

}  // namespace octant::io
