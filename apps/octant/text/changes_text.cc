// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/changes_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/octant/text/table.h"
#include "survey/changes.h"

namespace octant::app {
namespace {

std::string verdict_of(const survey::BeaconChange& c) {
  std::string verdict = c.moved() ? "moved" : "";
  if (c.delay_significant) verdict += verdict.empty() ? "delay changed" : ", delay changed";
  if (c.by_datum) verdict += verdict.empty() ? "shift: see the datum" : "; shift: see the datum";
  return verdict.empty() ? "as before" : verdict;
}

std::string chance(const std::optional<double>& p) { return p ? fmt::format("{:.2g}", *p) : "-"; }

/// Standard deviation of the length of a shift, along it.
double sigma_along(const survey::BeaconChange& c) {
  const double length = c.shift_m.norm();
  return length > 0 ? c.shift_m.cwiseProduct(c.sigma_m).norm() / length : c.sigma_m.norm();
}

}  // namespace

std::string changes_text(const survey::ReportInput& input) {
  if (!input.changes) return {};
  const survey::Changes& changes = *input.changes;
  double length_m = 0.0, time_s = 0.0;
  for (const auto& c : changes.beacons) {
    length_m = std::max({length_m, c.shift_m.cwiseAbs().maxCoeff(), c.sigma_m.maxCoeff()});
    time_s = std::max({time_s, std::abs(c.delay_change_s), c.delay_sigma_s});
  }
  const Unit length = length_unit(length_m), time = time_unit(time_s);
  Table table{"lrrrrrrrrrrl",
              {{"changes", fmt::format("dx [{}]", length.symbol), "s", "dy", "s", "dz", "s", "p",
                fmt::format("delay [{}]", time.symbol), "s", "p", ""}}};
  for (const auto& c : changes.beacons) {
    std::vector<std::string> row = {c.name};
    for (int i = 0; i < 3; ++i) {
      row.push_back(fmt::format("{:.2f}", length.per_si * c.shift_m[i]));
      row.push_back(fmt::format("{:.2f}", length.per_si * c.sigma_m[i]));
    }
    row.insert(row.end(),
               {chance(c.p), fmt::format("{:.2f}", time.per_si * c.delay_change_s),
                fmt::format("{:.2f}", time.per_si * c.delay_sigma_s), chance(c.delay_p), verdict_of(c)});
    table.rows.push_back(std::move(row));
  }
  std::string text =
      "\n" + table.text() + fmt::format("\n{:<17}{}\n", "changes", survey::changes_sentence(changes));
  if (!changes.same_datum)
    text +=
        fmt::format("{:<17}the datum is another one: a part of the differences is that of the frame\n", "");
  return text;
}

bool add_changes_json(const survey::ReportInput& input, Json& object) {
  if (!input.changes) return false;
  Json list = Json::array();
  const double tests = survey::kSignificance / input.changes->limit_p;
  const auto add = [&](const char* kind, const std::string& subject, double size, double sigma,
                       const char* unit, const std::optional<double>& p) {
    list.push_back({{"kind", kind},
                    {"subject", subject},
                    {"size", size},
                    {"sigma", sigma},
                    {"unit", unit},
                    {"p", p ? std::min(1.0, *p * tests) : 0.0}});
  };
  for (const auto& c : input.changes->beacons) {
    if (c.moved()) add("beacon_moved", c.name, c.shift_m.norm(), sigma_along(c), "m", c.p);
    if (c.delay_significant)
      add("delay", c.name, std::abs(c.delay_change_s), c.delay_sigma_s, "s", c.delay_p);
  }
  object["changes"] = std::move(list);
  return true;
}

}  // namespace octant::app
