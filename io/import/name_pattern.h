// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: names of beacons, receivers and vehicles within the names of topics and columns.

#include <map>
#include <string>
#include <string_view>

namespace octant::io {

using PatternNames = std::map<std::string, std::string, std::less<>>;

/// Fault of a pattern; empty if it is valid. {beacon}, {receiver} and {vehicle} match a name without a slash,
/// * matches any text.
[[nodiscard]] std::string fault_of_pattern(std::string_view pattern);

/// Returns true if the text matches the pattern; the names in it are added to `names`.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view text, PatternNames& names);

}  // namespace octant::io
