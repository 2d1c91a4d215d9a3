// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Where arrivals were left out, and what the report's words mean.
#include <algorithm>

#include <fmt/format.h>

#include "survey/drawing/site_plan.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

ReportTable left_out_table(const ReportInput& input) {
  ReportTable table{"left-out-table",
                    "Places where arrivals were left out, most first",
                    {{"stop", true}, {"x [m]"}, {"y [m]"}, {"used"}, {"late"}, {"early"}, {"other"}},
                    {},
                    true};
  std::vector<const StopNote*> order;
  for (const StopNote& stop : input.stops)
    if (stop.left_out() > 0) order.push_back(&stop);
  std::ranges::stable_sort(
      order, [](const StopNote* a, const StopNote* b) { return a->left_out() > b->left_out(); });
  order.resize(std::min(order.size(), kMaxRows));
  for (const StopNote* stop : order)
    table.rows.push_back({{stop->name},
                          {fmt::format("{:.2f}", stop->at_m.x())},
                          {fmt::format("{:.2f}", stop->at_m.y())},
                          {std::to_string(stop->used)},
                          {std::to_string(stop->late)},
                          {std::to_string(stop->early)},
                          {std::to_string(stop->other)}});
  return table;
}

}  // namespace

std::optional<ReportSection> left_out_section(const ReportInput& input) {
  if (input.misses.empty()) return {};
  ReportSection section{"left-out", "Where arrivals were left out"};
  const CalibrationStatistics& s = input.plan.deployment.statistics;
  std::string what = fmt::format("{} of {} arrivals were left out", s.rejected, s.arrivals + s.rejected);
  for (const LeftOutNote& note : input.left_out)
    what += fmt::format("{}{} {}", &note == &input.left_out.front() ? ": " : ", ", note.count, note.reason);
  section.blocks.emplace_back(ReportText{
      what +
      ". A beacon with many long lines stands behind something, or elsewhere; a place with a large "
      "disc and lines to all sides was not one place: the vehicle moved there. Where the lines of "
      "several beacons cross there is something that reflects or hides."});
  PlanInput drawn;
  drawn.deployment = input.plan.deployment;
  drawn.tracks = input.plan.tracks;
  // If there are very many beacons, only those to which a line refers.
  if (drawn.deployment.beacons.size() > kMostNamed)
    std::erase_if(drawn.deployment.beacons, [&](const DeploymentBeacon& b) {
      return std::ranges::none_of(input.misses, [&](const PlanMiss& miss) { return miss.beacon == b.name; });
    });
  drawn.misses = input.misses;
  section.blocks.emplace_back(ReportFigure{
      "figure-left-out",
      "The site from above: a line from the vehicle to each beacon of which arrivals were left out there; "
      "solid: late (echo), dashed: early (spurious), dotted: for another reason. A disc's area says how "
      "many.",
      site_plan_svg(drawn)});
  if (ReportTable table = left_out_table(input); !table.rows.empty())
    section.blocks.emplace_back(std::move(table));
  return section;
}

std::optional<ReportSection> words_section(const ReportInput& input) {
  if (input.words.empty()) return {};
  ReportTable table{"words-table", "Words of this report", {{"word", true}, {"what it means", true}}};
  for (const auto& [word, meaning] : input.words) table.rows.push_back({{word}, {meaning}});
  return ReportSection{"words", "What the words mean", {std::move(table)}};
}

}  // namespace octant::survey
