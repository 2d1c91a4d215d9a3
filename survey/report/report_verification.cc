// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "survey/drawing/figure_json.h"
#include "survey/drawing/svg_chart.h"
#include "survey/geometry/quantity.h"
#include "survey/report/report_sections.h"

namespace octant::survey {

namespace {

/// A row for each recording or floor.
ReportTable table_of(const std::vector<RunFigures>& runs, const std::string& id, const std::string& title,
                     const std::string& subject) {
  ReportTable table{id,
                    title,
                    {{subject, true},
                     {"fixes"},
                     {"availability [%]"},
                     {"coverage [%]"},
                     {"mean [m]"},
                     {"RMSE [m]"},
                     {"CE95 [m]"},
                     {"VE95 [m]"},
                     {"SE95 [m]"}}};
  for (const RunFigures& run : runs) {
    if (table.rows.size() >= kMaxRows) break;
    const auto metres = [&run](const std::optional<double>& value_m) {
      return number_cell(run.matched > 0 ? value_m : std::nullopt, 1.0, 4);
    };
    table.rows.push_back({{run.name},
                          {fmt::format("{}", run.fixes)},
                          number_cell(run.availability, 100.0, 1),
                          number_cell(run.coverage, 100.0, 1),
                          metres(run.errors.mean_m),
                          metres(run.errors.rmse_m),
                          metres(run.errors.ce95_m),
                          metres(run.errors.ve95_m),
                          metres(run.errors.se95_m)});
  }
  return table;
}

}  // namespace

std::optional<ReportSection> verification_section(const ReportInput& input) {
  if (!input.evaluation) return {};
  const Evaluation& e = *input.evaluation;
  ReportSection section{"verification", "Verification with held-out runs"};
  FactTable table("verification-table",
                  "Fixes of runs that took no part in the calibration, against their reference");
  table.add("fixes", fmt::format("{}, of which {} have a reference", e.fixes, e.matched));
  table.add("no fix", fmt::format("{} epochs or instants", e.no_fix));
  if (e.matched > 0) {
    table.add("position error, mean", length_text(e.errors.mean_m));
    table.add("position error, RMSE", length_text(e.position_rmse_m));
    table.add("position error, 95 %", length_text(e.position_p95_m));
    table.add("position error, largest", length_text(e.max_error_m));
    table.add("horizontal error, CE50", length_text(e.errors.ce50_m));
    table.add("horizontal error, CE95", length_text(e.errors.ce95_m));
    if (e.errors.ve95_m) table.add("vertical error, VE95", length_text(*e.errors.ve95_m));
    if (e.errors.se95_m) table.add("error in space, SE95", length_text(*e.errors.se95_m));
    table.add("availability", fmt::format("{:.1f} % of the epochs or instants", 100 * e.availability));
    table.add("coverage", fmt::format("{:.1f} % of the reference", 100 * e.coverage));
  }
  if (e.latency) {
    table.add("latency, mean",
              fmt::format("{:.3g} s until the last arrival was received", e.latency->mean_s));
    table.add("latency, 95 %", fmt::format("{:.3g} s", e.latency->p95_s));
    table.add("latency, largest", fmt::format("{:.3g} s", e.latency->largest_s));
  }
  if (e.heading_rmse_rad) table.add("heading error, RMSE", fmt::format("{:.4f} rad", *e.heading_rmse_rad));
  if (e.nees_mean)
    table.add("NEES over its degrees of freedom",
              fmt::format("{:.2f} (1: the stated sigmas are honest)", *e.nees_mean));
  section.blocks.emplace_back(std::move(table));
  if (e.runs.size() > 1)
    section.blocks.emplace_back(table_of(e.runs, "verification-runs", "Each run by itself", "run"));
  if (!e.floors.empty())
    section.blocks.emplace_back(table_of(e.floors, "verification-floors",
                                         "Each floor by itself, by the height of the reference", "floor"));
  if (e.error_quantiles_m.size() > 1) {
    const auto& limit = input.plan.deployment.tolerance.fix_m;
    section.blocks.emplace_back(ReportFigure{
        "figure-errors", "Share of the fixes that are closer to the reference than so much.",
        error_curve_svg(e.error_quantiles_m, limit), error_curve_json(e.error_quantiles_m, limit)});
  }
  return section;
}

}  // namespace octant::survey
