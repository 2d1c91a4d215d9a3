// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the files of io/schema/data as texts, which octant_embed() compiles into the library.
//
// Readers, writers and schemas are separate on purpose. A key is one line in a reader (with its range, its
// unit and the words of its errors) and one object in a schema. A common table would need one function for
// each key that accesses its variable and one for the dependencies between keys (one of two, requires a
// third), and was longer. tests/io/schema/schema_keys_test.cc tests that they agree.

#include <string_view>

namespace octant::io {

[[nodiscard]] std::string_view batch_schema();
[[nodiscard]] std::string_view cockpit_schema();
[[nodiscard]] std::string_view columns_schema();
[[nodiscard]] std::string_view defaults_schema();
[[nodiscard]] std::string_view deployment_schema();
[[nodiscard]] std::string_view fixes_schema();
[[nodiscard]] std::string_view live_schema();
[[nodiscard]] std::string_view run_schema();
[[nodiscard]] std::string_view scenario_schema();
[[nodiscard]] std::string_view scene_schema();
/// Without the keys of its scene, which are those of scene_schema().
[[nodiscard]] std::string_view site_schema();
[[nodiscard]] std::string_view survey_schema();
[[nodiscard]] std::string_view topics_schema();

}  // namespace octant::io
