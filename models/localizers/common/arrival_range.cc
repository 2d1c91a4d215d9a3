// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/arrival_range.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace octant {
namespace {

constexpr double kMaxImplicitShare = 0.995;  // as in the measurement equation: the logarithm is held beyond
constexpr double kMinImplicitDistance_m = 1e-6;

double walk_of_share_s(double share, const AttenuationModel& a) {
  return -a.rise_time_s * std::log1p(-share);
}

struct ImplicitWalk {
  double walk_s = 0.0;
  double by_distance = 0.0;  ///< s/m
};

ImplicitWalk predicted_walk(double distance_m, const AttenuationModel& a) {
  const double share = a.threshold_v / amplitude_v(distance_m, a);
  if (!(share < kMaxImplicitShare)) return {walk_of_share_s(kMaxImplicitShare, a), 0.0};
  const double steepness_s = a.rise_time_s * share / (1 - share);  // d walk / d ln(1/A)
  return {walk_of_share_s(share, a), steepness_s * (1 / distance_m + a.absorption_np_per_m)};
}

/// legs d + c walk(d) = path: the left side rises with d, so Newton's step is kept within a bracket.
void solve_with_predicted_walk(double path_m, double legs, double tof_sigma_s, const AttenuationModel& a,
                               ArrivalRange& out) {
  double low_m = kMinImplicitDistance_m, high_m = std::max(path_m / legs, kMinImplicitDistance_m),
         d_m = high_m;
  double slope = legs;
  for (int i = 0; i < 80; ++i) {
    const ImplicitWalk walk = predicted_walk(d_m, a);
    const double excess_m = legs * d_m + out.speed_mps * walk.walk_s - path_m;
    slope = legs + out.speed_mps * walk.by_distance;
    (excess_m > 0 ? high_m : low_m) = d_m;
    double next_m = d_m - excess_m / slope;
    if (!(next_m > low_m && next_m < high_m)) next_m = 0.5 * (low_m + high_m);
    const bool settled = std::abs(next_m - d_m) < 1e-15 * high_m;
    d_m = next_m;
    if (settled) break;
  }
  out.range_m = d_m;
  out.gain_mps = out.speed_mps / slope;
  out.sigma_m = out.gain_mps * tof_sigma_s;
}

}  // namespace

ArrivalRange arrival_range(const Arrival& arrival, const Deployment& deployment) noexcept {
  ArrivalRange out;
  const bool two_way = deployment.timing.ranging == Ranging::kTwoWay;
  const double legs = two_way ? 2.0 : 1.0;
  // Chang eq. 2 where the medium's model is linear_temperature.
  out.speed_mps =
      deployment.speed_mps(std::isfinite(arrival.temperature_degC) ? arrival.temperature_degC
                                                                   : deployment.medium.temperature_degC);
  // Chang eq. 1; the t of Thamma eq. 4.
  const double flight_s = arrival.tof_s - deployment.beacons[arrival.beacon.index()].delay_s -
                          deployment.receivers[arrival.receiver.index()].delay_s -
                          (two_way ? deployment.timing.turnaround_s : 0.0);
  if (!(std::isfinite(flight_s) && flight_s > 0)) return out;
  const double path_m = out.speed_mps * flight_s;  // Chang eq. 3, Thamma eq. 4
  const double tof_sigma_s = deployment.noise.tof_sigma_s;
  out.gain_mps = out.speed_mps / legs;
  out.sigma_m = out.gain_mps * tof_sigma_s;
  out.range_m = path_m / legs;
  if (!deployment.attenuation) return out;
  AttenuationModel a = *deployment.attenuation;
  a.amplitude_1m_v *= deployment.beacons[arrival.beacon.index()].gain;
  const double share = a.threshold_v / arrival.amplitude_v;
  if (!a.measures(arrival.amplitude_v) ||
      !(share < kMaxImplicitShare)) {  // not logged, or (noise) not above the threshold
    solve_with_predicted_walk(path_m, legs, tof_sigma_s, a, out);
    if (a.directional() && deployment.receivers[arrival.receiver.index()].axis) {
      // From where it hears is not known here: as much later as off the axis by the half-power angle.
      AttenuationModel off_axis = a;
      off_axis.amplitude_1m_v /= std::numbers::sqrt2;
      out.sigma_m = std::hypot(out.sigma_m, out.gain_mps * (predicted_walk(out.range_m, off_axis).walk_s -
                                                            predicted_walk(out.range_m, a).walk_s));
    }
    return out;
  }
  out.range_m = (path_m - out.speed_mps * walk_of_share_s(share, a)) / legs;
  const double walk_sigma_s = a.rise_time_s * share / (1 - share) * deployment.noise.amplitude_relative_sigma;
  out.sigma_m = out.gain_mps * std::hypot(tof_sigma_s, walk_sigma_s);
  if (!(out.range_m > 0)) out.range_m = std::numeric_limits<double>::quiet_NaN();
  return out;
}

}  // namespace octant
