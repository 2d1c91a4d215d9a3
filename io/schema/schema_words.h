// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace octant::io {

/// A schema with what people need beside the structure: for each key and column a description, a unit
/// ("x-unit", from the ending of its name) and an example. @param format  site, run, ...
/// @param file  one of those of x-files (tof.csv of run): what is said of it alone; none: all
[[nodiscard]] std::string schema_with_words(std::string_view format, std::string_view file = {});

/// The same as a page of Markdown: a row for each key and column, with its unit, default and example.
[[nodiscard]] std::string schema_page(std::string_view format, std::string_view file = {});

/// Unit that a key's ending states, in words: "m/s" of speed_mps; empty if it states none.
[[nodiscard]] std::string_view unit_of_key(std::string_view key);

}  // namespace octant::io
