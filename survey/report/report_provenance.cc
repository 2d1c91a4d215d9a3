// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report/report_sections.h"

namespace octant::survey {

std::optional<ReportSection> warnings_section(const ReportInput& input) {
  if (input.warnings.empty()) return {};
  ReportList list{input.warnings, false};
  if (list.items.size() > kMaxRows) {
    list.items.resize(kMaxRows);
    list.items.push_back(std::to_string(input.warnings.size() - kMaxRows) +
                         " more; the program lists them all with --json.");
  }
  return ReportSection{"warnings", "Warnings", {std::move(list)}};
}

std::optional<ReportSection> provenance_section(const ReportInput& input) {
  const Deployment& d = input.plan.deployment;
  ReportSection section{"provenance", "Where this comes from"};
  FactTable table("provenance-table", "Enough to run it again");
  const auto row = [&](std::string what, std::string value) {
    if (!value.empty()) table.add(std::move(what), std::move(value));
  };
  row("program", d.program_version.empty() ? "" : "octant " + d.program_version);
  row("calibrated", d.created);
  row("command", d.program_command);
  if (input.command != d.program_command) row("report by", input.command);
  for (const auto& option : input.options) row("option", option);
  section.blocks.emplace_back(std::move(table));
  ReportTable inputs{"inputs", "Files that were read, by their SHA-256", {{"file", true}, {"sha256", true}}};
  for (const auto& file : d.inputs)
    if (inputs.rows.size() < kMaxRows) inputs.rows.push_back({{file.path}, {file.sha256}});
  if (!inputs.rows.empty()) section.blocks.emplace_back(std::move(inputs));
  return section;
}

}  // namespace octant::survey
