// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/rigid_piece.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "models/physics/plane.h"

namespace octant {

RigidPiece::RigidPiece(const SearchProblem& problem, double uncertainty_m)
    : problem_(problem), prior_(uncertainty_m > 0 ? 1.0 / square(uncertainty_m) : 0.0) {
  for (const SearchRange& r : problem.ranges) weight_.push_back(1.0 / r.sigma_m);
  begin();
}

void RigidPiece::expect(const Pose& T, const Vector6& sigma) {
  T_expected_ = T;
  expected_ = sigma.cwiseAbs2().cwiseInverse();
}

void RigidPiece::begin() { at_.off_m.assign(problem_.groups(), Eigen::Vector3d::Zero()); }

template <class Visit>
void RigidPiece::for_each_range(Visit&& visit) const {
  for (std::size_t group = 0; group < problem_.groups(); ++group)
    for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i)
      visit(i, group);
}

void RigidPiece::solve_pose(Pose& T, const RobustLoss& loss, int iterations, double tolerance) {
  at_.T = T;
  PieceNormal now = build(at_, loss);
  double lambda = 1e-6;
  for (int i = 0; i < iterations; ++i) {
    Matrix6 A = now.H;
    A.diagonal() += lambda * now.H.diagonal() + Vector6::Constant(1e-9);
    const State tried = moved(-A.ldlt().solve(now.g), now);
    PieceNormal next = build(tried, loss);
    if (!(next.cost < now.cost)) {
      lambda *= 10;
      if (lambda > 1e4) break;
      continue;
    }
    const bool at_rest = now.cost - next.cost < tolerance * (1.0 + now.cost);
    at_ = tried;
    now = std::move(next);
    lambda = std::max(0.1 * lambda, 1e-9);
    if (at_rest) break;
  }
  T = at_.T;
  H_ = now.H;
}

double RigidPiece::score() const {
  double sum = 0.0;
  for (const Eigen::Vector3d& off_m : at_.off_m) sum += 0.5 * prior_ * off_m.squaredNorm();
  for_each_range([&](std::size_t i, std::size_t group) {
    const SearchRange& r = problem_.ranges[i];
    const double residual =
        weight_[i] * (r.range_m - (at_.T * r.p_lever_m - r.p_beacon_map_m - at_.off_m[group]).norm());
    const double ratio = problem_.span_m * weight_[i];
    const double cap =
        residual > 0 ? std::max(2.0, std::log(1.4 * ratio)) : std::max(4.0, std::log(28.0 * ratio));
    sum += std::min(0.5 * residual * residual, cap);
  });
  return sum;
}

Eigen::Vector3d RigidPiece::middle_m() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const SearchRange& r : problem_.ranges) sum += r.p_lever_m;
  return sum / static_cast<double>(problem_.ranges.size());
}

RigidPiece::PieceNormal RigidPiece::build(const State& at, const RobustLoss& loss) const {
  PieceNormal out;
  const std::size_t groups = problem_.groups();
  const Vector6 off = tangent_between(T_expected_, at.T, Motion::kSpatial);
  out.H = expected_.asDiagonal();
  out.g = expected_.cwiseProduct(off);
  out.cost = 0.5 * off.dot(out.g);
  out.A_inverse.assign(groups, prior_ * Eigen::Matrix3d::Identity());
  out.B.assign(groups, Eigen::Matrix<double, 6, 3>::Zero());
  out.b.resize(groups);
  for (std::size_t group = 0; group < groups; ++group) {
    out.b[group] = prior_ * at.off_m[group];
    out.cost += 0.5 * prior_ * at.off_m[group].squaredNorm();
  }
  for_each_range([&](std::size_t i, std::size_t group) {
    const SearchRange& r = problem_.ranges[i];
    const Eigen::Vector3d v = at.T * r.p_lever_m - r.p_beacon_map_m - at.off_m[group];
    const double d = std::max(v.norm(), 1e-6), residual = weight_[i] * (r.range_m - d);
    const Eigen::Vector3d u =
        weight_[i] / d * v;  // derivative by the beacon; that by the position is the opposite
    Vector6 J;
    J << -u, -r.p_lever_m.cross(at.T.rotation.conjugate() * u);
    double rho = 0.0, w = 1.0;
    loss.evaluate(residual, rho, w);
    out.cost += 0.5 * rho;
    out.H += w * J * J.transpose();
    out.g += w * residual * J;
    if (prior_ == 0.0) return;
    out.A_inverse[group] += w * u * u.transpose();
    out.B[group] += w * J * u.transpose();
    out.b[group] += w * residual * u;
  });
  for (std::size_t group = 0; group < groups && prior_ > 0; ++group) {
    out.A_inverse[group] = out.A_inverse[group].inverse().eval();
    const Eigen::Matrix<double, 6, 3> taken = out.B[group] * out.A_inverse[group];
    out.H -= taken * out.B[group].transpose();
    out.g -= taken * out.b[group];
  }
  return out;
}

RigidPiece::State RigidPiece::moved(const Vector6& step, const PieceNormal& by) const {
  State out = at_;
  out.T = retract(at_.T, step, Motion::kSpatial);
  for (std::size_t group = 0; group < out.off_m.size() && prior_ > 0; ++group)
    out.off_m[group] -= by.A_inverse[group] * (by.b[group] + by.B[group].transpose() * step);
  return out;
}

}  // namespace octant
