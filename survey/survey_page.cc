// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/survey_page.h"

#include <cmath>

#include <fmt/format.h>

#include "survey/map_svg.h"
#include "survey/site_plan.h"

namespace octant::survey {
namespace {

constexpr const char* kHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<style>
:root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem}
table{border-collapse:collapse;margin:.5rem 0}td,th{padding:.15rem .7rem;text-align:right;border-bottom:1px solid #8884}
td:first-child,th:first-child{text-align:left}figure{margin:1rem 0}svg{max-width:100%;height:auto}.big{font-size:1.3rem}
</style>
)";

std::string percent(double fraction) { return fmt::format("{:.1f} %", 100 * fraction); }

std::string figures(const Survey& s) {
  std::string html = "<h2>Figures over the floor</h2><table><tr><th>figure</th><th>least</th><th>median</th><th>95 %</th><th>largest</th><th>no fix</th></tr>\n";
  for (const FloorMap& map : s.maps) {
    if (map.name == "mirror" || map.name == "loss_one_beacon") continue;
    const Spread& v = map.spread;
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape_xml(map.title), figure_text(v.min, map.unit),
                        figure_text(v.median, map.unit), figure_text(v.p95, map.unit), figure_text(v.max, map.unit), v.without);
  }
  return html + "</table>\n";
}

std::string failures(const Survey& s) {
  if (s.failures.empty()) return "";
  std::string html = "<h2>If beacons fail</h2><table><tr><th>gone</th><th>hears it</th><th>falls out of tolerance</th><th>loses its fix</th><th>worst left</th></tr>\n";
  const auto poses = static_cast<double>(s.poses());
  const auto row = [&](const std::string& name, const std::string& heard, const Loss& loss) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape_xml(name), heard, percent(static_cast<double>(loss.poses_out) / poses),
                        percent(static_cast<double>(loss.poses_without_fix) / poses), loss.worst_sigma_m > 0 ? figure_text(loss.worst_sigma_m, "m") : "-");
  };
  for (const Loss& loss : s.failures) row(s.model.beacons[loss.first].name, percent(s.heard_fraction[loss.first]), loss);
  for (std::size_t i = 0; i < std::min<std::size_t>(5, s.double_failures.size()); ++i) {
    const Loss& loss = s.double_failures[i];
    row(s.model.beacons[loss.first].name + " and " + s.model.beacons[loss.second].name, "", loss);
  }
  return html + "</table>\n";
}

std::string routes(const Survey& s) {
  if (s.routes.empty()) return "";
  std::string html = "<h2>Along the routes</h2><table><tr><th>route</th><th>poses</th><th>covered</th><th>median</th><th>worst</th></tr>\n";
  for (const RouteSurvey& route : s.routes) {
    const Spread& v = route.maps.front().spread;
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape_xml(route.name), route.poses.size(), percent(route.covered_fraction),
                        figure_text(v.median, "m"), v.without > 0 ? "no fix" : figure_text(v.max, "m"));
  }
  return html + "</table>\n";
}

}  // namespace

std::string survey_html(const Survey& s, const SurveyPageInput& input) {
  const std::string name = s.model.name.empty() ? input.input : s.model.name;
  std::string html = kHead + fmt::format("<title>{0}: survey</title></head><body><h1>{0}: what the geometry is worth</h1>\n", escape_xml(name));
  html += fmt::format("<p class='big'>{} of the floor {}</p><p>{} beacons, {} cells of {:g} m; a fix in {}, {} beacons or more heard in {}, a mirror image in {}.</p>\n",
                      percent(s.covered_fraction), s.model.tolerance.fix_m ? fmt::format("within {}", figure_text(*s.model.tolerance.fix_m, "m")) : "has a fix",
                      s.model.beacons.size(), s.grid.cells.size(), s.grid.cell_m, percent(s.fix_fraction), s.coverage, percent(s.k_covered_fraction), percent(s.mirror_fraction));
  if (s.temperature_error_degC) html += fmt::format("<p>What-if: the air {:g} degrees warmer than stated makes distances {:.0f} ppm wrong.</p>\n", *s.temperature_error_degC, 1e6 * s.speed_error);
  for (const std::string& warning : input.warnings) html += fmt::format("<p>{}</p>\n", escape_xml(warning));
  html += figures(s) + failures(s) + routes(s) + "<h2>Maps</h2>\n";
  for (const FloorMap& map : s.maps)
    html += fmt::format("<figure><figcaption>{}</figcaption>{}</figure>\n", escape_xml(map.title), map_svg(s, binned_map(s, map)));
  html += fmt::format("<p>{} from {}, {}.</p></body></html>\n", escape_xml(input.program), escape_xml(input.input), escape_xml(input.created));
  return html;
}

}  // namespace octant::survey
