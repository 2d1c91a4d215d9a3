// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace octant::app {

inline constexpr std::size_t kTextColumns = 80;  ///< of a terminal that nobody has made wider

/// Text broken between words into lines of at most `columns`, each with its newline. Newlines of the text
/// stay.
/// @param indent  blanks before all lines but the first
/// @param used    columns of the first line that hold something already
[[nodiscard]] std::string paragraph(std::string_view text, std::size_t columns = kTextColumns,
                                    std::size_t indent = 0, std::size_t used = 0);

/// A line of a result: its name in 17 columns, then what it says, broken behind them.
[[nodiscard]] std::string named_line(std::string_view name, std::string_view what);

/// Columns that a text takes on a terminal: characters, not bytes.
[[nodiscard]] std::size_t columns_of(std::string_view text);

}  // namespace octant::app
