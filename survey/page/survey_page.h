// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "survey/map/survey.h"
#include "survey/report/report_document.h"
#include "survey/schedule/floor_schedule.h"

namespace octant::survey {

struct SurveyPageInput {
  std::string input;  ///< file that was surveyed, as the user wrote it
  std::string created, program, command;
  std::vector<std::string> warnings;
  std::optional<FloorSchedule> schedule;
};

/// A survey as a document: figures, maps to choose from, failures, routes, firing schedule, what was assumed.
[[nodiscard]] ReportDocument survey_document(const Survey& survey, const SurveyPageInput& input);

/// Writes the survey as one self-contained HTML page.
/// @param interactive  with plotly.js, if it was available when the program was built
[[nodiscard]] std::string survey_html(const Survey& survey, const SurveyPageInput& input,
                                      bool interactive = true);

}  // namespace octant::survey
