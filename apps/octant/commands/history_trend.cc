// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/octant/commands/history_args.h"
#include "apps/octant/text/layout.h"
#include "io/deployment/deployment_json.h"
#include "models/support/utc_time.h"
#include "survey/trend/site_trend.h"

namespace octant::app {
namespace {

using survey::QuantityTrend;
using survey::TrendQuantity;

constexpr double kYear_s = 365.25 * 86400.0;
/// Later dates are meaningless as plans and cannot be formatted.
constexpr double kFarthest_s = 50.0 * kYear_s;

std::string day_at(double time_s) { return utc_text(static_cast<std::int64_t>(time_s)).substr(0, 10); }

/// Formats a future date, up to the longest planning horizon.
std::string due_text(double time_s, double last_s) {
  return time_s - last_s > kFarthest_s ? "in more than 50 years" : day_at(time_s);
}
Json due_json(const std::optional<double>& time_s, double last_s) {
  return !time_s || *time_s - last_s > kFarthest_s ? Json(nullptr)
                                                   : Json(utc_text(static_cast<std::int64_t>(*time_s)));
}

survey::CalibrationRecord record_of(const io::Visit& v) {
  survey::CalibrationRecord record;
  record.time_s = static_cast<double>(v.happened_s);
  for (const io::VisitBeacon& b : v.beacons) {
    DeploymentBeacon beacon{.name = b.name,
                            .position_m = b.position_m,
                            .delay_s = b.delay_s,
                            .delay_sigma_s = b.delay_sigma_s,
                            .status = b.status};
    beacon.covariance_m2 = b.sigma_m.cwiseAbs2().asDiagonal();
    record.beacons.push_back(std::move(beacon));
  }
  if (v.speed) {
    record.speed_mps = v.speed->speed_mps;
    record.speed_sigma_mps = v.speed->sigma_mps;
    record.speed_offset_mps = v.speed->offset_mps;
    record.temperature_degC = v.speed->temperature_degC;
  }
  return record;
}

/// Millimetres, microseconds (or another suitable unit), millimetres per second.
Unit unit_of(const QuantityTrend& q) {
  if (q.quantity == TrendQuantity::kDelay) return time_unit(q.limit);
  return q.quantity == TrendQuantity::kSpeedOffset ? Unit{1e3, "mm/s", "mm/s"} : Unit{1e3, "mm", "mm"};
}

/// Name of the quantity without its unit: "x", "delay".
std::string plain_name(TrendQuantity quantity) {
  const std::string name = survey::to_string(quantity);
  return name.substr(0, name.rfind('_'));
}

/// One character for each of the last forty visits: deviation from the forecast, or ! for an alarm.
std::string strip_of(const survey::ControlChart& chart) {
  constexpr std::size_t kShown = 40;
  std::string text;
  for (std::size_t i = chart.points.size() > kShown ? chart.points.size() - kShown : 0;
       i < chart.points.size(); ++i) {
    const survey::ChartPoint& p = chart.points[i];
    const double d = p.deviation_sigmas;
    text += p.alarm != 0 ? '!' : !p.foretold ? 'o' : d > 2 ? '+' : d < -2 ? '-' : '.';
  }
  return text;
}

std::string alarms_text(const QuantityTrend& q) {
  std::string text;
  const Unit unit = unit_of(q);
  for (const survey::Shift& s : q.chart.shifts) {
    const auto day_of_point = [&](std::size_t i) { return day_at(q.chart.points[i].measured.time_s); };
    text += s.by_drift
                ? fmt::format("{:<17}{} {} drifts: noticed {}\n", "alarm", q.subject, plain_name(q.quantity),
                              day_of_point(s.at))
                : fmt::format("{:<17}{} {} changed by {:+.3g} {} (sigma {:.2g}), between {} and {}\n",
                              "alarm", q.subject, plain_name(q.quantity), unit.per_si * s.size, unit.name,
                              unit.per_si * s.sigma, day_of_point(s.since - 1), day_of_point(s.since));
  }
  return text;
}

std::string forecast_text(const survey::SiteTrend& trend, double last_s) {
  if (!trend.earliest)
    return fmt::format("{:<17}none yet: it takes two calibrations, a week apart or more\n", "forecast");
  const auto whose = [&](std::size_t i) {
    return trend.quantities[i].subject + " " + plain_name(trend.quantities[i].quantity);
  };
  std::string text;
  if (trend.due) {
    const QuantityTrend& q = trend.quantities[*trend.due];
    text += fmt::format("{:<17}recalibrate by {} ({} drifts; by two sigmas {} to {})\n", "forecast",
                        due_text(*q.forecast->due_s, last_s), whose(*trend.due),
                        due_text(q.forecast->earliest_s, last_s), due_text(*q.forecast->latest_s, last_s));
  } else {
    text += fmt::format("{:<17}no drift is told from zero\n", "forecast");
  }
  return text + fmt::format("{:<17}{} ({}, if it drifts by two sigmas more than found)\n", "not before",
                            due_text(trend.quantities[*trend.earliest].forecast->earliest_s, last_s),
                            whose(*trend.earliest));
}

std::string overview_text(const survey::SiteTrend& trend) {
  Table table{"llrlrrrl", {{"", "", "last", "", "cusum", "drift/year", "sigma", "visits"}}};
  for (const QuantityTrend& q : trend.quantities) {
    const Unit unit = unit_of(q);
    const survey::ChartPoint& last = q.chart.points.back();
    table.rows.push_back(
        {q.subject, plain_name(q.quantity),
         last.foretold ? fmt::format("{:+.2f}", unit.per_si * (last.measured.value - *last.foretold)) : "",
         unit.name, fmt::format("{:.1f}", std::max(last.upper, last.lower)),
         q.chart.drift ? fmt::format("{:+.2f}", unit.per_si * kYear_s * q.chart.drift->per_s) : "",
         q.chart.drift ? fmt::format("{:.2f}", unit.per_si * kYear_s * q.chart.drift->sigma_per_s) : "",
         strip_of(q.chart)});
  }
  return "\n" + table.text() +
         fmt::format(
             "last: less what the calibrations before foretell; cusum: alarm at {:.1f}; visits: o first of a "
             "level, . + - within and beyond two "
             "sigmas, ! alarm\n",
             trend.cusum_h);
}

/// One line for each visit: its value, and its deviation from the forecast between -6 and 6 sigmas.
std::string chart_text(const QuantityTrend& q) {
  constexpr int kHalf = 24;
  constexpr double kWidest = 6.0;
  const Unit unit = unit_of(q);
  std::string text = fmt::format("\n{} {} [{}], -{:.0f} to {:.0f} sigmas of what was foretold\n", q.subject,
                                 plain_name(q.quantity), unit.name, kWidest, kWidest);
  for (const survey::ChartPoint& p : q.chart.points) {
    std::string line(2 * kHalf + 1, ' ');
    line[kHalf] = '|';
    const double at = std::clamp(p.deviation_sigmas / kWidest, -1.0, 1.0);
    line[static_cast<std::size_t>(kHalf + std::lround(at * kHalf))] = p.alarm != 0 ? '!'
                                                                      : p.foretold ? '*'
                                                                                   : 'o';
    text += fmt::format("{}  {:>12.3f} {:>8.3f}  {}  cusum {:4.1f}\n", day_at(p.measured.time_s),
                        unit.per_si * p.measured.value, unit.per_si * p.measured.sigma, line,
                        std::max(p.upper, p.lower));
  }
  return text;
}

std::string speed_text(const std::vector<survey::CalibrationRecord>& records) {
  std::vector<const survey::CalibrationRecord*> by_temperature;
  for (const auto& record : records) by_temperature.push_back(&record);
  std::ranges::sort(by_temperature,
                    [](const auto* a, const auto* b) { return a->temperature_degC < b->temperature_degC; });
  Table table{"rrrrl", {{"air [degC]", "speed [m/s]", "sigma", "off its model", "date"}}};
  for (const auto* r : by_temperature)
    table.rows.push_back({fmt::format("{:.1f}", r->temperature_degC), fmt::format("{:.3f}", r->speed_mps),
                          fmt::format("{:.3f}", r->speed_sigma_mps),
                          fmt::format("{:+.3f}", r->speed_offset_mps), day_at(r->time_s)});
  return "\n" + table.text();
}

Json quantity_json(const QuantityTrend& q) {
  Json points = Json::array(), alarms = Json::array();
  for (const survey::ChartPoint& p : q.chart.points)
    points.push_back({{"date", utc_text(static_cast<std::int64_t>(p.measured.time_s))},
                      {"value", p.measured.value},
                      {"sigma", p.measured.sigma},
                      {"foretold", p.foretold},
                      {"deviation_sigmas", p.deviation_sigmas},
                      {"cusum_upper", p.upper},
                      {"cusum_lower", p.lower},
                      {"alarm", p.alarm}});
  for (const survey::Shift& s : q.chart.shifts)
    alarms.push_back({{"date", points[s.at]["date"]},
                      {"since", points[s.since]["date"]},
                      {"size", s.size},
                      {"sigma", s.sigma},
                      {"drift", s.by_drift}});
  const double last_s = q.chart.points.back().measured.time_s;
  Json object = {{"subject", q.subject},
                 {"quantity", survey::to_string(q.quantity)},
                 {"limit", q.limit},
                 {"points", points},
                 {"alarms", alarms},
                 {"drift_per_year", nullptr},
                 {"drift_sigma_per_year", nullptr},
                 {"due", nullptr},
                 {"earliest", nullptr},
                 {"latest", nullptr}};
  if (q.chart.drift) {
    object["drift_per_year"] = kYear_s * q.chart.drift->per_s;
    object["drift_sigma_per_year"] = kYear_s * q.chart.drift->sigma_per_s;
  }
  if (q.forecast) {
    object["due"] = due_json(q.forecast->due_s, last_s);
    object["earliest"] = due_json(q.forecast->earliest_s, last_s);
    object["latest"] = due_json(q.forecast->latest_s, last_s);
  }
  return object;
}

Json next_json(const survey::SiteTrend& trend, double last_s) {
  const auto one = [&](const std::optional<std::size_t>& which, bool due) {
    if (!which) return Json(nullptr);
    const QuantityTrend& q = trend.quantities[*which];
    const Json date = due ? due_json(q.forecast->due_s, last_s) : due_json(q.forecast->earliest_s, last_s);
    Json object = {{"date", date}, {"subject", q.subject}, {"quantity", survey::to_string(q.quantity)}};
    if (due)
      object.update({{"earliest", due_json(q.forecast->earliest_s, last_s)},
                     {"latest", due_json(q.forecast->latest_s, last_s)}});
    return object;
  };
  return {{"due", one(trend.due, true)}, {"not_before", one(trend.earliest, false)}};
}

/// Tolerance of the site from its latest calibration, else the default of TrendOptions.
double drift_limit_m(io::History& history, const HistoryArgs& args, const io::Visit& latest) {
  if (args.limit_m) return *args.limit_m;
  const Deployment deployment =
      need(io::deployment_from_json(need(history.get(latest.id)).document, args.database));
  return deployment.tolerance.beacon_m.value_or(survey::TrendOptions{}.limit_m);
}

/// Charts to show: all, or those of one beacon.
std::vector<const QuantityTrend*> charts_of(const survey::SiteTrend& trend, const std::string& beacon) {
  std::vector<const QuantityTrend*> charts;
  for (const QuantityTrend& q : trend.quantities)
    if (beacon.empty() || q.subject == beacon) charts.push_back(&q);
  return charts;
}

Json speeds_json(const std::vector<survey::CalibrationRecord>& records) {
  Json speeds = Json::array();
  for (const auto& r : records)
    speeds.push_back({{"date", utc_text(static_cast<std::int64_t>(r.time_s))},
                      {"temperature_degC", r.temperature_degC},
                      {"speed_mps", r.speed_mps},
                      {"sigma_mps", r.speed_sigma_mps},
                      {"offset_mps", r.speed_offset_mps}});
  return speeds;
}

}  // namespace

int history_trend(const HistoryArgs& args, Session& session) {
  io::History history = need(io::History::open(args.database, false));
  const std::string site = chosen_site(history, args);
  const std::vector<io::Visit> visits = need(history.calibrations(site));
  if (visits.empty())
    fail_with({.file = args.database,
               .found = fmt::format("no calibration of {}", site),
               .expected = "some",
               .advice = "octant history add DEPLOYMENT.json"});
  survey::TrendOptions options;
  options.limit_m = drift_limit_m(history, args, visits.back());
  std::vector<survey::CalibrationRecord> records;
  for (const io::Visit& v : visits) records.push_back(record_of(v));
  const survey::SiteTrend trend = survey::site_trend(records, options);
  const auto charts = charts_of(trend, args.beacon);
  const bool known =
      args.beacon.empty() || std::ranges::any_of(visits, [&](const io::Visit& v) {
        return std::ranges::any_of(v.beacons, [&](const auto& b) { return b.name == args.beacon; });
      });
  if (!known)
    fail_with({.file = args.database,
               .found = fmt::format("no beacon '{}' in the calibrations of {}", args.beacon, site),
               .expected = "one of theirs",
               .advice = "octant history trend lists them"});

  const double last_s = records.back().time_s;
  std::string text =
                  fmt::format("{}: {} calibration{}, {} to {}\n", site, records.size(),
                              records.size() == 1 ? "" : "s", day_at(records.front().time_s), day_at(last_s)),
              alarms;
  Json list = Json::array();
  for (const QuantityTrend* q : charts) {
    list.push_back(quantity_json(*q));
    alarms += alarms_text(*q);
    if (!args.beacon.empty()) text += chart_text(*q);
  }
  if (args.beacon.empty()) text += overview_text(trend) + speed_text(records);
  session.result(text + "\n" + (alarms.empty() ? fmt::format("{:<17}none\n", "alarm") : alarms) +
                 forecast_text(trend, last_s));
  return session.finish({{"database", args.database},
                         {"site", site},
                         {"calibrations", records.size()},
                         {"limit_m", options.limit_m},
                         {"cusum_h", trend.cusum_h},
                         {"visits_an_alarm", trend.visits_an_alarm},
                         {"charts", list},
                         {"speed", speeds_json(records)},
                         {"next", next_json(trend, last_s)}});
}

}  // namespace octant::app
