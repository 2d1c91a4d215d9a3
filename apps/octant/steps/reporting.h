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

// Reports of all commands, with the same texts and files.
namespace octant::app {

/// Report options of a command.
struct ReportArgs {
  std::vector<std::string>
      paths;          ///< .html, .md, or .json as a source for the others; - writes a page to standard output
  std::string since;  ///< earlier deployment to compare with
  bool still = false;  ///< without the interactive layer
  bool none = false;
};
/// --report, --report-static, --no-report and, for commands that judge a deployment, --since.
void add_report_options(CLI::App& command, ReportArgs& args, bool with_since);

/// Outputs of a command: `first`, then its reports.
[[nodiscard]] std::vector<OutputOption> report_outputs(const ReportArgs& args,
                                                       std::vector<OutputOption> first = {});
/// Checks the options before the long computation: known file types, existing folders, and a readable earlier
/// deployment.
void check_report(const ReportArgs& args);

/// Report of a calibration, successful or refused.
[[nodiscard]] survey::ReportInput report_input(const Calibration& calibration, const Session& session);
/// Report of a deployment alone.
[[nodiscard]] survey::ReportInput report_input(const Deployment& deployment, const Session& session);
/// Adds fixes and their evaluation.
void add_verification(survey::ReportInput& input, const Localization& localization,
                      const survey::Evaluation& evaluation);
/// Adds the changes since an earlier deployment, if one is given.
void add_changes(survey::ReportInput& input, const std::string& since);

/// Report of a calibration with everything that was asked for, even if it was refused.
[[nodiscard]] survey::ReportInput calibration_report(const Calibration& calibration, const ReportArgs& args,
                                                     const Session& session);
/// Writes deployment (if there is one) and reports, all or none.
void write_calibration(const std::string& output, const ReportArgs& args, const Calibration& calibration,
                       const survey::ReportInput& input);

/// Files of a report for a command that writes them together with its other outputs.
[[nodiscard]] std::vector<io::FileContent> report_files(const ReportArgs& args,
                                                        const survey::ReportInput& input);
/// One line for each report, for people: "report           R.html".
[[nodiscard]] std::string report_lines(const ReportArgs& args);

/// Adds the received and rejected arrivals of each stop and each part of a drive: to the map, and as
/// residuals by stop. With very many stops only those with most rejections or the largest residuals.
void add_stops(const Calibration& calibration, survey::ReportInput& input);
/// Adds the glossary terms that the report uses.
void add_words(survey::ReportInput& input);
/// Deviations of beacons from their positions in the site file, largest first. Control points are at their
/// given positions.
[[nodiscard]] std::vector<survey::MovedNote> moved_from_site(const Calibration& calibration);
/// Summary of an exported calibration in about a dozen lines, beginning with the verdict.
[[nodiscard]] std::string calibration_summary(const Calibration& calibration,
                                              const survey::ReportInput& input);
/// Verdict and next steps in the words of the report.
[[nodiscard]] std::string verdict_text(const survey::ReportInput& input);
[[nodiscard]] Json verdict_json(const survey::ReportInput& input);

}  // namespace octant::app
