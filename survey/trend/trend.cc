// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/trend/trend.h"

#include <algorithm>
#include <cmath>

#include "models/watch/cusum.h"

namespace octant::survey {
namespace {

/// Significance of a drift in sigmas: of twenty sites with some twenty quantities each and no drift, one
/// shows a drift.
constexpr double kTold_sigmas = 3.0;
/// Values of one week are one visit as far as drift goes.
constexpr double kShortestSpan_s = 7 * 86400.0;

/// Weighted mean of independent values.
struct WeightedMean {
  double weight = 0.0, sum = 0.0;
  void add(double value, double sigma) {
    weight += 1.0 / (sigma * sigma);
    sum += value / (sigma * sigma);
  }
  [[nodiscard]] double mean() const { return sum / weight; }
  [[nodiscard]] double variance() const { return 1.0 / weight; }
};

/// One level: from `first` on, until an alarm or the end.
class Level {
 public:
  Level(std::vector<ChartPoint>& points, std::size_t first, double k, double h, double smallest_sigma)
      : points_(points), first_(first), cusum_{k, h}, smallest_sigma_(smallest_sigma) {}

  /// The first point with an alarm after `silent_until`; earlier points may exceed the limit without an
  /// alarm.
  [[nodiscard]] std::optional<Shift> run(std::size_t silent_until) {
    for (std::size_t i = first_; i < points_.size(); ++i) {
      ChartPoint& p = points_[i];
      p = ChartPoint{p.measured, std::nullopt, 0.0, 0.0, 0.0, 0};
      const double sigma = std::max(p.measured.sigma, smallest_sigma_);
      if (i > first_) {
        p.foretold = mean_.mean();
        p.deviation_sigmas = (p.measured.value - mean_.mean()) / std::sqrt(sigma * sigma + mean_.variance());
        cusum_.add(p.deviation_sigmas);
      }
      p.upper = cusum_.upper.value;
      p.lower = cusum_.lower.value;
      if (i > silent_until) p.alarm = cusum_.alarm();
      if (p.alarm != 0) return shift_before(i);
      add(i, mean_);
    }
    return std::nullopt;
  }

 private:
  /// The likeliest place of a change that was noticed at a point: where the levels before and after differ by
  /// most sigmas. (Where the sum last left zero may be a point too early, and that one would spoil the new
  /// level.)
  [[nodiscard]] Shift shift_before(std::size_t at) const {
    Shift best{at, at, 0.0, 1.0, false};
    WeightedMean all;
    for (std::size_t i = first_; i <= at; ++i) add(i, all);
    WeightedMean before;
    for (std::size_t since = first_ + 1; since <= at; ++since) {
      add(since - 1, before);
      const WeightedMean after{all.weight - before.weight, all.sum - before.sum};
      const Shift shift{at, since, after.mean() - before.mean(),
                        std::sqrt(after.variance() + before.variance()), false};
      if (std::abs(shift.size) / shift.sigma > std::abs(best.size) / best.sigma) best = shift;
    }
    return best;
  }
  void add(std::size_t i, WeightedMean& mean) const {
    mean.add(points_[i].measured.value, std::max(points_[i].measured.sigma, smallest_sigma_));
  }

  std::vector<ChartPoint>& points_;
  std::size_t first_;
  Cusum cusum_;
  WeightedMean mean_;
  double smallest_sigma_;
};

/// Weighted straight line through points [first, last].
struct LineFit {
  double slope = 0.0, slope_weight = 0.0;  ///< no slope where the weight is zero: all at one time
  double chi2 = 0.0;
};

LineFit fit_line(const std::vector<ChartPoint>& points, std::size_t first, std::size_t last,
                 double smallest_sigma) {
  const auto weight = [&](const TrendValue& m) {
    return 1.0 / std::pow(std::max(m.sigma, smallest_sigma), 2);
  };
  double w = 0.0, t = 0.0, v = 0.0;
  for (std::size_t i = first; i <= last; ++i) {
    const TrendValue& m = points[i].measured;
    w += weight(m);
    t += weight(m) * m.time_s;
    v += weight(m) * m.value;
  }
  const double centre_s = t / w, centre = v / w;
  LineFit fit;
  double tv = 0.0;
  for (std::size_t i = first; i <= last; ++i) {
    const TrendValue& m = points[i].measured;
    fit.slope_weight += weight(m) * std::pow(m.time_s - centre_s, 2);
    tv += weight(m) * (m.time_s - centre_s) * (m.value - centre);
  }
  if (fit.slope_weight > 0.0) fit.slope = tv / fit.slope_weight;
  for (std::size_t i = first; i <= last; ++i) {
    const TrendValue& m = points[i].measured;
    fit.chi2 += weight(m) * std::pow(m.value - centre - fit.slope * (m.time_s - centre_s), 2);
  }
  return fit;
}

double chi2_of_level(const std::vector<ChartPoint>& points, std::size_t first, std::size_t last,
                     double smallest_sigma) {
  WeightedMean mean;
  for (std::size_t i = first; i <= last; ++i)
    mean.add(points[i].measured.value, std::max(points[i].measured.sigma, smallest_sigma));
  double chi2 = 0.0;
  for (std::size_t i = first; i <= last; ++i)
    chi2 += std::pow(
        (points[i].measured.value - mean.mean()) / std::max(points[i].measured.sigma, smallest_sigma), 2);
  return chi2;
}

/// Returns true if a line through all values explains them better than two levels.
bool is_drift(const std::vector<ChartPoint>& points, std::size_t first, const Shift& shift,
              double smallest_sigma) {
  if (shift.at - first < 3) return false;
  const double steps = chi2_of_level(points, first, shift.since - 1, smallest_sigma) +
                       chi2_of_level(points, shift.since, shift.at, smallest_sigma);
  return fit_line(points, first, shift.at, smallest_sigma).chi2 < steps;
}

std::optional<Drift> drift_of(const std::vector<ChartPoint>& points, std::size_t first,
                              double smallest_sigma) {
  const LineFit fit = fit_line(points, first, points.size() - 1, smallest_sigma);
  const double span_s = points.back().measured.time_s - points[first].measured.time_s;
  if (!(fit.slope_weight > 0.0) || span_s < kShortestSpan_s) return std::nullopt;
  const double count = static_cast<double>(points.size() - first);
  const double factor = count > 2.0 ? std::max(1.0, fit.chi2 / (count - 2.0)) : 1.0;
  return Drift{fit.slope, std::sqrt(factor / fit.slope_weight), points.back().measured.time_s};
}

}  // namespace

ControlChart control_chart(const std::vector<TrendValue>& values, double k, double h, double smallest_sigma) {
  ControlChart chart;
  for (const TrendValue& value : values) chart.points.push_back({.measured = value, .foretold = {}});
  std::size_t first = 0, silent_until = 0, drifts_since = 0;
  while (first < chart.points.size()) {
    auto shift = Level(chart.points, first, k, h, smallest_sigma).run(silent_until);
    if (!shift) break;
    shift->by_drift = is_drift(chart.points, drifts_since, *shift, smallest_sigma);
    if (!shift->by_drift) drifts_since = shift->since;
    chart.shifts.push_back(*shift);
    // Points since the change start a new chart, relative to the new level.
    first = shift->since;
    silent_until = shift->at;
  }
  for (const Shift& shift : chart.shifts) chart.points[shift.at].alarm = shift.size > 0.0 ? 1 : -1;
  if (!chart.points.empty()) chart.drift = drift_of(chart.points, drifts_since, smallest_sigma);
  return chart;
}

Forecast forecast(const Drift& drift, double limit) {
  const double size = std::abs(drift.per_s), spread = 2.0 * drift.sigma_per_s;
  Forecast out;
  out.earliest_s = drift.last_time_s + limit / std::max(size + spread, 1e-300);
  if (size <= kTold_sigmas * drift.sigma_per_s) return out;
  out.due_s = drift.last_time_s + limit / size;
  out.latest_s = drift.last_time_s + limit / (size - spread);
  return out;
}

}  // namespace octant::survey
