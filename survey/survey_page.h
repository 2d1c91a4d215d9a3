// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "survey/survey.h"

namespace octant::survey {

struct SurveyPageInput {
  std::string input;    ///< file that was surveyed, as the user wrote it
  std::string created, program;
  std::vector<std::string> warnings;
};

/// A survey as one HTML page without scripts: figures, a map each, failures, routes, what was assumed.
[[nodiscard]] std::string survey_html(const Survey& survey, const SurveyPageInput& input);

}  // namespace octant::survey
