// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/changes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace octant::survey {
namespace {

/// Shift weighted by its covariance, in the directions that have one.
std::optional<double> chance_of(const Eigen::Vector3d& shift_m, const Eigen::Matrix3d& C) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(C);
  double sum = 0.0;
  int dof = 0;
  for (int i = 0; i < 3; ++i) {
    const double variance = eigen.eigenvalues()[i];
    if (!(variance > 1e-6 * eigen.eigenvalues()[2]) || !(variance > 0.0)) continue;  // held fixed, or rounding of that
    sum += std::pow(eigen.eigenvectors().col(i).dot(shift_m), 2) / variance;
    ++dof;
  }
  if (dof == 0) return {};
  return chi_square_tail(sum, dof);
}

const DeploymentBeacon* find(const Deployment& d, const std::string& name) {
  const auto at = std::find_if(d.beacons.begin(), d.beacons.end(), [&](const auto& b) { return b.name == name; });
  return at == d.beacons.end() ? nullptr : &*at;
}

}  // namespace

double chi_square_tail(double value, int degrees_of_freedom) {
  const double x = std::max(0.0, value), root = std::sqrt(x / 2);
  if (degrees_of_freedom == 1) return std::erfc(root);
  if (degrees_of_freedom == 2) return std::exp(-x / 2);
  return std::erfc(root) + 2 / std::sqrt(M_PI) * root * std::exp(-x / 2);  // DLMF 8.4.15 with a = 3/2
}

Changes changes_between(const Deployment& before, const Deployment& now) {
  Changes changes;
  changes.since = before.created;
  changes.same_datum = before.datum.position == now.datum.position && before.datum.orientation == now.datum.orientation &&
                       before.datum.scale == now.datum.scale && before.datum.control_points == now.datum.control_points;
  for (const auto& b : now.beacons) {
    const DeploymentBeacon* old = find(before, b.name);
    if (old == nullptr) {
      changes.added.push_back(b.name);
      continue;
    }
    if (b.status == BeaconStatus::kUndetermined || old->status == BeaconStatus::kUndetermined) continue;
    BeaconChange c;
    c.name = b.name;
    c.shift_m = b.position_m - old->position_m;
    const Eigen::Matrix3d C = b.covariance_m2 + old->covariance_m2;
    c.sigma_m = C.diagonal().cwiseMax(0.0).cwiseSqrt();
    c.p = chance_of(c.shift_m, C);
    // Two control points that disagree are not a matter of chance.
    c.significant = c.p ? *c.p < kSignificance : c.shift_m.norm() > 0.0;
    c.delay_change_s = b.delay_s - old->delay_s;
    c.delay_sigma_s = std::hypot(b.delay_sigma_s, old->delay_sigma_s);
    changes.beacons.push_back(std::move(c));
  }
  for (const auto& b : before.beacons)
    if (find(now, b.name) == nullptr) changes.gone.push_back(b.name);
  if (!now.beacons.empty()) {
    const double at_degC = now.medium.temperature_degC;
    changes.speed_change_mps = now.speed_mps(at_degC) - before.speed_mps(at_degC);
    changes.speed_sigma_mps = std::hypot(now.speed_sigma_mps, before.speed_sigma_mps);
  }
  return changes;
}

}  // namespace octant::survey
