// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/.

#include <string>

#include <nlohmann/json.hpp>

namespace octant::io {

/// SHA-256 of a deployment's content without its `digest` and `signature`: keys sorted, no blanks, shortest
/// numbers. Layout does not matter.
[[nodiscard]] std::string digest_of(nlohmann::json json);

}  // namespace octant::io
