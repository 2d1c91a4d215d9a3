// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/support/result.h"
#include "survey/report/report.h"

namespace octant::app {

/// Saves the content of a report, from which `octant report` makes other formats: type "octant_report",
/// version 1. Unlike a deployment it can be read only by the version of the program that wrote it.
[[nodiscard]] std::string report_to_json(const survey::ReportInput& input);
/// Reads a saved report: read(write(x)) == x.
[[nodiscard]] Result<survey::ReportInput> report_from_json(const std::string& text, const std::string& file);
/// Returns true if a text declares itself as a saved report.
[[nodiscard]] bool is_saved_report(const std::string& text);

}  // namespace octant::app
