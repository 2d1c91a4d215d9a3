// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/octant/steps/steps.h"
#include "apps/octant/text/layout.h"

namespace octant::app {
namespace {

using calib::Reliability;
using calib::ResidualGroup;

Json component_json(const calib::VarianceComponent& c) {
  return {{"kind", c.name},
          {"observations", c.observations},
          {"redundancy", c.redundancy},
          {"factor", c.factor},
          {"chi2_p", c.chi2_p}};
}

Json ellipse_json(const calib::ErrorEllipse& e) {
  return {{"semi_major_m", e.semi_major_m},
          {"semi_minor_m", e.semi_minor_m},
          {"azimuth_rad", e.azimuth_rad},
          {"semi_axes_3d_m", e.semi_axes_m}};
}

Json beacon_json(const calib::BeaconReliability& b) {
  return {{"id", b.name},
          {"used", b.used},
          {"rejected", {{"late", b.late}, {"early", b.early}, {"other", b.other}}},
          {"uncontrolled", b.uncontrolled},
          {"mean_redundancy_number", b.mean_redundancy},
          {"mean_s", b.mean_s},
          {"rms_s", b.rms_s},
          {"variance_component", b.component.factor},
          {"chi2_p", b.component.chi2_p},
          {"mdb_s", {{"median", b.mdb_median_s}, {"worst", b.mdb_worst_s}}},
          {"influence_m", {{"median", b.influence_median_m}, {"worst", b.influence_worst_m}}},
          {"lateness_mdb_s", b.lateness_mdb_s},
          {"lateness_influence_m", b.lateness_influence_m},
          {"ellipse_95", b.ellipse ? ellipse_json(*b.ellipse) : nullptr}};
}

Json groups_json(const std::vector<ResidualGroup>& groups, const char* from, const char* to) {
  Json list = Json::array();
  for (const auto& g : groups) {
    if (g.count == 0) continue;
    Json one = from == nullptr ? Json{{"id", g.name}} : Json{{from, g.from}, {to, g.to}};
    one.update({{"count", g.count},
                {"mean_s", g.mean_s},
                {"rms_s", g.rms_s},
                {"mean_m", g.mean_m},
                {"rms_m", g.rms_m}});
    list.push_back(std::move(one));
  }
  return list;
}

/// Origin of an arrival and its beacon and receiver: "hall/run, tof.csv:41".
struct ArrivalOrigin {
  std::string run, beacon, receiver;
  int line = 0;
};
ArrivalOrigin origin_of(const calib::ArrivalReliability& a, const calib::Problem& problem) {
  const MeasurementLog& run = problem.runs[a.run];
  return {run.path, problem.site.beacons[a.beacon.index()].name,
          problem.site.receivers[a.receiver.index()].name, run.arrivals[a.arrival].line};
}

double or_zero(const std::optional<double>& value) { return value.value_or(0.0); }

/// Largest value of a quantity over all beacons, which determines the unit of its column.
template <class Get>
double largest(const Reliability& r, Get&& get) {
  double value = 0.0;
  for (const auto& b : r.beacons) value = std::max(value, get(b));
  return value;
}

std::string cell(const std::optional<double>& value, double per_si, int digits) {
  return value && std::isfinite(*value) ? fmt::format("{:.{}f}", per_si * *value, digits) : "-";
}

/// Table of the residuals of each beacon.
std::string agreement_table(const Reliability& r, const Unit& time) {
  Table table{
      "lrrrrrrr",
      {{"beacon", "used", "late", "early", "r", fmt::format("RMS [{}]", time.name), "variance", "p"}}};
  for (const auto& b : r.beacons) {
    std::vector<std::string> row = {b.name, fmt::format("{}", b.used), fmt::format("{}", b.late),
                                    fmt::format("{}", b.early)};
    if (b.used > 0)
      row.insert(row.end(), {fmt::format("{:.2f}", b.mean_redundancy), cell(b.rms_s, time.per_si, 2),
                             cell(b.component.factor, 1, 2),
                             b.component.chi2_p ? fmt::format("{:.2g}", *b.component.chi2_p) : "-"});
    row.resize(table.align.size(), "-");
    table.rows.push_back(std::move(row));
  }
  return table.text();
}

/// Table of the effect of an undetected error on each beacon, and its error ellipse.
std::string detection_table(const Reliability& r, const Unit& time) {
  const Unit late = time_unit(largest(r, [](const auto& b) { return or_zero(b.lateness_mdb_s); }));
  const Unit shift = length_unit(largest(r, [](const auto& b) {
    return std::max(or_zero(b.influence_worst_m), or_zero(b.lateness_influence_m));
  }));
  const Unit axis =
      length_unit(largest(r, [](const auto& b) { return b.ellipse ? b.ellipse->semi_axes_m[0] : 0.0; }));
  Table table{"lrrrrrrr",
              {{"beacon", fmt::format("MDB [{}]", time.name), fmt::format("moves [{}]", shift.name),
                fmt::format("all late [{}]", late.name), fmt::format("moves [{}]", shift.name),
                fmt::format("a [{}]", axis.name), "b", "azimuth"}}};
  for (const auto& b : r.beacons) {
    std::vector<std::string> row = {b.name};
    if (b.used > 0) {
      row.insert(row.end(),
                 {cell(b.mdb_median_s, time.per_si, 1), cell(b.influence_worst_m, shift.per_si, 2),
                  cell(b.lateness_mdb_s, late.per_si, 1), cell(b.lateness_influence_m, shift.per_si, 2)});
      if (b.ellipse)
        row.insert(row.end(), {cell(b.ellipse->semi_major_m, axis.per_si, 2),
                               cell(b.ellipse->semi_minor_m, axis.per_si, 2),
                               fmt::format("{:.0f} deg", b.ellipse->azimuth_rad * 180.0 / M_PI)});
    }
    row.resize(table.align.size(), "-");
    table.rows.push_back(std::move(row));
  }
  return table.text();
}

void add_groups(Table& table, const std::vector<ResidualGroup>& groups, const char* unit, const Unit& time,
                const Unit& length) {
  for (const auto& g : groups) {
    if (g.count == 0) continue;
    table.rows.push_back({unit == nullptr ? g.name : fmt::format("{:.1f} to {:.1f} {}", g.from, g.to, unit),
                          fmt::format("{}", g.count), cell(g.mean_s, time.per_si, 2),
                          cell(g.rms_s, time.per_si, 2), cell(g.mean_m, length.per_si, 2),
                          cell(g.rms_m, length.per_si, 2)});
  }
}

std::string residual_table(const Reliability& r) {
  double largest_s = 0.0, largest_m = 0.0;
  for (const auto* groups : {&r.by_distance, &r.by_temperature, &r.by_receiver})
    for (const auto& g : *groups) {
      largest_s = std::max(largest_s, g.rms_s);
      largest_m = std::max(largest_m, g.rms_m);
    }
  const Unit time = time_unit(largest_s), length = length_unit(largest_m);
  Table table{"lrrrrr",
              {{"residuals", "count", fmt::format("mean [{}]", time.name), fmt::format("RMS [{}]", time.name),
                fmt::format("mean [{}]", length.name), fmt::format("RMS [{}]", length.name)}}};
  add_groups(table, r.by_distance, "m", time, length);
  add_groups(table, r.by_temperature, "degC", time, length);
  if (std::ranges::count_if(r.by_receiver, [](const auto& g) { return g.count > 0; }) > 1)
    add_groups(table, r.by_receiver, nullptr, time, length);
  return table.text();
}

}  // namespace

Json reliability_json(const Calibration& calibration) {
  const Reliability& r = calibration.solution.reliability;
  if (!r.ok) return nullptr;
  Json beacons = Json::array(), kinds = Json::array(), worst = Json::array();
  for (const auto& b : r.beacons) beacons.push_back(beacon_json(b));
  for (const auto& kind : r.kinds) kinds.push_back(component_json(kind));
  for (const std::size_t i : r.worst) {
    const auto& a = r.arrivals[i];
    const ArrivalOrigin at = origin_of(a, calibration.problem);
    worst.push_back({{"run", at.run},
                     {"line", at.line},
                     {"beacon", at.beacon},
                     {"receiver", at.receiver},
                     {"w", a.w},
                     {"residual_s", a.residual_s},
                     {"redundancy_number", a.redundancy},
                     {"mdb_s", a.mdb_s}});
  }
  return {{"critical_w", calib::kCriticalW},
          {"beyond_critical", r.beyond_critical},
          {"expected_beyond_critical", 0.001 * static_cast<double>(r.arrivals.size())},
          {"every", r.stride},
          {"mean_redundancy_number", r.mean_redundancy},
          {"redundancy", r.redundancy_sum},
          {"worst", worst},
          {"beacons", beacons},
          {"variance_components", kinds},
          {"residuals",
           {{"by_beacon", groups_json(r.by_beacon, nullptr, nullptr)},
            {"by_receiver", groups_json(r.by_receiver, nullptr, nullptr)},
            {"by_distance", groups_json(r.by_distance, "from_m", "to_m")},
            {"by_incidence", groups_json(r.by_incidence, "from_rad", "to_rad")},
            {"by_temperature", groups_json(r.by_temperature, "from_degC", "to_degC")},
            {"by_time", groups_json(r.by_time, "from_s", "to_s")}}}};
}

std::string reliability_text(const Calibration& calibration) {
  const Reliability& r = calibration.solution.reliability;
  if (!r.ok || r.arrivals.empty()) return "";
  const Unit time =
      time_unit(largest(r, [](const auto& b) { return std::max(b.rms_s, or_zero(b.mdb_median_s)); }));
  std::string text = "\n" + agreement_table(r, time) +
                     paragraph("r: mean redundancy number. variance: of the residuals over the stated one.") +
                     "\n" + detection_table(r, time);
  text += paragraph(
      "MDB: smallest bias of one arrival that is found (0.1 %, power 80 %; median), and how far the worst "
      "that is not moves a beacon coordinate. all late: the same for a lateness of all arrivals of a beacon. "
      "a, b: half axes of the horizontal 95 % error ellipse, azimuth counter-clockwise from +x.");
  text += "\n";
  text += residual_table(r) + "\n";
  std::string kinds;
  for (const auto& kind : r.kinds) {
    if (!kind.factor) continue;
    kinds += fmt::format("{}{} {:.3g}", kinds.empty() ? "" : ", ", kind.name, *kind.factor);
  }
  text += named_line("variances", kinds);
  if (r.stride > 1)
    text += named_line("looked at",
                       fmt::format("redundancy, w, detectable biases, residual groups and variances are "
                                   "those of every {}th epoch; the adjustment used all",
                                   r.stride));
  std::string w =
      fmt::format("{} of {} beyond {:.2f} ({:.1f} expected)", r.beyond_critical, r.arrivals.size(),
                  calib::kCriticalW, 0.001 * static_cast<double>(r.arrivals.size()));
  for (std::size_t i = 0;
       i < r.worst.size() && i < 3 && std::abs(r.arrivals[r.worst[i]].w) > calib::kCriticalW; ++i) {
    const auto& a = r.arrivals[r.worst[i]];
    const ArrivalOrigin at = origin_of(a, calibration.problem);
    w += fmt::format("{}{}/tof.csv:{} {} {} w = {:.2f}", i == 0 ? "; worst: " : ", ", at.run, at.line,
                     at.beacon, at.receiver, a.w);
  }
  return text + named_line("Baarda's w", w);
}

}  // namespace octant::app
