// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "survey/drawing/figure_json.h"
#include "survey/drawing/site_plan.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

/// Number of maps, the worst ones, that keeps the page small.
constexpr std::size_t kMostMaps = 12;

}  // namespace

std::optional<ReportSection> loss_section(const ReportInput& input) {
  if (input.losses.empty()) return {};
  ReportSection section{"loss", "When a beacon falls silent"};
  const std::string figure = input.loss_name + (input.loss_unit.empty() ? "" : " [" + input.loss_unit + "]");
  ReportTable table{
      "loss-table",
      "The site without one of its beacons, worst first: how much of the area still has a fix, and " +
          input.loss_name + " there.",
      {{"without", true}, {"covered [%]"}, {figure + ", median"}, {"95 %"}}};
  PlanInput plan;
  plan.deployment = input.plan.deployment;
  ReportFigure drawing{
      "figure-loss",
      fmt::format("{} over the site when the chosen beacon (crossed out) is silent.", input.loss_name),
      {},
      {},
      "Silent beacon"};
  const auto add = [&](const BeaconLoss& loss, const std::string& name) {
    if (table.rows.size() < kMaxRows)
      table.rows.push_back({{name},
                            {fmt::format("{:.1f}", 100 * loss.covered_fraction)},
                            number_cell(loss.median, 1, 2),
                            number_cell(loss.p95, 1, 2)});
    if (!loss.map || plan.maps.size() >= kMostMaps) return;
    plan.maps.push_back(*loss.map);
    plan.maps.back().silent_beacon = loss.beacon;
    drawing.layers.push_back(name);
  };
  if (input.no_loss) add(*input.no_loss, "none, all at work");
  for (const auto& loss : input.losses) add(loss, loss.beacon);
  if (!plan.maps.empty()) {
    NamedMap together;
    for (const auto& map : plan.maps)
      together.values.insert(together.values.end(), map.values.begin(), map.values.end());
    for (auto& map : plan.maps)
      map.limits = map_classes(together);  // one scale, so that they can be compared
    drawing.svg = site_plan_svg(plan);
    drawing.interactive = plan_figure_json(plan);
    section.blocks.emplace_back(std::move(drawing));
  }
  if (plan.maps.size() == kMostMaps && input.losses.size() >= kMostMaps)
    section.blocks.emplace_back(ReportText{"Maps of the beacons whose loss is worst."});
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace octant::survey
