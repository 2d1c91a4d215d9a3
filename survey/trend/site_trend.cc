// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/trend/site_trend.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "models/support/enum_names.h"
#include "models/watch/cusum.h"

namespace octant::survey {
namespace {

constexpr TrendQuantity kOfABeacon[] = {TrendQuantity::kX, TrendQuantity::kY, TrendQuantity::kZ,
                                        TrendQuantity::kDelay};

/// Sigmas with which a change of a fixed quantity is weighted: 10 um, 10 ns, 1 mm/s.
double smallest_sigma(TrendQuantity quantity) {
  switch (quantity) {
    case TrendQuantity::kDelay: return 1e-8;
    case TrendQuantity::kSpeedOffset: return 1e-3;
    default: return 1e-5;
  }
}

TrendValue value_of(const DeploymentBeacon& b, TrendQuantity quantity, double time_s) {
  if (quantity == TrendQuantity::kDelay) return {time_s, b.delay_s, b.delay_sigma_s};
  const auto axis = static_cast<Eigen::Index>(quantity);
  return {time_s, b.position_m[axis], std::sqrt(std::max(0.0, b.covariance_m2(axis, axis)))};
}

std::vector<std::string> names_in_order(const std::vector<CalibrationRecord>& records) {
  std::vector<std::string> names;
  for (const CalibrationRecord& record : records)
    for (const DeploymentBeacon& b : record.beacons)
      if (std::ranges::find(names, b.name) == names.end()) names.push_back(b.name);
  return names;
}

std::vector<TrendValue> series_of(const std::vector<CalibrationRecord>& records, const std::string& beacon,
                                  TrendQuantity quantity) {
  std::vector<TrendValue> values;
  for (const CalibrationRecord& record : records)
    for (const DeploymentBeacon& b : record.beacons)
      if (b.name == beacon && b.status != BeaconStatus::kUndetermined)
        values.push_back(value_of(b, quantity, record.time_s));
  return values;
}

std::vector<TrendValue> speed_series(const std::vector<CalibrationRecord>& records) {
  std::vector<TrendValue> values;
  for (const CalibrationRecord& record : records)
    values.push_back({record.time_s, record.speed_offset_mps, record.speed_sigma_mps});
  return values;
}

bool says_something(const std::vector<TrendValue>& values) {
  return std::ranges::any_of(
      values, [&](const TrendValue& v) { return v.sigma > 0.0 || v.value != values.front().value; });
}

/// Half of the largest distance between two beacons, at least a metre: how far sound typically has to go.
double typical_reach_m(const CalibrationRecord& record) {
  double widest_m = 2.0;
  for (const DeploymentBeacon& a : record.beacons)
    for (const DeploymentBeacon& b : record.beacons)
      if (a.status != BeaconStatus::kUndetermined && b.status != BeaconStatus::kUndetermined)
        widest_m = std::max(widest_m, (a.position_m - b.position_m).norm());
  return 0.5 * widest_m;
}

double limit_of(TrendQuantity quantity, double limit_m, const CalibrationRecord& last) {
  switch (quantity) {
    case TrendQuantity::kDelay: return limit_m / last.speed_mps;
    case TrendQuantity::kSpeedOffset: return limit_m * last.speed_mps / typical_reach_m(last);
    default: return limit_m;
  }
}

/// Time at which the last level of a chart begins; the first of all times if there is only one level.
double begins_s(const ControlChart& chart) {
  double begins = -INFINITY;
  for (const Shift& shift : chart.shifts)
    if (!shift.by_drift) begins = std::max(begins, chart.points[shift.since].measured.time_s);
  return begins;
}

/// A beacon that moved stands elsewhere in all its coordinates, also in those in which that is within chance:
/// no drift goes across the move.
void begin_anew_together(const std::vector<std::vector<TrendValue>>& series, const TrendOptions& options,
                         SiteTrend& trend) {
  const auto is_place = [](const QuantityTrend& q) {
    return q.quantity == TrendQuantity::kX || q.quantity == TrendQuantity::kY ||
           q.quantity == TrendQuantity::kZ;
  };
  for (std::size_t i = 0; i < series.size(); ++i) {
    QuantityTrend& q = trend.quantities[i];
    double moved_s = -INFINITY;
    for (const QuantityTrend& other : trend.quantities)
      if (is_place(q) && is_place(other) && other.subject == q.subject)
        moved_s = std::max(moved_s, begins_s(other.chart));
    if (!(moved_s > begins_s(q.chart))) continue;
    std::vector<TrendValue> since;
    std::ranges::copy_if(series[i], std::back_inserter(since),
                         [moved_s](const TrendValue& v) { return v.time_s >= moved_s; });
    q.chart.drift = control_chart(since, options.cusum_k, trend.cusum_h, smallest_sigma(q.quantity)).drift;
  }
}

void find_next(SiteTrend& trend) {
  for (std::size_t i = 0; i < trend.quantities.size(); ++i) {
    const auto& forecast = trend.quantities[i].forecast;
    if (!forecast) continue;
    if (!trend.earliest || forecast->earliest_s < trend.quantities[*trend.earliest].forecast->earliest_s)
      trend.earliest = i;
    if (forecast->due_s && (!trend.due || *forecast->due_s < *trend.quantities[*trend.due].forecast->due_s))
      trend.due = i;
  }
}

}  // namespace

const char* to_string(TrendQuantity quantity) {
  static constexpr auto kNames =
      enum_names<TrendQuantity>("x_m", "y_m", "z_m", "delay_s", "speed_offset_mps");
  return kNames[quantity];
}

SiteTrend site_trend(const std::vector<CalibrationRecord>& records, const TrendOptions& options) {
  SiteTrend trend;
  trend.visits_an_alarm = options.visits_an_alarm;
  if (records.empty()) return trend;
  std::vector<std::vector<TrendValue>> series;
  const auto chart = [&](const std::string& subject, TrendQuantity quantity, std::vector<TrendValue> values) {
    if (!says_something(values)) return;
    trend.quantities.push_back({.subject = subject,
                                .quantity = quantity,
                                .chart = {},
                                .limit = limit_of(quantity, options.limit_m, records.back()),
                                .forecast = {}});
    series.push_back(std::move(values));
  };
  for (const std::string& name : names_in_order(records))
    for (const TrendQuantity quantity : kOfABeacon) chart(name, quantity, series_of(records, name, quantity));
  chart("medium", TrendQuantity::kSpeedOffset, speed_series(records));
  if (series.empty()) return trend;
  trend.cusum_h =
      cusum_threshold(options.cusum_k, options.visits_an_alarm * static_cast<double>(series.size()));
  for (std::size_t i = 0; i < series.size(); ++i) {
    QuantityTrend& q = trend.quantities[i];
    q.chart = control_chart(series[i], options.cusum_k, trend.cusum_h, smallest_sigma(q.quantity));
  }
  begin_anew_together(series, options, trend);
  for (QuantityTrend& q : trend.quantities)
    if (q.chart.drift) q.forecast = forecast(*q.chart.drift, q.limit);
  find_next(trend);
  return trend;
}

}  // namespace octant::survey
