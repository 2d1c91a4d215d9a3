// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/mirror.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>

#include "models/support/decompositions.h"

namespace octant::survey {
namespace {

constexpr double kToldApart = 45.8;
constexpr double kHopeless =
    1e5;  ///< chi-square of a path before adjustment: off by hundreds of sigmas, which no adjustment corrects
constexpr int kSteps = 12;

struct Line {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero(), along = Eigen::Vector2d::UnitX();
};

Line line_through(const SurveyModel& model, const std::vector<std::size_t>& beacons) {
  Line line;
  for (const std::size_t b : beacons)
    line.middle += model.beacons[b].p_map_m.head<2>() / static_cast<double>(beacons.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const std::size_t b : beacons) {
    const Eigen::Vector2d arm = model.beacons[b].p_map_m.head<2>() - line.middle;
    spread += arm * arm.transpose();
  }
  const SymmetricEigen<Eigen::Matrix2d> eigen(spread);
  line.along = eigen.eigenvectors().col(1);
  return line;
}

/// Gauss-Newton from a pose on the other side; chi-square of the ranges at its end.
double adjust(const SurveyModel& model, const std::vector<HeardPath>& paths, PoseAt& pose) {
  const int n = model.unknowns.count();
  double offset_m = 0.0, chi2 = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kSteps; ++step) {
    UnknownsMatrix A = 1e-9 * UnknownsMatrix::Identity(n, n);
    UnknownsVector g = UnknownsVector::Zero(n);
    chi2 = 0.0;
    for (const HeardPath& true_path : paths) {
      const HeardPath p = path_between(model, true_path.beacon, true_path.receiver, pose);
      const double residual = true_path.distance_m - p.distance_m - offset_m;
      chi2 += true_path.weight * residual * residual;
      A.noalias() += true_path.weight * p.row * p.row.transpose();
      g.noalias() += true_path.weight * residual * p.row;
    }
    if (step == 0 && chi2 > 4 * kHopeless * static_cast<double>(paths.size())) return chi2;
    const UnknownsVector delta = A.ldlt().solve(g);
    if (!delta.allFinite() || delta.head<2>().norm() < 1e-9) break;
    pose.x_m += delta[0], pose.y_m += delta[1];
    if (model.unknowns.rotation == 1) pose.heading_rad += delta[2];
    if (model.unknowns.clock) offset_m += delta[n - 1];
  }
  return chi2;
}

}  // namespace

bool MirrorFilter::may_have_image(const SurveyModel& model, const PoseAt& pose,
                                  const std::vector<std::size_t>& heard) {
  if (heard != last_) {
    const Line line = line_through(model, heard);
    last_ = heard, middle_ = line.middle, along_ = line.along;
  }
  const Eigen::Vector2d at(pose.x_m, pose.y_m), normal(-along_.y(), along_.x());
  const Eigen::Vector2d image = at - 2 * normal.dot(at - middle_) * normal;
  double chi2 = 0.0;
  for (const std::size_t b : heard) {
    const Eigen::Vector3d& p = model.beacons[b].p_map_m;
    const double here = std::hypot(p.x() - at.x(), p.y() - at.y(), p.z() - pose.z_m),
                 there = std::hypot(p.x() - image.x(), p.y() - image.y(), p.z() - pose.z_m);
    chi2 += (there - here) * (there - here) / model.noise.variance_m2(here);
  }
  // The receivers' own places against the vehicle's matter little here: the limit is far beyond.
  return chi2 <= kHopeless * static_cast<double>(heard.size());
}

MirrorImage mirror_image(const SurveyModel& model, const PoseAt& pose, const std::vector<HeardPath>& paths) {
  MirrorImage none;
  if (model.motion != Motion::kPlanar || paths.empty()) return none;
  std::vector<std::size_t> beacons;
  for (const HeardPath& p : paths)
    if (beacons.empty() || beacons.back() != p.beacon) beacons.push_back(p.beacon);
  const Line line = line_through(model, beacons);
  const Eigen::Vector2d at(pose.x_m, pose.y_m), normal(-line.along.y(), line.along.x());
  const double side_m = normal.dot(at - line.middle);
  const Eigen::Vector2d image = at - 2 * side_m * normal;
  const double heading = 2 * std::atan2(line.along.y(), line.along.x()) - pose.heading_rad;
  for (int quarter = 0; quarter < (model.unknowns.rotation == 1 ? 4 : 1); ++quarter) {
    PoseAt there{image.x(), image.y(), pose.z_m, heading + quarter * std::numbers::pi / 2};
    const double chi2 = adjust(model, paths, there);
    const Eigen::Vector2d found(there.x_m, there.y_m);
    // If the adjustment returns to the true position, or to a point on the line, there is no second answer.
    if (chi2 < kToldApart && normal.dot(found - line.middle) * side_m < 0 && (found - at).norm() > 1e-3)
      return {true, found};
  }
  return none;
}

}  // namespace octant::survey
