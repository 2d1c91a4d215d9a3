// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <fmt/format.h>

#include "survey/geometry/quantity.h"
#include "survey/report/report.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

ReportTable adjustment_table(const ReportInput& input) {
  const Deployment& d = input.plan.deployment;
  const CalibrationStatistics& s = d.statistics;
  FactTable table("adjustment", "The adjustment as a whole");
  table.add("datum", d.datum.description);
  if (input.outcome == Outcome::kCalibrated) table.add("speed", speed_in_words(d));
  if (d.attenuation) {
    table.add(
        "time-walk",
        fmt::format("{:.4g} V at 1 m, absorption {:.4g} Np/m, threshold {:.4g} V, rise time constant {}",
                    d.attenuation->amplitude_1m_v, d.attenuation->absorption_np_per_m,
                    d.attenuation->threshold_v, time_symbol_text(d.attenuation->rise_time_s)));
    if (d.attenuation->directional()) table.add("receivers", directivity_in_words(d));
  }
  table.add("arrivals", fmt::format("{} used, {} left out", s.arrivals, s.rejected));
  for (const auto& note : input.left_out) table.add("left out: " + note.reason, std::to_string(note.count));
  table.add("unknowns", fmt::format("{}, redundancy {:.0f}", s.unknowns, s.redundancy));
  table.add("variance factor", fmt::format("{:.4g} (1 where the stated noise is right; p = {:.3g})",
                                           s.variance_factor, s.chi2_p));
  table.add("residuals, RMS", time_symbol_text(s.rms_s));
  return table;
}

}  // namespace

std::optional<ReportSection> weak_section(const ReportInput& input) {
  ReportSection section{"determined", "What the data determine"};
  if (input.weak.empty()) {
    section.blocks.emplace_back(ReportText{"No combination of parameters is weak beside the tolerance."});
  } else {
    ReportList list;
    for (const auto& weak : input.weak) {
      std::string text = weak.blocking ? "Not determined: " + weak.description : weak.description;
      if (weak.consequence_m > 0 && std::isfinite(weak.consequence_m))
        text += fmt::format(", up to {} at the robot", length_text(weak.consequence_m));
      list.items.push_back(as_sentence(text) +
                           (weak.remedy.empty() ? "" : " Settled by: " + weak.remedy + "."));
    }
    section.blocks.emplace_back(std::move(list));
  }
  if (!input.plan.deployment.datum.description.empty() || input.plan.deployment.statistics.arrivals > 0)
    section.blocks.emplace_back(adjustment_table(input));
  return section;
}

}  // namespace octant::survey
