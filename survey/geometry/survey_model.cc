// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/survey_model.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace octant::survey {

Unknowns unknowns_of(Motion motion, Clock clock, const std::vector<SurveyReceiver>& receivers) {
  constexpr double kApart = 1e-6;
  Unknowns u{.position = motion == Motion::kPlanar ? 2 : 3, .clock = clock == Clock::kCycleOffset};
  Eigen::Vector3d longest = Eigen::Vector3d::Zero();
  double widest = 0.0;
  for (const SurveyReceiver& r : receivers) {
    Eigen::Vector3d arm = r.p_vehicle_m - receivers.front().p_vehicle_m;
    if (motion == Motion::kPlanar) arm.z() = 0.0;
    if (arm.norm() > longest.norm()) longest = arm;
  }
  for (const SurveyReceiver& r : receivers)
    widest =
        std::max(widest, longest.normalized().cross(r.p_vehicle_m - receivers.front().p_vehicle_m).norm());
  if (motion == Motion::kPlanar) u.rotation = longest.norm() > kApart ? 1 : 0;
  if (motion == Motion::kSpatial) u.rotation = longest.norm() > kApart && widest > kApart ? 3 : 0;
  return u;
}

double reach_m(const Hearing& hearing) {
  if (!(hearing.threshold_v > 0)) return hearing.range_m;
  // A(d) falls everywhere: bisection between a micrometre and where spreading alone has brought it below.
  const auto heard = [&](double d) {
    return hearing.amplitude_1m_v * std::exp(-hearing.absorption_np_per_m * d) >= hearing.threshold_v * d;
  };
  double low = 0.0, high = hearing.amplitude_1m_v / hearing.threshold_v;
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (heard(middle) ? low : high) = middle;
  }
  return std::min(hearing.range_m, low);
}

}  // namespace octant::survey
