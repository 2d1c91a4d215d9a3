// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "calib/stream/chunks/chunk_index.h"
#include "models/arrival_source.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::calib {

/// Evenly spaced epochs of the stops of a run that is not in memory (see subsample_of in long_log.h). Reads
/// the blocks with those epochs, and all blocks again if a beacon is received so rarely that they are not
/// enough.
[[nodiscard]] Result<MeasurementLog> subsample_of_stops(std::size_t run, const Site& site,
                                                        const ArrivalSource& source, const ChunkIndex& index,
                                                        int threads = 1);

}  // namespace octant::calib
