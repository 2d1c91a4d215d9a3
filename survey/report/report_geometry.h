// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "survey/report/report.h"

namespace octant::survey {

/// Adds to a report what the deployment's geometry is worth over the calibrated area: maps of the dilution of
/// precision, of the expected error of a fix and of its protection level, and what becomes of that error when
/// one beacon falls silent. Free air is assumed: what a scene file says of walls is the business of `octant
/// survey`. Nothing is added where that cannot be told.
void add_geometry(ReportInput& input, int threads);

}  // namespace octant::survey
