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

}  // namespace octant::calib
