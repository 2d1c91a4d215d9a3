// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/support/result.h"

namespace octant::io {

/// Errors: there is no such folder, it may not be read, it is a file.
[[nodiscard]] Result<void> check_run_folder(const std::string& path);

/// What to say where a folder holds no recording: the recordings right below it, if there are any.
[[nodiscard]] std::string advice_where_no_run_is(const std::string& folder);

}  // namespace octant::io
