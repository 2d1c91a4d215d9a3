// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/support/result.h"
#include "survey/report/report.h"

namespace octant::app {

/// A report's content as a file, from which `octant report` makes any form of it: type "octant_report",
/// version 1. It belongs to the version of the program that wrote it, unlike a deployment.
[[nodiscard]] std::string report_to_json(const survey::ReportInput& input);
/// Reads it back: read(write(x)) == x.
[[nodiscard]] Result<survey::ReportInput> report_from_json(const std::string& text, const std::string& file);
/// Whether a text calls itself a saved report.
[[nodiscard]] bool is_saved_report(const std::string& text);

}  // namespace octant::app
