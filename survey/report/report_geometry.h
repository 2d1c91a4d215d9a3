// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "survey/report/report.h"

namespace octant::survey {

/// Adds the quality of the deployment's geometry over the calibrated area to a report: maps of the dilution
/// of precision, of the expected error of a fix and of its protection level, and that error when one beacon
/// fails. Free space is assumed; `octant survey` considers the walls of a scene file. The report is unchanged
/// if the geometry cannot be evaluated.
void add_geometry(ReportInput& input, int threads);

}  // namespace octant::survey
