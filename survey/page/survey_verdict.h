// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "survey/map/survey.h"
#include "survey/report/report.h"

namespace octant::survey {

/// What to think of a geometry. Good where no more than one cell in a hundred lacks a fix within the site's
/// tolerance; not judged where the site states none.
struct SurveyVerdict {
  Grade grade = Grade::kUnjudged;  ///< kGood, kPoor or kUnjudged
  std::string sentence;            ///< with how much of the floor is inside, beyond, and without a fix
  std::vector<std::string> next;   ///< what to do about it, most urgent first; never empty
};
[[nodiscard]] SurveyVerdict survey_verdict(const Survey& survey);

}  // namespace octant::survey
