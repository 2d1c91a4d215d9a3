// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/deployment.h"
#include "survey/report/report_document.h"
#include "survey/report/report_input.h"

namespace octant::survey {

enum class Grade {
  kGood,
  kUnjudged,      ///< no fault was found, but the site states no tolerance for comparison
  kPoor,          ///< a gate is not kept
  kContradicted,  ///< the data speak against what the site file states
  kRefused        ///< no deployment was exported
};
[[nodiscard]] const char* to_string(Grade grade);
/// The colour that says what the grade says.
[[nodiscard]] Tone tone_of(Grade grade);

/// A condition for the verdict, with its figures in words.
struct ReportGate {
  std::string name, value, limit;
  bool pass = false;
};

/// Verdict on the result.
struct Verdict {
  Grade grade = Grade::kUnjudged;
  std::string sentence;
  std::vector<ReportGate> gates;
};
[[nodiscard]] Verdict verdict(const ReportInput& input);

/// Next actions and measurements, most urgent first; never empty.
[[nodiscard]] std::vector<std::string> next_steps(const ReportInput& input);

/// "343.21 m/s, sigma 0.04 m/s, at 21 degC (model cramer1993)".
[[nodiscard]] std::string speed_in_words(const Deployment& deployment);
/// "3 dB less at 22.5 degrees off the axis, sigma 0.1 degrees". @param deployment  with a directional
/// attenuation
[[nodiscard]] std::string directivity_in_words(const Deployment& deployment);

/// The content of the report: verdict, plan, beacons, verification, residuals, weak directions, loss of a
/// beacon, changes, next steps, provenance. Sections without data are left out.
[[nodiscard]] ReportDocument report_document(const ReportInput& input);

struct ReportOptions {
  bool interactive = true;  ///< with plotly.js inside, where it was at hand when the program was built
};
/// The report as one self-contained HTML page. It loads no external resource (content security policy
/// `default-src 'none'`), is complete without a script, has light and dark colours, and can be printed.
[[nodiscard]] std::string report_html(const ReportInput& input, const ReportOptions& options = {});
/// The report as text, without the drawings.
[[nodiscard]] std::string report_markdown(const ReportInput& input);

}  // namespace octant::survey
