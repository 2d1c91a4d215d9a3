// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "survey/geometry/quantity.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

double least_p(const BeaconChange& c) { return std::min(c.p.value_or(1.0), c.delay_p.value_or(1.0)); }

ReportText verdict_of(const BeaconChange& c) {
  const std::string delay = c.delay_significant ? "delay changed" : "";
  if (c.moved()) return {"moved" + (delay.empty() ? "" : ", " + delay), Tone::kBad};
  if (!delay.empty()) return {delay + (c.by_datum ? "; shift: see the datum" : ""), Tone::kBad};
  if (c.by_datum) return {"shift: see the datum", Tone::kAttention};
  return {"as before"};
}

ReportTable table_of(const Changes& changes) {
  double length_m = 0.0, time_s = 0.0;
  for (const auto& c : changes.beacons) {
    length_m = std::max({length_m, c.shift_m.cwiseAbs().maxCoeff(), c.sigma_m.maxCoeff()});
    time_s = std::max({time_s, std::abs(c.delay_change_s), c.delay_sigma_s});
  }
  const Unit length = length_unit(length_m), time = time_unit(time_s);
  ReportTable table{
      "changes-table",
      fmt::format("New less old, with the sigma of the difference; moved, delay changed: what is held to be "
                  "changed by all comparisons together, each as rare by chance as once in {:.0f}",
                  1 / changes.limit_p),
      {{"beacon", true}}};
  for (const char* axis : {"x", "y", "z"}) {
    table.columns.push_back({fmt::format("{} [{}]", axis, length.symbol)});
    table.columns.push_back({fmt::format("sigma {} [{}]", axis, length.symbol)});
  }
  table.columns.insert(table.columns.end(), {{"p"},
                                             {fmt::format("delay [{}]", time.symbol)},
                                             {fmt::format("sigma [{}]", time.symbol)},
                                             {"p"},
                                             {"verdict", true}});
  std::vector<BeaconChange> rows = changes.beacons;
  std::ranges::stable_sort(rows, [](const auto& a, const auto& b) { return least_p(a) < least_p(b); });
  for (const auto& c : rows) {
    if (table.rows.size() >= kMaxRows) break;
    std::vector<ReportText> row = {{c.name}};
    for (int i = 0; i < 3; ++i) {
      row.push_back({fmt::format("{:.2f}", length.per_si * c.shift_m[i])});
      row.push_back({fmt::format("{:.2f}", length.per_si * c.sigma_m[i])});
    }
    row.push_back({c.p ? fmt::format("{:.2g}", *c.p) : "-"});
    row.push_back({fmt::format("{:.2f}", time.per_si * c.delay_change_s)});
    row.push_back({fmt::format("{:.2f}", time.per_si * c.delay_sigma_s)});
    row.push_back({c.delay_p ? fmt::format("{:.2g}", *c.delay_p) : "-"});
    row.push_back(verdict_of(c));
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string doubt_sentence(const Changes& changes) {
  const bool one = changes.doubted_control_points.size() == 1;
  return fmt::format(
      "Control point{} {} held where the site file has {}, and {} changed by more than chance. If {} "
      "knocked, the shifts of the "
      "others are those of the frame: measure {} again before anything is said to have moved.",
      one ? "" : "s",
      fmt::format("{} {}", fmt::join(changes.doubted_control_points, ", "), one ? "is" : "are"),
      one ? "it" : "them", one ? "its delay" : "their delays", one ? "it was" : "they were",
      one ? "it" : "them");
}

}  // namespace

std::string reception_words(const Silence& s) {
  return fmt::format("{:.0f} arrivals were expected{}, and {:.0f} received", s.expected,
                     s.is_partial ? fmt::format(" from {:.0f} s on", s.since_s) : "", s.received);
}

std::string changes_sentence(const Changes& changes) {
  const auto count = [&changes](auto&& which) { return std::ranges::count_if(changes.beacons, which); };
  const auto moved = count([](const BeaconChange& c) { return c.moved(); });
  const auto delays = count([](const BeaconChange& c) { return c.delay_significant; });
  return fmt::format("Since {}: {} of {} beacons moved by more than chance explains{}.", changes.since, moved,
                     changes.beacons.size(),
                     delays > 0 ? fmt::format(", the delay of {} changed", delays) : "");
}

std::optional<ReportSection> changes_section(const ReportInput& input) {
  if (!input.changes) return {};
  const Changes& changes = *input.changes;
  ReportSection section{"changes", "Changes since an earlier deployment"};
  section.blocks.emplace_back(ReportText{changes_sentence(changes)});
  if (!changes.doubted_control_points.empty())
    section.blocks.emplace_back(ReportText{doubt_sentence(changes), Tone::kAttention});
  if (!changes.same_datum)
    section.blocks.emplace_back(ReportText{
        "The datum is another one: a part of the differences is that of the frame, not of the beacons.",
        Tone::kAttention});
  for (const Silence& s : changes.silent)
    section.blocks.emplace_back(
        ReportText{fmt::format("{} is silent: {}.", s.subject, reception_words(s)), Tone::kAttention});
  if (!changes.not_observed.empty())
    section.blocks.emplace_back(ReportText{fmt::format("Not observed, as out of reach, and carried over: {}.",
                                                       fmt::join(changes.not_observed, ", "))});
  if (!changes.gone.empty())
    section.blocks.emplace_back(
        ReportText{fmt::format("No longer there: {}.", fmt::join(changes.gone, ", "))});
  if (!changes.added.empty())
    section.blocks.emplace_back(ReportText{fmt::format("New: {}.", fmt::join(changes.added, ", "))});
  if (changes.speed_change_mps)
    section.blocks.emplace_back(
        ReportText{fmt::format("Speed at the same temperature: {:+.3f} m/s, sigma {:.3f} m/s.",
                               *changes.speed_change_mps, changes.speed_sigma_mps)});
  if (!changes.beacons.empty()) section.blocks.emplace_back(table_of(changes));
  return section;
}

}  // namespace octant::survey
