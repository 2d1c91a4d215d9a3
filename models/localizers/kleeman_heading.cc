// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman_heading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/pose.h"

namespace octant {
namespace {

constexpr double kOverhead = 0.05;  // cosine of the elevation below which a beacon has no direction in the plan
constexpr int kMaxSteps = 20;

/// Normal equation of the heading, from each beacon's arrivals less their mean.
struct Normal {
  double information = 0.0, gradient = 0.0, chi2 = 0.0;
  Eigen::RowVector2d coupling = Eigen::RowVector2d::Zero();
};

Normal normal_equation(const HeadingInput& in, double heading_rad) {
  Normal sum;
  for (std::size_t b = 0; b < in.beacon_p_map_m.size(); ++b) {
    double w = 0.0, r = 0.0, j = 0.0, rr = 0.0, rj = 0.0, jj = 0.0;
    Eigen::RowVector2d k = Eigen::RowVector2d::Zero(), jk = Eigen::RowVector2d::Zero();
    for (const HeardDistance& h : in.heard) {
      if (h.beacon != b || !h.kept) continue;
      const ReceiverPath path = receiver_path(in.beacon_p_map_m[b], in.receivers[h.receiver], in.p_map_m, heading_rad);
      const double weight = 1 / (h.sigma_m * h.sigma_m), residual_m = h.slant_m - path.slant_m;
      w += weight;
      r += weight * residual_m;
      j += weight * path.by_heading;
      k += weight * path.by_position;
      rr += weight * residual_m * residual_m;
      rj += weight * residual_m * path.by_heading;
      jj += weight * path.by_heading * path.by_heading;
      jk += weight * path.by_heading * path.by_position;
    }
    if (!(w > 0)) continue;
    sum.chi2 += rr - r * r / w;
    sum.gradient += rj - r * j / w;
    sum.information += jj - j * j / w;
    sum.coupling += jk - j * k / w;
  }
  return sum;
}

double best_of_grid(const HeadingInput& in) {
  constexpr int kHeadings = 36;
  double best_rad = 0.0, best_chi2 = normal_equation(in, 0.0).chi2;
  for (int i = 1; i < kHeadings; ++i) {
    const double heading_rad = 2 * std::numbers::pi * i / kHeadings;
    const double chi2 = normal_equation(in, heading_rad).chi2;
    if (chi2 < best_chi2) best_chi2 = chi2, best_rad = heading_rad;
  }
  return best_rad;
}

}  // namespace

ReceiverPath receiver_path(const Eigen::Vector3d& beacon, const ArrayReceiver& receiver, const Eigen::Vector2d& p,
                           double heading_rad) {
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  const Eigen::Vector3d& o = receiver.position_m;
  const Eigen::Vector2d lever(c * o.x() - s * o.y(), s * o.x() + c * o.y());
  const Eigen::Vector2d from = p + lever - beacon.head<2>();
  const double height_m = beacon.z() - o.z();
  ReceiverPath path;
  path.slant_m = std::sqrt(from.squaredNorm() + height_m * height_m);
  const Eigen::Vector2d e = path.slant_m > 0 ? Eigen::Vector2d(from / path.slant_m) : Eigen::Vector2d::Zero();
  path.by_position = e.transpose();
  path.by_heading = e.y() * lever.x() - e.x() * lever.y();
  return path;
}

Heading heading_from_hearing(const HeadingInput& in) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int beacons = 0;
  Heading heading;
  for (std::size_t b = 0; b < in.beacon_p_map_m.size(); ++b) {
    Eigen::Vector2d heard_from = Eigen::Vector2d::Zero();
    for (const HeardDistance& h : in.heard) {
      if (h.beacon == b && h.kept && in.receivers[h.receiver].axis) heard_from += *in.receivers[h.receiver].axis;
    }
    const Eigen::Vector2d to = in.beacon_p_map_m[b].head<2>() - in.p_map_m;
    const double height_m = in.beacon_p_map_m[b].z() - in.receivers.front().position_m.z();
    if (heard_from.norm() < 1e-3 || to.norm() < kOverhead * std::hypot(to.norm(), height_m)) continue;
    // Bearing in the map less bearing in the vehicle: a complex quotient.
    const Eigen::Vector2d u = to.normalized(), v = heard_from.normalized();
    sum += Eigen::Vector2d(u.x() * v.x() + u.y() * v.y(), u.y() * v.x() - u.x() * v.y());
    heading.by_position += Eigen::RowVector2d(u.y(), -u.x()) / to.norm();
    ++beacons;
  }
  if (beacons == 0 || sum.norm() < 1e-3 * beacons) return heading;
  const auto axes =
      std::count_if(in.receivers.begin(), in.receivers.end(), [](const ArrayReceiver& r) { return r.axis.has_value(); });
  heading.known = true;
  heading.rad = std::atan2(sum.y(), sum.x());
  heading.sigma_rad = 2 * std::numbers::pi / static_cast<double>(axes) / std::sqrt(12.0 * beacons);
  heading.by_position /= beacons;
  return heading;
}

Heading heading_from_differences(const HeadingInput& in, const Heading& start) {
  Heading heading;
  heading.rad = start.known ? start.rad : best_of_grid(in);
  Normal normal;
  for (int i = 0; i < kMaxSteps; ++i) {
    normal = normal_equation(in, heading.rad);
    if (!(normal.information * std::numbers::pi * std::numbers::pi > 1)) return Heading{};  // nothing is told of an angle
    const double step_rad = std::clamp(normal.gradient / normal.information, -0.5, 0.5);
    heading.rad = wrap_angle(heading.rad + step_rad);
    if (std::abs(step_rad) < 1e-10) break;
  }
  heading.known = true;
  heading.sigma_rad = 1 / std::sqrt(normal.information);
  heading.by_position = -normal.coupling / normal.information;
  return heading;
}

}  // namespace octant
