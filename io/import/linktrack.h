// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: recorded frames of Nooploop LinkTrack modules.

#include <string>

#include "io/import/imported_log.h"
#include "models/support/result.h"

namespace octant::io {

/// True if the file begins with valid frames, as bytes or as their hexadecimal text.
[[nodiscard]] bool is_linktrack_log(const std::string& path);
/// Reads node frames 2 and 3 and tag frames 0 (NLink protocol); other frames and bytes between frames are
/// left out. Beacons are the anchors (A0, A1, ...). Times are those of the module [ms].
[[nodiscard]] Result<ImportedLog> read_linktrack_log(const std::string& path,
                                                     const VendorLogOptions& options);

}  // namespace octant::io
