// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace octant::survey {

/// Text made safe for XML and HTML, in content and in quoted attributes.
[[nodiscard]] std::string escape_xml(const std::string& text);

/// Escapes text content only, for readers that support few entities; quotes and control characters are
/// unchanged.
[[nodiscard]] std::string escape_markup(const std::string& text);
/// Text that Markdown takes as text.
[[nodiscard]] std::string escape_markdown(const std::string& text);

/// ASCII JSON text that may stand inside a script element: <, > and & as \u003c and the like.
[[nodiscard]] std::string escape_script_json(const std::string& json);

}  // namespace octant::survey
