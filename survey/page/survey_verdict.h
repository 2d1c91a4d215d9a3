// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "survey/map/survey.h"
#include "survey/report/report.h"

namespace octant::survey {

/// Verdict on a geometry: Good if at most one cell in a hundred has no fix within the site's tolerance; not
/// judged if the site states no tolerance.
struct SurveyVerdict {
  Grade grade = Grade::kUnjudged;  ///< kGood, kPoor or kUnjudged
  std::string sentence;            ///< with how much of the floor is inside, beyond, and without a fix
  std::vector<std::string> next;   ///< actions, most urgent first; never empty
};
[[nodiscard]] SurveyVerdict survey_verdict(const Survey& survey);

}  // namespace octant::survey
