// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/rail/rail_path.h"

#include <algorithm>
#include <cmath>

#include "models/physics/plane.h"

namespace octant {
namespace {

RailPlaces two_places(const Rail& rail, double middle_m, double half_m) {
  if (half_m == 0.0) return {{rail_wrapped_m(rail, middle_m), 0.0}, 1};
  return {{rail_wrapped_m(rail, middle_m - half_m), rail_wrapped_m(rail, middle_m + half_m)}, 2};
}

RailPlaces straight_places(const Rail& rail, const Eigen::Vector3d& o, const Eigen::Vector3d& p,
                           double range_m, double slack_m) {
  const Eigen::Vector2d along = (rail.to_m - rail.from_m).normalized(), across = left_of(along);
  // Vector to the beacon from the receiver of a vehicle at s = 0.
  const Eigen::Vector2d off = p.head<2>() - rail.from_m - along * o.x() - across * o.y();
  const double nearest_m = std::hypot(across.dot(off), p.z() - o.z());
  if (range_m < nearest_m - slack_m) return {};
  const double half2 = (range_m - nearest_m) * (range_m + nearest_m);
  return two_places(rail, along.dot(off), half2 > 0 ? std::sqrt(half2) : 0.0);
}

RailPlaces arc_places(const Rail& rail, const Eigen::Vector3d& o, const Eigen::Vector3d& p, double range_m,
                      double slack_m) {
  // The heading is a right angle ahead of the radius, so the vehicle's left side faces the centre of the
  // receiver's circle.
  const double rho_m = std::hypot(rail.radius_m - o.y(), o.x()),
               ahead_rad = std::atan2(o.x(), rail.radius_m - o.y());
  const Eigen::Vector2d off = p.head<2>() - rail.centre_m;
  const double C = off.norm(), rise_m = p.z() - o.z();
  if (!(C * rho_m > 0)) return {};
  const double least_m = std::hypot(C - rho_m, rise_m), most_m = std::hypot(C + rho_m, rise_m);
  if (!(most_m - least_m > 2 * slack_m) || range_m < least_m - slack_m || range_m > most_m + slack_m)
    return {};
  // Law of cosines at the centre in half angles, tan^2(gamma / 2) = (d^2 - least^2) / (most^2 - d^2), which
  // is exact at both ends.
  const double beyond2 = std::max(0.0, (range_m - least_m) * (range_m + least_m));
  const double before2 = std::max(0.0, (most_m - range_m) * (most_m + range_m));
  const double gamma_rad = 2 * std::atan2(std::sqrt(beyond2), std::sqrt(before2));
  return two_places(rail, rail.radius_m * (angle_of(off) - ahead_rad), rail.radius_m * gamma_rad);
}

}  // namespace

RailPoint rail_point(const Rail& rail, double s_m) {
  RailPoint out;
  if (rail.shape == Rail::Shape::kStraight) {
    const Eigen::Vector2d along = (rail.to_m - rail.from_m).normalized();
    const Eigen::Vector2d p = rail.from_m + s_m * along;
    out.T_map_vehicle = Pose::planar(p.x(), p.y(), angle_of(along));
    out.by_s << along, 0.0;
    return out;
  }
  const double phi = s_m / rail.radius_m;
  const Eigen::Vector2d radial = direction_of(phi), tangent = left_of(radial);
  const Eigen::Vector2d p = rail.centre_m + rail.radius_m * radial;
  out.T_map_vehicle = Pose::planar(p.x(), p.y(), wrap_angle(phi + M_PI / 2));
  out.by_s << tangent, 1 / rail.radius_m;
  return out;
}

double rail_length_m(const Rail& rail) {
  return rail.shape == Rail::Shape::kStraight ? (rail.to_m - rail.from_m).norm() : 2 * M_PI * rail.radius_m;
}

double rail_wrapped_m(const Rail& rail, double s_m) {
  return rail.shape == Rail::Shape::kStraight ? s_m : rail.radius_m * wrap_angle(s_m / rail.radius_m);
}

RailPlaces rail_places(const Rail& rail, const Eigen::Vector3d& o_vehicle_m,
                       const Eigen::Vector3d& p_beacon_m, double range_m, double slack_m) {
  if (!(std::isfinite(range_m) && range_m > 0)) return {};
  return rail.shape == Rail::Shape::kStraight
             ? straight_places(rail, o_vehicle_m, p_beacon_m, range_m, slack_m)
             : arc_places(rail, o_vehicle_m, p_beacon_m, range_m, slack_m);
}

}  // namespace octant
