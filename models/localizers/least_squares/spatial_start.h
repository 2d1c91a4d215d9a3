// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/localizers/least_squares/epoch_fix.h"

namespace octant {

/// Start of a spatial fix (6 degrees of freedom): the origin by linear multilateration with the lever arms
/// neglected, a coarse set of rotations, each settled under a one-sided loss; the best by its cost. Sets the
/// node; found is false where the arrivals are too few. Returns whether a distinct second pose is as good.
[[nodiscard]] bool start_spatial(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                 const EpochFixOptions& options, bool& found);

}  // namespace octant
