// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace octant::io {

/// JSON Schema (draft 2020-12) of one of the formats: "site", "run", "deployment", "scenario", "scene",
/// "batch", "live", "fixes", "survey", "columns", "topics", "cockpit", "defaults"; empty for another name.
/// Each key, and each column of a format's files ("x-files"), has a description, a unit ("x-unit") and an
/// example.
[[nodiscard]] std::string_view schema(std::string_view format);

/// The part of a format's schema for one of its x-files (tof.csv of run); the whole schema if it has no such
/// file.
[[nodiscard]] std::string schema_of_file(std::string_view format, std::string_view file);

/// The schema as a page of Markdown: a row for each key and column, with its unit, default and example.
[[nodiscard]] std::string schema_page(std::string_view format, std::string_view file = {});

}  // namespace octant::io
