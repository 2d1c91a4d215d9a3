// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/validity.h"

#include <algorithm>
#include <cmath>

#include "models/physics/plane.h"
#include "models/physics/polygon.h"
#include "models/support/utc_time.h"

namespace octant {
namespace {

double extent_m(const std::vector<Eigen::Vector2d>& area) {
  double largest = 0.0;
  for (const auto& a : area)
    for (const auto& b : area) largest = std::max(largest, (a - b).norm());
  return largest;
}

void check_temperature(const Deployment& d, const MeasurementLog& run, OutsideValidity& out) {
  if (d.medium.model == MediumModel::kConstant) return;
  const auto stated = stated_temperatures(run);
  out.reference_assumed = !stated && !run.arrivals.empty();
  if (!stated || !d.validity_temperature_degC) return;
  const double below = (*d.validity_temperature_degC)[0] - kTemperatureMargin_degC - (*stated)[0];
  const double above = (*stated)[1] - (*d.validity_temperature_degC)[1] - kTemperatureMargin_degC;
  if (std::max(below, above) > 0.0) out.temperature_degC = below > above ? (*stated)[0] : (*stated)[1];
}

constexpr double kInThePlane95 =
    2.4477;  ///< square root of the 95 % quantile of chi-square with two degrees of freedom
constexpr double kLongest_months = 1200.0;  ///< later dates are not reported

/// Months until a beacon may have left the tolerance.
double months_within(const DeploymentBeacon& b, double tolerance_m, double drift_m_per_month) {
  const Eigen::Matrix3d& P = b.covariance_m2;
  const double variance = std::max(0.0, largest_eigenvalue(P(0, 0), P(0, 1), P(1, 1)));
  const double room = std::pow(tolerance_m / kInThePlane95, 2) - variance;
  return room > 0.0 ? std::sqrt(room) / drift_m_per_month : 0.0;
}

}  // namespace

std::optional<CalibrationDue> calibration_due(const Deployment& d) {
  const std::optional<std::int64_t> created_s = utc_seconds(d.created);
  if (!created_s) return std::nullopt;
  double months = d.validity_period.months.value_or(INFINITY);
  CalibrationDue due;
  if (d.validity_period.beacon_drift_m_per_month && d.tolerance.beacon_m)
    for (const DeploymentBeacon& b : d.beacons) {
      if (b.status == BeaconStatus::kUndetermined) continue;
      const double within =
          months_within(b, *d.tolerance.beacon_m, *d.validity_period.beacon_drift_m_per_month);
      if (within >= months) continue;
      months = within;
      due.beacon = b.name;
    }
  if (!(months <= kLongest_months)) return std::nullopt;
  due.at_s = *created_s + static_cast<std::int64_t>(months * kSecondsAMonth);
  return due;
}

std::optional<std::array<double, 2>> stated_temperatures(const MeasurementLog& run) {
  double coldest = INFINITY, warmest = -INFINITY;
  const auto take = [&](double temperature_degC) {
    if (!std::isfinite(temperature_degC)) return;
    coldest = std::min(coldest, temperature_degC);
    warmest = std::max(warmest, temperature_degC);
  };
  for (const Arrival& a : run.arrivals)
    take(std::isfinite(a.temperature_degC) ? a.temperature_degC : run.temperature_degC.value_or(NAN));
  if (run.arrivals.empty() && run.temperature_degC) take(*run.temperature_degC);
  if (coldest > warmest) return std::nullopt;
  return std::array<double, 2>{coldest, warmest};
}

double distance_from_area_m(const std::vector<Eigen::Vector2d>& area, const Eigen::Vector2d& point) {
  return area.empty() || is_inside(area, point) ? 0.0 : distance_to_outline_m(area, point);
}

double distance_from_validity_m(const Deployment& d, const Eigen::Vector3d& p) {
  double off_m = 0.0;
  if (const auto& heights = d.validity_heights_m)
    off_m = std::max({0.0, (*heights)[0] - p.z(), p.z() - (*heights)[1]});
  return std::hypot(off_m, distance_from_area_m(d.validity_area_m, p.head<2>()));
}

OutsideValidity outside_validity(const Deployment& d, const MeasurementLog& run, std::span<const Fix> fixes) {
  OutsideValidity out;
  check_temperature(d, run, out);
  const double margin_m = kAreaMargin * extent_m(d.validity_area_m);
  for (const Fix& fix : fixes) {
    if (!fix.ok()) continue;
    ++out.fixes;
    const double away_m = distance_from_validity_m(d, fix.T_map_vehicle.translation_m);
    if (away_m <= margin_m) continue;
    ++out.outside;
    out.farthest_m = std::max(out.farthest_m, away_m);
  }
  return out;
}

}  // namespace octant
