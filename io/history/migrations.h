// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/history/.

#include "io/history/sql.h"

namespace octant::io {

/// Brings an empty or older history to the tables of today, one version after the other, each whole or not at
/// all. Errors: a newer history, a database of another program.
[[nodiscard]] Result<void> migrate(SqlStore& store);

}  // namespace octant::io
