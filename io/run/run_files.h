// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "models/support/result.h"

namespace octant::io {

/// Files of a run folder.
inline constexpr std::string_view kRunFiles[] = {"tof.csv",      "bearings.csv", "scans.csv",  "odometry.csv",
                                                 "odometry.tum", "poses.tum",    "points.csv", "truth.tum",
                                                 "truth.csv",    "run.yaml"};

/// Errors: there is no such folder, it may not be read, it is a file.
[[nodiscard]] Result<void> check_run_folder(const std::string& path);

/// Advice for a folder without a recording: names the recordings in its subfolders, if there are any.
[[nodiscard]] std::string advice_where_no_run_is(const std::string& folder);

}  // namespace octant::io
