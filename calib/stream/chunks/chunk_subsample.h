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

/// Evenly spread epochs of the stops of a run that is not in memory (see subsample_of in long_log.h). Reads
/// the blocks in which those epochs lie; all blocks once more where a beacon is heard so seldom that they are
/// not enough of it.
[[nodiscard]] Result<MeasurementLog> subsample_of_stops(std::size_t run, const Site& site,
                                                        const ArrivalSource& source, const ChunkIndex& index,
                                                        int threads = 1);

}  // namespace octant::calib
