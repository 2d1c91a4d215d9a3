// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "models/support/result.h"

namespace octant::fuzz {

/// Aborts, which a fuzzer takes for a finding, where something does not hold.
inline void must(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

/// An error has a message, and names existing lines.
template <class T>
void must_explain(const Result<T>& result) {
  if (result) return;
  must(!result.error().message().empty(), "an error has a message");
  must(result.error().line >= 0 && result.error().column >= 0, "places count from 1");
}

/// Path of a file of this process, in memory where there is such a place; folders as far as `name` has some.
[[nodiscard]] std::string scratch(const std::string& name);
/// A file with this content.
[[nodiscard]] std::string written(const std::string& name, std::string_view content);

}  // namespace octant::fuzz
