// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: writing YAML.

#include <string>
#include <string_view>

#include "io/text/text.h"

namespace octant::io {

/// A name as a YAML scalar: plain where every YAML reader takes it for a text, in double quotes otherwise
/// ("no", "1e5", "a: b").
[[nodiscard]] std::string yaml_text(std::string_view text);

}  // namespace octant::io
