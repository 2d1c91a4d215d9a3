// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reference for the maps: one arrival at a time, plain geometry, dense inverse; shares no code with survey/.

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

#include "survey/geometry/survey_model.h"

namespace octant::test {

struct BruteArrival {
  std::size_t beacon = 0;
  Eigen::VectorXd row;  ///< derivative of the range by the unknowns
  double distance_m = 0.0, sigma_m = 1.0;
};

inline bool crosses(const survey::WallPiece& wall, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  // from + s (to - from) = wall.from + t (wall.to - wall.from)
  Eigen::Matrix2d A;
  A.col(0) = (to - from).head<2>();
  A.col(1) = wall.from_m - wall.to_m;
  if (std::abs(A.determinant()) < 1e-14) return false;
  const Eigen::Vector2d st = A.inverse() * (wall.from_m - from.head<2>());
  if (st[0] <= 0 || st[0] >= 1 || st[1] < 0 || st[1] > 1) return false;
  const double z = from.z() + st[0] * (to.z() - from.z());
  return z >= wall.bottom_m && z <= wall.top_m;
}

inline double gain_at(const survey::SurveyModel& model, std::size_t pattern, const Eigen::Vector3d& axis,
                      const Eigen::Vector3d& towards) {
  if (pattern == survey::kAllRound || axis.isZero()) return 1.0;
  return beam_gain(model.patterns[pattern], axis.dot(towards));
}

inline std::vector<BruteArrival> brute_arrivals(const survey::SurveyModel& model, double x, double y,
                                                double z, double heading) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const survey::Unknowns& u = model.unknowns;
  std::vector<BruteArrival> arrivals;
  for (std::size_t b = 0; b < model.beacons.size(); ++b)
    for (const auto& receiver : model.receivers) {
      const auto& beacon = model.beacons[b];
      const Eigen::Vector3d place = Eigen::Vector3d(x, y, z) + R * receiver.p_vehicle_m;
      BruteArrival a{b, Eigen::VectorXd::Zero(u.count()), (place - beacon.p_map_m).norm()};
      const Eigen::Vector3d unit = (place - beacon.p_map_m) / a.distance_m;
      const double gain = gain_at(model, beacon.pattern, beacon.axis, unit) *
                          gain_at(model, receiver.pattern, R * receiver.axis, -unit);
      const auto& h = model.hearing;
      if (a.distance_m > h.range_m || gain <= 0) continue;
      if (h.threshold_v > 0 &&
          gain * h.amplitude_1m_v / a.distance_m * std::exp(-h.absorption_np_per_m * a.distance_m) <
              h.threshold_v)
        continue;
      bool hidden = false;
      for (const auto& wall : model.walls) hidden = hidden || crosses(wall, place, beacon.p_map_m);
      if (hidden) continue;
      a.sigma_m = std::sqrt(model.noise.constant_m * model.noise.constant_m +
                            std::pow(model.noise.per_m * a.distance_m, 2) +
                            model.noise.per_sqrt_m * model.noise.per_sqrt_m * a.distance_m);
      a.row.head(u.position) = unit.head(u.position);
      // By numbers: the range after a small turn about an axis of the vehicle.
      for (int k = 0; k < u.rotation; ++k) {
        const Eigen::Vector3d axis = u.rotation == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::Unit(k);
        a.row[u.position + k] = unit.dot(R * axis.cross(receiver.p_vehicle_m));
      }
      if (u.clock) a.row[u.count() - 1] = 1.0;
      arrivals.push_back(a);
    }
  return arrivals;
}

/// Information of rows divided by their sigmas, or unchanged.
inline Eigen::MatrixXd information_of(const survey::SurveyModel& model,
                                      const std::vector<BruteArrival>& arrivals, bool weighted) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(model.unknowns.count(), model.unknowns.count());
  for (const auto& a : arrivals) A += a.row * a.row.transpose() / (weighted ? a.sigma_m * a.sigma_m : 1.0);
  return A;
}

}  // namespace octant::test
