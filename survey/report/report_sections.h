// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "survey/report/report_document.h"
#include "survey/report/report_input.h"

namespace octant::survey {

// The sections of a report, one file each: report_verdict.cc, report_plan.cc, ... No value if a section has
// no content.
[[nodiscard]] std::optional<ReportSection> verdict_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> plan_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> beacons_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> verification_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> residuals_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> weak_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> left_out_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> words_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> loss_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> changes_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> next_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> warnings_section(const ReportInput& input);
[[nodiscard]] std::optional<ReportSection> provenance_section(const ReportInput& input);

/// A report's table has no more rows than this; it says where the rest is.
inline constexpr std::size_t kMaxRows = 400;

/// Longer half axis of the horizontal 95 % ellipse [m].
[[nodiscard]] double radius95_m(const DeploymentBeacon& beacon);
[[nodiscard]] std::string in_words(BeaconStatus status);
/// With a capital letter and a full stop.
[[nodiscard]] std::string as_sentence(std::string text);
/// A cell of a number that may be missing: "-".
[[nodiscard]] ReportText number_cell(const std::optional<double>& value, double per_si, int digits);

}  // namespace octant::survey
