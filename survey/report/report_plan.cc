// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <fmt/format.h>

#include "survey/drawing/figure_json.h"
#include "survey/drawing/plan_frame.h"
#include "survey/drawing/site_plan.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

bool anything_placed(const PlanInput& plan) {
  return std::ranges::any_of(plan.deployment.beacons,
                             [](const auto& b) { return b.status != BeaconStatus::kUndetermined; }) ||
         std::ranges::any_of(plan.tracks, [](const auto& t) { return !t.points_m.empty(); });
}

/// Shifts of the beacons that moved.
std::vector<PlanMove> moves_of(const ReportInput& input) {
  std::vector<PlanMove> moves;
  if (input.changes)
    for (const BeaconChange& c : input.changes->beacons)
      if (c.moved()) moves.push_back({c.name, c.shift_m});
  return moves;
}

}  // namespace

std::optional<ReportSection> plan_section(const ReportInput& input) {
  if (!anything_placed(input.plan)) return {};
  ReportSection section{"plan", "Plan of the site"};
  PlanInput drawn = input.plan;
  drawn.moves = moves_of(input);
  ReportFigure plan{"figure-plan",
                    fmt::format("The site from above: calibrated beacons (discs), control points held fixed "
                                "(triangles), 95 % error ellipses (2.45 sigma, drawn {:g} times as large as "
                                "they are), the calibrated area (dashed) and where the vehicle was.",
                                ellipse_exaggeration(drawn.deployment, plan_frame(drawn).extent_m())),
                    site_plan_svg(drawn), plan_figure_json(drawn)};
  if (!input.plan.maps.empty()) {
    plan.legend = "Map";
    for (const auto& map : input.plan.maps)
      plan.layers.push_back(map.unit.empty() ? map.name : map.name + " [" + map.unit + "]");
  }
  section.blocks.emplace_back(std::move(plan));
  section.blocks.emplace_back(ReportFigure{"figure-space",
                                           "The site from the side; in space with 95 % error ellipsoids "
                                           "(2.80 sigma) where the page may run its script.",
                                           elevation_svg(input.plan), space_figure_json(input.plan)});
  std::size_t states = 0, shown = 0;
  for (const auto& track : input.plan.tracks) {
    states += std::max(track.thinned_from, track.points_m.size());
    shown += thinned(track.points_m).size();
  }
  if (shown < states)
    section.blocks.emplace_back(ReportText{fmt::format("Of {} vehicle states {} are drawn.", states, shown)});
  return section;
}

}  // namespace octant::survey
