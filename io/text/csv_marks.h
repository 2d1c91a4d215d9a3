// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: where the cells of a CSV text end, found many bytes at a time before anything is read.

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace octant::io {

/// Offsets of all commas, newlines and points of a text in their order, and what else there is.
struct CsvMarks {
  std::vector<std::uint32_t> offsets;  ///< may be longer than `count`
  std::size_t count = 0;
  bool has_quote = false, has_nul = false, has_high = false;  ///< high: bytes beyond ASCII

  /// @param text  less than 4 GB
  void find(std::string_view text);
};

}  // namespace octant::io
