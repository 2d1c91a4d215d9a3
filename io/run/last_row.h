// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the last row of a table that was cut off while it was written or copied.

#include <string>
#include <string_view>
#include <vector>

namespace octant::io {

/// A table (`*.tum`: fields separated by blanks; all others by commas, semicolons or tabs) whose text does
/// not end with a newline may have been truncated anywhere, also within a number. One warning says so. A row
/// of all fields is left out only if the truncation is visible: its last field is shorter (decimals, or the
/// name) than that of ten rows and more above it. Files that people end without a newline keep their last
/// row. A row of too few fields stays: readers refuse it, naming its line.
/// @return the text without the truncated row, or all of it
[[nodiscard]] std::string_view without_cut_row(std::string_view text, const std::string& file,
                                               std::vector<std::string>& warnings);

}  // namespace octant::io
