// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "survey/drawing/figure_json.h"
#include "survey/drawing/svg_chart.h"
#include "survey/geometry/quantity.h"
#include "survey/report/report_sections.h"

namespace octant::survey {

std::optional<ReportSection> verification_section(const ReportInput& input) {
  if (!input.evaluation) return {};
  const Evaluation& e = *input.evaluation;
  ReportSection section{"verification", "Verification with held-out runs"};
  FactTable table("verification-table",
                  "Fixes of runs that took no part in the calibration, against their reference");
  table.add("fixes", fmt::format("{}, of which {} have a reference", e.fixes, e.matched));
  table.add("no fix", fmt::format("{} epochs or instants", e.no_fix));
  if (e.matched > 0) {
    table.add("position error, RMSE", length_text(e.position_rmse_m));
    table.add("position error, 95 %", length_text(e.position_p95_m));
    table.add("position error, largest", length_text(e.max_error_m));
  }
  if (e.heading_rmse_rad) table.add("heading error, RMSE", fmt::format("{:.4f} rad", *e.heading_rmse_rad));
  if (e.nees_mean)
    table.add("NEES over its degrees of freedom",
              fmt::format("{:.2f} (1: the stated sigmas are honest)", *e.nees_mean));
  section.blocks.emplace_back(std::move(table));
  if (e.error_quantiles_m.size() > 1) {
    const auto& limit = input.plan.deployment.tolerance.fix_m;
    section.blocks.emplace_back(ReportFigure{
        "figure-errors", "Share of the fixes that are closer to the reference than so much.",
        error_curve_svg(e.error_quantiles_m, limit), error_curve_json(e.error_quantiles_m, limit)});
  }
  return section;
}

}  // namespace octant::survey
