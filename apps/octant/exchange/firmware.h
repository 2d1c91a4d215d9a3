// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "models/deployment.h"
#include "models/support/result.h"

namespace octant::app {

struct FirmwareOptions {
  std::string vehicle{};  ///< empty: the only one of the deployment
  bool single_precision = false;
};

struct FirmwareFile {
  std::string name, text;
};

/// Sources of the firmware edition (apps/firmware) with the tables of a deployment: octant_fix.h,
/// octant_fix.c, octant_site.h, octant_site.c. Errors: what the firmware edition does not cover.
[[nodiscard]] Result<std::vector<FirmwareFile>> firmware_files(const Deployment& deployment,
                                                               const FirmwareOptions& options);

// Texts of apps/firmware, which the program carries.
[[nodiscard]] std::string_view firmware_header();
[[nodiscard]] std::string_view firmware_model();
[[nodiscard]] std::string_view firmware_adjust();
[[nodiscard]] std::string_view firmware_protect();
[[nodiscard]] std::string_view firmware_consensus();
[[nodiscard]] std::string_view firmware_start_plane();
[[nodiscard]] std::string_view firmware_start_space();
[[nodiscard]] std::string_view firmware_fix();
[[nodiscard]] std::string_view firmware_filter();

}  // namespace octant::app
