// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "survey/geometry/quantity.h"

namespace octant::app {

/// Columns of text for people.
struct Table {
  std::string align;                           ///< a letter for each column: l or r
  std::vector<std::vector<std::string>> rows;  ///< the first is the heading
  [[nodiscard]] std::string text() const;
};

using survey::length_text;
using survey::length_unit;
using survey::time_text;
using survey::time_unit;
using survey::Unit;
/// A field of a CSV row, in quotes where it needs them (RFC 4180).

}  // namespace octant::app
