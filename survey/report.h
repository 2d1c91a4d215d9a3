// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "survey/evaluate.h"
#include "survey/site_plan.h"

namespace octant::survey {

/// A combination of parameters of which the data say little, in words.
struct WeakNote {
  std::string description;
  std::string remedy;
  double consequence_m = 0.0;  ///< at the robot
};

/// Arrivals left out, by reason in words.
struct LeftOutNote {
  std::string reason;
  std::size_t count = 0;
};

/// All that a report says, as plain values: what a calibration found, and if there is one the check against a reference.
struct ReportInput {
  PlanInput plan;
  std::vector<WeakNote> weak;
  std::vector<LeftOutNote> left_out;
  std::vector<std::string> warnings;
  std::optional<Evaluation> evaluation;
};

/// What to think of it in one sentence, and whether that is good.
struct Verdict {
  bool good = false;
  std::string sentence;
};
[[nodiscard]] Verdict verdict(const ReportInput& input);

/// "343.21 m/s, sigma 0.04 m/s, at 21 degC (model cramer1993)".
[[nodiscard]] std::string speed_in_words(const Deployment& deployment);

/// The report as one self-contained HTML page: no script, nothing fetched (content security policy `default-src 'none'`),
/// light and dark, prints on paper.
[[nodiscard]] std::string report_html(const ReportInput& input);

}  // namespace octant::survey
