// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/pose_frames.h"

#include <cmath>

namespace octant::calib {
namespace {

/// Reflected at a plane of the map through the z axis, whose normal is (nx, ny): M T M' with M also for the
/// vehicle's y axis.
Pose reflected(const Pose& pose, double nx, double ny) {
  const Eigen::Vector3d n(nx, ny, 0.0);
  const Eigen::Matrix3d map = Eigen::Matrix3d::Identity() - 2.0 * n * n.transpose();
  const Eigen::Matrix3d vehicle = Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal();
  Pose out;
  out.translation_m = map * pose.translation_m;
  out.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(map * pose.rotation.toRotationMatrix() * vehicle)).normalized();
  return out;
}

}  // namespace

const std::vector<Reflection>& reflections() {
  static const std::vector<Reflection> all = {
      {"y and the heading have the wrong sign", [](const Pose& p) { return reflected(p, 0.0, 1.0); }},
      {"x and the sense of the heading are the wrong way round",
       [](const Pose& p) { return reflected(p, 1.0, 0.0); }},
      {"x and y are exchanged, as north and east",
       [](const Pose& p) { return reflected(p, std::sqrt(0.5), -std::sqrt(0.5)); }},
      {"headings count clockwise",
       [](const Pose& p) {
         return Pose{p.translation_m, p.rotation.conjugate()};
       }},
  };
  return all;
}

std::optional<Pose> frame_between(const std::vector<Eigen::Vector3d>& from,
                                  const std::vector<Eigen::Vector3d>& to) {
  constexpr double kSpread_m2 = 0.01;
  if (from.empty() || from.size() != to.size()) return std::nullopt;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
  const auto n = static_cast<double>(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    a += from[i] / n;
    b += to[i] / n;
  }
  double along = 0.0, across = 0.0, spread_m2 = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d p = from[i] - a, q = to[i] - b;
    along += p.x() * q.x() + p.y() * q.y();
    across += p.x() * q.y() - p.y() * q.x();
    spread_m2 += p.head<2>().squaredNorm();
  }
  if (spread_m2 < kSpread_m2) return std::nullopt;
  Pose T = Pose::planar(0.0, 0.0, std::atan2(across, along));
  T.translation_m = b - T.rotation * a;
  return T;
}

}  // namespace octant::calib
