// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "io/text/atomic_file.h"
#include "survey/report/report.h"
#include "survey/report/report_geometry.h"

// Reports as all commands write them: the same words, the same files.
namespace octant::app {

/// What the user says of reports.
struct ReportArgs {
  std::vector<std::string>
      paths;           ///< .html, .md, or .json to make others from later; - is a page on standard output
  std::string since;   ///< an earlier deployment, to say what changed
  bool still = false;  ///< without the interactive layer
  bool none = false;
};
/// --report, --report-static, --no-report and, where a deployment is judged, --since.
void add_report_options(CLI::App& command, ReportArgs& args, bool with_since);

/// The outputs of a command: `first`, then its reports.
[[nodiscard]] std::vector<OutputOption> report_outputs(const ReportArgs& args,
                                                       std::vector<OutputOption> first = {});
/// Before the long computation: endings that are understood, folders that exist, an earlier deployment that
/// can be read.
void check_report(const ReportArgs& args);

/// What a calibration says, converged or refused.
[[nodiscard]] survey::ReportInput report_input(const Calibration& calibration, const Session& session);
/// What a deployment alone says.
[[nodiscard]] survey::ReportInput report_input(const Deployment& deployment, const Session& session);
/// Adds fixes and their evaluation.
void add_verification(survey::ReportInput& input, const Localization& localization,
                      const survey::Evaluation& evaluation);
/// Adds the changes since an earlier deployment, if one is given.
void add_changes(survey::ReportInput& input, const std::string& since);

/// The report of a calibration with all that the user asked for; of a refused one too.
[[nodiscard]] survey::ReportInput calibration_report(const Calibration& calibration, const ReportArgs& args,
                                                     const Session& session);
/// Deployment (where there is one) and reports, all or none.
void write_calibration(const std::string& output, const ReportArgs& args, const Calibration& calibration,
                       const survey::ReportInput& input);

/// The files of a report, not yet written: so that a command can write them together with its other outputs.
[[nodiscard]] std::vector<io::FileContent> report_files(const ReportArgs& args,
                                                        const survey::ReportInput& input);
/// "report           R.html", a line each, for people.
[[nodiscard]] std::string report_lines(const ReportArgs& args);

/// Adds what was heard and left out at each stop and on each stretch of a drive: on the map, and residuals by
/// stop. Of very many those where most was left out, or whose residuals are largest.
void add_stops(const Calibration& calibration, survey::ReportInput& input);
/// Adds the words of the glossary that the report uses.
void add_words(survey::ReportInput& input);
/// Beacons against where the site file has them, farthest first; control points are where it has them.
[[nodiscard]] std::vector<survey::MovedNote> moved_from_site(const Calibration& calibration);
/// A calibration that was exported in the dozen lines that everybody reads, the verdict first.
[[nodiscard]] std::string calibration_summary(const Calibration& calibration,
                                              const survey::ReportInput& input);
/// Verdict and next steps for people, in the words of the report.
[[nodiscard]] std::string verdict_text(const survey::ReportInput& input);
[[nodiscard]] Json verdict_json(const survey::ReportInput& input);

}  // namespace octant::app
