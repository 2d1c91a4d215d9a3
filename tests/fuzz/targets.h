// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace octant::fuzz {

/// A reader, and a check of everything that it accepts, which aborts on failure.
struct Target {
  std::string name;  ///< also of its folder in corpus/
  void (*take)(std::string_view input);
  long strokes = 300;  ///< number of mutations of its corpus in the tests
};
[[nodiscard]] const std::vector<Target>& targets();

}  // namespace octant::fuzz
