// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/survey_text.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "apps/octant/text/layout.h"
#include "io/import/plan_import.h"
#include "io/import/png.h"
#include "io/text/atomic_file.h"
#include "survey/drawing/binned_map.h"
#include "survey/drawing/survey_plan.h"
#include "survey/map/survey_csv.h"
#include "survey/page/survey_verdict.h"

namespace octant::app {
namespace {

using survey::FloorMap;
using survey::Loss;
using survey::percent_text;
using survey::Survey;

Json spread_json(const survey::Spread& s) {
  if (s.count == 0)
    return {{"min", nullptr}, {"median", nullptr}, {"p95", nullptr}, {"max", nullptr}, {"no_fix", s.without}};
  return {{"min", s.min}, {"median", s.median}, {"p95", s.p95}, {"max", s.max}, {"no_fix", s.without}};
}

Json values_json(const Survey& survey, const FloorMap& map, std::size_t bins) {
  const auto binned = survey::binned_map(survey, map, bins);
  Json rows = Json::array();
  for (std::size_t row = 0; row < binned.rows; ++row) {
    Json values = Json::array();
    for (std::size_t column = 0; column < binned.columns; ++column) {
      const std::size_t at = row * binned.columns + column;
      values.push_back(binned.bins[at] == survey::BinnedMap::Bin::kValue ? Json(binned.values[at])
                                                                         : Json(nullptr));
    }
    rows.push_back(std::move(values));
  }
  return {{"origin_m", {binned.origin_m.x(), binned.origin_m.y()}}, {"bin_m", binned.bin_m}, {"rows", rows}};
}

Json losses_json(const Survey& survey, const std::vector<Loss>& losses) {
  Json list = Json::array();
  const auto poses = static_cast<double>(survey.poses());
  for (const Loss& loss : losses) {
    Json item = {{"beacons", Json::array({survey.model.beacons[loss.first].name})},
                 {"out_of_tolerance_fraction", static_cast<double>(loss.poses_out) / poses},
                 {"without_fix_fraction", static_cast<double>(loss.poses_without_fix) / poses},
                 {"worst_sigma_m", loss.worst_sigma_m}};
    if (loss.second != Loss::kNone) item["beacons"].push_back(survey.model.beacons[loss.second].name);
    list.push_back(std::move(item));
  }
  return list;
}

constexpr std::size_t kDrawnBins = 120;  ///< number of bins along the longer side of a map's drawing

bool is_number(const FloorMap& map) { return map.name != "loss_one_beacon" && map.name != "mirror"; }

void write(const std::string& folder, const std::string& name, std::string_view content,
           std::vector<std::string>& written) {
  need(io::write_file((std::filesystem::path(folder) / name).string(), content));
  written.push_back(name);
}

void write_map(const Survey& survey, const FloorMap& map, const std::string& folder,
               std::vector<std::string>& written) {
  const auto cells = survey::cell_map(survey, map);
  const std::string svg = survey::site_plan_svg(survey::survey_plan(survey, {&map}, kDrawnBins));
  write(folder, map.name + ".svg", svg, written);
  write(folder, map.name + ".png", need(io::png_of(survey::pixels_of(cells), cells.columns, cells.rows)),
        written);
  const auto costmap = io::costmap_text(survey::costs_of(cells), cells.columns, cells.rows, cells.bin_m,
                                        cells.origin_m, map.name + ".pgm");
  write(folder, map.name + ".pgm", costmap.pgm, written);
  write(folder, map.name + ".yaml", costmap.yaml, written);
}

std::string losses_text(const Survey& survey) {
  if (survey.failures.empty()) return "";
  Table table{"lrrrr", {{"if gone", "heard in", "out of tolerance", "without a fix", "worst left"}}};
  const double poses = static_cast<double>(survey.poses());
  const auto row = [&](std::string names, std::string heard, const Loss& loss) {
    table.rows.push_back({std::move(names), std::move(heard),
                          percent_text(static_cast<double>(loss.poses_out) / poses),
                          percent_text(static_cast<double>(loss.poses_without_fix) / poses),
                          loss.worst_sigma_m > 0 ? length_text(loss.worst_sigma_m) : "-"});
  };
  const auto& beacons = survey.model.beacons;
  for (std::size_t i = 0; i < std::min<std::size_t>(10, survey.failures.size()); ++i)
    row(beacons[survey.failures[i].first].name, percent_text(survey.heard_fraction[survey.failures[i].first]),
        survey.failures[i]);
  for (std::size_t i = 0; i < std::min<std::size_t>(3, survey.double_failures.size()); ++i) {
    const Loss& loss = survey.double_failures[i];
    row(beacons[loss.first].name + " and " + beacons[loss.second].name, "", loss);
  }
  return "\n" + table.text();
}

std::string routes_text(const Survey& survey) {
  if (survey.routes.empty()) return "";
  Table table{"lrrrr", {{"route", "poses", "covered", "median", "worst"}}};
  for (const auto& route : survey.routes) {
    const survey::Spread& s = route.maps.front().spread;
    table.rows.push_back({route.name, fmt::format("{}", route.poses.size()),
                          percent_text(route.covered_fraction), survey::figure_text(s.median, "m"),
                          s.without > 0 ? "no fix" : survey::figure_text(s.max, "m")});
  }
  return "\n" + table.text();
}

}  // namespace

Json survey_json(const Survey& survey, const std::optional<survey::FloorSchedule>& schedule,
                 std::size_t bins) {
  const survey::SurveyVerdict verdict = survey::survey_verdict(survey);
  Json object = {
      {"verdict",
       {{"grade", survey::to_string(verdict.grade)}, {"sentence", verdict.sentence}, {"next", verdict.next}}},
      {"cells", survey.grid.cells.size()},
      {"cell_m", survey.grid.cell_m},
      {"beacons", survey.model.beacons.size()},
      {"calibrated", survey.calibrated},
      {"fix_fraction", survey.fix_fraction},
      {"covered_fraction", survey.covered_fraction},
      {"coverage", survey.coverage},
      {"k_covered_fraction", survey.k_covered_fraction},
      {"mirror_fraction", survey.mirror_fraction}};
  object["tolerance_m"] = survey.model.tolerance.fix_m;
  object["reach_m"] = survey::reach_m(survey.model.hearing);  // null if it is unlimited
  object["absorption_np_per_m"] = survey.model.hearing.absorption_np_per_m;
  object["temperature_error_degC"] = survey.temperature_error_degC;
  for (const FloorMap& map : survey.maps)
    if (is_number(map)) object[map.name] = spread_json(map.spread);
  Json heard = Json::object();
  for (std::size_t b = 0; b < survey.model.beacons.size(); ++b)
    heard[survey.model.beacons[b].name] = survey.heard_fraction[b];
  object["heard_fraction"] = heard;
  object["failures"] = losses_json(survey, survey.failures);
  object["double_failures"] = losses_json(survey, survey.double_failures);
  Json routes = Json::array();
  for (const auto& route : survey.routes) {
    Json item = {
        {"id", route.name}, {"poses", route.poses.size()}, {"covered_fraction", route.covered_fraction}};
    for (const FloorMap& map : route.maps)
      if (is_number(map)) item[map.name] = spread_json(map.spread);
    routes.push_back(std::move(item));
  }
  object["routes"] = routes;
  object["schedule"] = schedule ? schedule_json(*schedule, survey.model) : Json(nullptr);
  if (bins > 0) {
    Json maps = Json::object();
    for (const FloorMap& map : survey.maps) maps[map.name] = values_json(survey, map, bins);
    object["maps"] = maps;
  }
  return object;
}

std::string survey_summary(const Survey& survey, const std::optional<survey::FloorSchedule>& schedule) {
  const survey::SurveyVerdict verdict = survey::survey_verdict(survey);
  std::string text;
  const auto line = [&](const char* name, const std::string& value) { text += named_line(name, value); };
  line("verdict", fmt::format("{}: {}", survey::to_string(verdict.grade), verdict.sentence));
  const FloorMap* judged = survey.find(survey.calibrated ? "total_m" : "sigma_m");
  if (judged != nullptr && judged->spread.count > 0) {
    const survey::Spread& s = judged->spread;
    line("expected error", fmt::format("median {}, 95 % {}, largest {}", survey::figure_text(s.median, "m"),
                                       survey::figure_text(s.p95, "m"), survey::figure_text(s.max, "m")));
  }
  if (const FloorMap* hdop = survey.find("hdop"); hdop != nullptr && hdop->spread.count > 0)
    line("dilution", fmt::format("HDOP median {:.2f}, 95 % {:.2f}, largest {:.3g}", hdop->spread.median,
                                 hdop->spread.p95, hdop->spread.max));
  std::string coverage =
      fmt::format("{} hear {} beacons or more", percent_text(survey.k_covered_fraction), survey.coverage);
  if (survey.find("mirror") != nullptr)
    coverage += fmt::format("; a mirror image fits in {}", percent_text(survey.mirror_fraction));
  line("coverage", coverage);
  const double reach = survey::reach_m(survey.model.hearing);
  line("reach", !std::isfinite(reach) ? "everywhere: nothing says how far a beacon is heard"
                : survey.model.hearing.threshold_v > 0
                    ? fmt::format("{:.1f} m on the axes, absorption {:.3f} dB/m", reach,
                                  8.685889638 * survey.model.hearing.absorption_np_per_m)
                    : fmt::format("{:.1f} m", reach));
  if (survey.temperature_error_degC)
    line("what-if", fmt::format("{:+g} degC not accounted for: {:+.0f} ppm", *survey.temperature_error_degC,
                                1e6 * survey.speed_error));
  const auto worst = std::ranges::min_element(
      survey.routes, [](const auto& a, const auto& b) { return a.covered_fraction < b.covered_fraction; });
  if (worst != survey.routes.end())
    line("route", fmt::format("{}: {} of it covered{}", worst->name, percent_text(worst->covered_fraction),
                              survey.routes.size() > 1 ? ", the least of all" : ""));
  if (schedule)
    line("cycle",
         fmt::format("{} in {} slots", time_text(schedule->plan.cycle_s()), schedule->plan.groups.size()));
  for (const std::string& step : verdict.next) line("next", step);
  return text;
}

std::string survey_text(const Survey& survey, const std::optional<survey::FloorSchedule>& schedule) {
  std::string text = fmt::format("{}: {} beacons, {} cells of {:g} m\n",
                                 survey.model.name.empty() ? "site without a name" : survey.model.name,
                                 survey.model.beacons.size(), survey.grid.cells.size(), survey.grid.cell_m);
  Table table{"lrrrrr", {{"", "least", "median", "95 %", "largest", "no fix"}}};
  for (const FloorMap& map : survey.maps) {
    if (!is_number(map)) continue;
    const auto figure = [&](double value) {
      return map.spread.count > 0 ? survey::figure_text(value, map.unit) : std::string("-");
    };
    table.rows.push_back({map.name, figure(map.spread.min), figure(map.spread.median), figure(map.spread.p95),
                          figure(map.spread.max), fmt::format("{}", map.spread.without)});
  }
  text += "\n" + table.text() + losses_text(survey) + routes_text(survey);
  if (!schedule) return text;
  return text + "\n" + slots_text(*schedule, survey.model);
}

std::vector<std::string> map_files(const Survey& survey, const std::string& folder) {
  const std::filesystem::path at(folder);
  std::vector<std::string> files = {(at / "cells.csv").string(), (at / "routes.csv").string()};
  for (const FloorMap& map : survey.maps)
    for (const char* extension : {".svg", ".png", ".pgm", ".yaml"})
      files.push_back((at / (map.name + extension)).string());
  return files;
}

std::vector<std::string> write_maps(const Survey& survey, const std::string& folder) {
  std::error_code trouble;
  std::filesystem::create_directory(folder, trouble);
  if (trouble || !std::filesystem::is_directory(folder))
    fail_with({.code = Errc::kOutput,
               .file = folder,
               .found = "no folder, and none can be made: " + trouble.message(),
               .expected = "a folder for the maps"});
  std::vector<std::string> written;
  for (const FloorMap& map : survey.maps) write_map(survey, map, folder, written);
  write(folder, "cells.csv", survey::survey_csv(survey), written);
  if (!survey.routes.empty()) write(folder, "routes.csv", survey::routes_csv(survey), written);
  return written;
}

Json schedule_json(const survey::FloorSchedule& s, const survey::SurveyModel& model) {
  Json groups = Json::array();
  for (std::size_t g = 0; g < s.plan.groups.size(); ++g) {
    Json names = Json::array();
    for (const std::size_t b : s.plan.groups[g]) names.push_back(model.beacons[b].name);
    groups.push_back({{"fires_at_s", static_cast<double>(g) * s.plan.slot_s}, {"beacons", names}});
  }
  return {{"slot_s", s.plan.slot_s},
          {"cycle_s", s.plan.cycle_s()},
          {"one_by_one_s", s.plan.one_by_one_s()},
          {"least_groups", s.plan.least_groups},
          {"groups", groups},
          {"reach_m", s.reach_m},
          {"silence",
           {{"single_echo_s", s.silent.single_echo_s},
            {"all_echoes_s", s.silent.all_echoes_s},
            {"kleeman_s", s.silent.kleeman_s},
            {"t60_s", s.silent.t60_s}}},
          {"hall",
           {{"volume_m3", s.reverberance.volume_m3},
            {"surface_m2", s.reverberance.surface_m2},
            {"longest_m", s.reverberance.longest_m},
            {"height_m", s.height_m},
            {"wall_reflection", s.reverberance.wall_reflection},
            {"absorption_np_per_m", s.reverberance.absorption_np_per_m}}}};
}

std::string slots_text(const survey::FloorSchedule& s, const survey::SurveyModel& model) {
  Table table{"rrl", {{"slot", "fires at", "beacons"}}};
  for (std::size_t g = 0; g < s.plan.groups.size(); ++g) {
    const std::string names =
        joined(s.plan.groups[g], " ", [&model](std::size_t b) { return model.beacons[b].name; });
    table.rows.push_back(
        {fmt::format("{}", g + 1), time_text(static_cast<double>(g) * s.plan.slot_s), names});
  }
  return table.text() + fmt::format("\n{:<17}{}; one by one {}{}\n", "cycle", time_text(s.plan.cycle_s()),
                                    time_text(s.plan.one_by_one_s()),
                                    s.plan.groups.size() == s.plan.least_groups
                                        ? std::string("; no fewer slots are possible")
                                        : fmt::format("; at least {} slots are needed", s.plan.least_groups));
}

}  // namespace octant::app
