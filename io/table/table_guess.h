// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the columns of a table without a description.

#include <string>
#include <vector>

#include "io/table/table_layout.h"

namespace octant::io {

/// Guesses the columns: by their names in English and German, and in a table without a header line by their
/// cells. Adds a line for each column to `lines`. Errors: kBadInput with the columns of the table and the
/// option that names them.
[[nodiscard]] Result<TableMapping> guess_columns(const TableLayout& layout, const std::string& path,
                                                 const TableMapping& stated, std::vector<std::string>& lines);

}  // namespace octant::io
