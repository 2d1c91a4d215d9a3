// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/arrival_range.h"

#include <algorithm>
#include <cmath>

#include "models/physics/range.h"

namespace octant {

ArrivalRange arrival_range(const Arrival& arrival, const Deployment& deployment) noexcept {
  ArrivalRange out;
  const bool two_way = deployment.timing.ranging == Ranging::kTwoWay;
  const double legs = deployment.timing.legs();
  // Chang eq. 2 if the model of the medium is linear_temperature.
  out.speed_mps =
      deployment.speed_mps(std::isfinite(arrival.temperature_degC) ? arrival.temperature_degC
                                                                   : deployment.medium.temperature_degC);
  // Chang eq. 1; the time t of Thamma eq. 4.
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
  const AttenuationModel& a = *deployment.attenuation;
  const double log_gain = std::log(deployment.beacons[arrival.beacon.index()].gain);
  const double share = a.threshold_v / arrival.amplitude_v;
  if (!a.measures(arrival.amplitude_v) ||
      !(share < 1.0)) {  // not logged, or noise that is not above the threshold
    const TimedRange range = range_with_walk({flight_s, out.speed_mps, legs}, a, log_gain);
    out.range_m = range.range_m;
    out.gain_mps = range.by_time_mps;
    out.sigma_m = out.gain_mps * tof_sigma_s;
    if (a.directional() &&
        deployment.receivers[arrival.receiver.index()].axis)  // the direction of the beacon is not known here
      out.sigma_m = std::hypot(out.sigma_m, out.gain_mps * off_axis_walk_sigma_s(out.range_m, a, log_gain));
    return out;
  }
  out.range_m = (path_m - out.speed_mps * walk_of_share_s(std::min(share, kMostMeasuredShare), a)) / legs;
  const double walk_sigma_s =
      walk_by_log_amplitude_s(arrival.amplitude_v, a) * deployment.noise.amplitude_relative_sigma;
  out.sigma_m = out.gain_mps * std::hypot(tof_sigma_s, walk_sigma_s);
  if (!(out.range_m > 0)) out.range_m = std::numeric_limits<double>::quiet_NaN();
  return out;
}

}  // namespace octant
