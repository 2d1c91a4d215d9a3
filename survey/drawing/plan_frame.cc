// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/plan_frame.h"

#include <algorithm>
#include <cmath>

#include "models/physics/polygon.h"

namespace octant::survey {

double round_down(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  const double lead = x / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}

bool is_drawn(const DeploymentBeacon& beacon) {
  return beacon.status != BeaconStatus::kUndetermined && beacon.position_m.allFinite();
}

const DeploymentBeacon* drawn_beacon(const Deployment& deployment, const std::string& name) {
  const auto at = std::ranges::find(deployment.beacons, name, &DeploymentBeacon::name);
  return at != deployment.beacons.end() && is_drawn(*at) ? &*at : nullptr;
}

std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& points_m) {
  const std::size_t stride = points_m.size() / kMaxMarks + 1;
  std::vector<Eigen::Vector3d> few;
  for (std::size_t i = 0; i < points_m.size(); i += stride)
    if (points_m[i].allFinite()) few.push_back(points_m[i]);
  return few;
}

PlanFrame plan_frame(const PlanInput& input) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& beacon : input.deployment.beacons)
    if (is_drawn(beacon)) points.emplace_back(beacon.position_m.head<2>());
  for (const auto& track : input.tracks)
    for (const auto& p : track.points_m) points.emplace_back(p.head<2>());
  for (const auto& p : input.fixes_m) points.emplace_back(p.head<2>());
  for (const auto& map : input.maps) {
    if (map.columns == 0) continue;
    points.push_back(map.corner_m);
    points.emplace_back(map.corner_m +
                        map.cell_m * Eigen::Vector2d(static_cast<double>(map.columns),
                                                     static_cast<double>(map.values.size() / map.columns)));
  }
  PlanFrame frame;
  if (const Eigen::AlignedBox2d box = bounds_of(points); !box.isEmpty())
    frame.low_m = box.min(), frame.high_m = box.max();
  // A margin, and limits of the aspect ratio for corridors and masts.
  const Eigen::Vector2d middle = (frame.low_m + frame.high_m) / 2;
  Eigen::Vector2d size = (frame.high_m - frame.low_m) * 1.12;
  size = size.cwiseMax(Eigen::Vector2d::Constant(std::max(1.0e-3, 0.3 * size.maxCoeff())));
  if (size.y() > size.x()) size.x() = size.y();
  frame.low_m = middle - size / 2;
  frame.high_m = middle + size / 2;
  frame.px_per_m = (kPlanWidth_px - 2 * kPlanMargin_px) / size.x();
  frame.height_px = 2 * kPlanMargin_px + size.y() * frame.px_per_m;
  return frame;
}

}  // namespace octant::survey
