// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the schemas that schema() gives, one file each.
//
// Readers, writers and schemas are written apart, on purpose. A key is one line in a reader (its range, its
// unit and the words of its error are arguments there) and one in a schema; a table of both would need a
// function for each key that finds its place, and one for what keys ask of each other (one of two, needs a
// third), and came out longer. That they agree is a test: tests/io/schema/schema_keys_test.cc. They are texts
// in sources, not data files, so that a library that is linked needs neither a folder nor a generator.

#include <string>
#include <string_view>

namespace octant::io {

[[nodiscard]] std::string_view site_schema();
[[nodiscard]] std::string_view run_schema();
[[nodiscard]] std::string_view deployment_schema();
[[nodiscard]] std::string_view batch_schema();
[[nodiscard]] std::string_view scene_schema();
[[nodiscard]] std::string_view live_schema();
[[nodiscard]] std::string_view fixes_schema();
[[nodiscard]] std::string_view survey_schema();
[[nodiscard]] std::string_view columns_schema();
[[nodiscard]] std::string_view topics_schema();
[[nodiscard]] std::string_view defaults_schema();
/// Properties of a scene, for the schemas that hold one.
[[nodiscard]] std::string_view scene_properties();
/// Lines "path | example | description" of the keys and columns of a format; a column's path is FILE:NAME.
/// A description that begins with "+ " goes behind the schema's.
[[nodiscard]] std::string_view key_words(std::string_view format);
/// Those of what Octant writes.
[[nodiscard]] std::string_view written_key_words(std::string_view format);

}  // namespace octant::io
