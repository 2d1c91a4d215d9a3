// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/survey_page.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "survey/drawing/figure_json.h"
#include "survey/drawing/plotly_js.h"
#include "survey/drawing/survey_plan.h"
#include "survey/geometry/quantity.h"
#include "survey/page/report_html.h"
#include "survey/page/survey_verdict.h"

namespace octant::survey {
namespace {

/// Bins along the longer side of maps: what a screen shows, and what a page can carry.
constexpr std::size_t kBins = 44;

ReportTable figures(const Survey& s) {
  ReportTable table{
      "figures-table",
      "Figures over the floor",
      {{"figure", true}, {"least"}, {"median"}, {"95 %"}, {"largest"}, {"cells without a fix"}}};
  for (const FloorMap& map : s.maps) {
    if (map.name == "mirror" || map.name == "loss_one_beacon") continue;
    const Spread& v = map.spread;
    table.rows.push_back({{map.title},
                          {figure_text(v.min, map.unit)},
                          {figure_text(v.median, map.unit)},
                          {figure_text(v.p95, map.unit)},
                          {figure_text(v.max, map.unit)},
                          {std::to_string(v.without)}});
  }
  return table;
}

ReportTable failures(const Survey& s) {
  ReportTable table{
      "failures-table",
      "If beacons fail, worst first",
      {{"gone", true}, {"hears it"}, {"falls out of tolerance"}, {"loses its fix"}, {"worst left"}}};
  const auto poses = static_cast<double>(s.poses());
  const auto row = [&](const std::string& name, const std::string& heard, const Loss& loss) {
    table.rows.push_back({{name},
                          {heard},
                          {percent_text(static_cast<double>(loss.poses_out) / poses)},
                          {percent_text(static_cast<double>(loss.poses_without_fix) / poses)},
                          {loss.worst_sigma_m > 0 ? figure_text(loss.worst_sigma_m, "m") : "-"}});
  };
  for (const Loss& loss : s.failures)
    row(s.model.beacons[loss.first].name, percent_text(s.heard_fraction[loss.first]), loss);
  for (std::size_t i = 0; i < std::min<std::size_t>(5, s.double_failures.size()); ++i) {
    const Loss& loss = s.double_failures[i];
    row(s.model.beacons[loss.first].name + " and " + s.model.beacons[loss.second].name, "-", loss);
  }
  return table;
}

ReportTable routes(const Survey& s) {
  ReportTable table{
      "routes-table", "Along the routes", {{"route", true}, {"poses"}, {"covered"}, {"median"}, {"worst"}}};
  for (const RouteSurvey& route : s.routes) {
    const Spread& v = route.maps.front().spread;
    table.rows.push_back({{route.name},
                          {std::to_string(route.poses.size())},
                          {percent_text(route.covered_fraction)},
                          {figure_text(v.median, "m")},
                          {v.without > 0 ? "no fix" : figure_text(v.max, "m")}});
  }
  return table;
}

ReportSection firing(const Survey& s, const FloorSchedule& schedule) {
  const FiringPlan& plan = schedule.plan;
  ReportTable table{"schedule-table", "Who fires when", {{"slot", true}, {"fires at"}, {"beacons", true}}};
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    std::string names;
    for (const std::size_t b : plan.groups[g]) names += (names.empty() ? "" : ", ") + s.model.beacons[b].name;
    table.rows.push_back(
        {{std::to_string(g + 1)}, {time_text(static_cast<double>(g) * plan.slot_s)}, {std::move(names)}});
  }
  std::string text = fmt::format(
      "A cycle takes {}: {} slots of {}, after which a pulse has gone (single echoes after {}, all together "
      "after {}; by Kleeman's "
      "eq. 1 after {}), where walls give back {:g} of the amplitude. One by one it takes {}.",
      time_text(plan.cycle_s()), plan.groups.size(), time_text(plan.slot_s),
      time_text(schedule.silent.single_echo_s), time_text(schedule.silent.all_echoes_s),
      time_text(schedule.silent.kleeman_s), schedule.reverberance.wall_reflection,
      time_text(plan.one_by_one_s()));
  ReportSection section{"schedule", "Firing schedule", {ReportText{std::move(text)}, std::move(table)}};
  if (!schedule.warnings.empty()) section.blocks.emplace_back(ReportList{schedule.warnings, false});
  return section;
}

ReportFigure maps(const Survey& s) {
  // First the one that the verdict is about: with the calibration's part where that is known.
  std::vector<const FloorMap*> order;
  for (const FloorMap& map : s.maps) order.insert(map.name == "total_m" ? order.begin() : order.end(), &map);
  const PlanInput plan = survey_plan(s, order, kBins);
  ReportFigure figure{"figure-maps", "The chosen map; each bin holds the worst of its cells.",
                      site_plan_svg(plan), plan_figure_json(plan), "Map"};
  for (const NamedMap& map : plan.maps) figure.layers.push_back(map.name);
  return figure;
}

}  // namespace

ReportDocument survey_document(const Survey& s, const SurveyPageInput& input) {
  ReportDocument document;
  document.title = s.model.name.empty() ? input.input : s.model.name;
  document.subtitle = "Survey of " + input.created;
  const SurveyVerdict v = survey_verdict(s);
  document.grade = to_string(v.grade);
  document.tone = tone_of(v.grade);
  document.sentence =
      v.sentence +
      fmt::format(" {} beacons or more are heard in {}. Looked at: {} beacons, {} cells of {:g} m.",
                  s.coverage, percent_text(s.k_covered_fraction), s.model.beacons.size(), s.grid.cells.size(),
                  s.grid.cell_m);
  document.sections.push_back({"next", "What to do next", {ReportList{v.next, true}}});
  document.sections.push_back({"maps", "Maps", {maps(s)}});
  document.sections.push_back({"figures", "Figures over the floor", {figures(s)}});
  if (!s.failures.empty()) document.sections.push_back({"failures", "If beacons fail", {failures(s)}});
  if (!s.routes.empty()) document.sections.push_back({"routes", "Along the routes", {routes(s)}});
  if (input.schedule) document.sections.push_back(firing(s, *input.schedule));
  if (s.temperature_error_degC) {
    document.sections.push_back(
        {"what-if",
         "What if the air is warmer",
         {ReportText{fmt::format("Air {:g} degrees warmer than stated makes distances {:.0f} ppm wrong.",
                                 *s.temperature_error_degC, 1e6 * s.speed_error)}}});
  }
  if (!input.warnings.empty())
    document.sections.push_back({"warnings", "Warnings", {ReportList{input.warnings, false}}});
  FactTable from("provenance-table", "Enough to run it again");
  from.add("program", input.program);
  from.add("input", input.input);
  if (!input.command.empty()) from.add("command", input.command);
  document.sections.push_back({"provenance", "Where this comes from", {std::move(from)}});
  return document;
}

std::string survey_html(const Survey& s, const SurveyPageInput& input, bool interactive) {
  return to_html(survey_document(s, input), interactive ? plotly_js() : std::string_view{});
}

}  // namespace octant::survey
