// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drives/end_chain.h"

#include <Eigen/Cholesky>

namespace octant::calib {

void EndChain::append(const OpenChain& piece) {
  constexpr double kSpare = 1e-9;  // where nothing at all observes an end
  const Eigen::Index n = sum_.rows() - 1;
  const auto border_of = [&](Eigen::Index first) {
    Border G(3, n + 1);
    G.leftCols(n) = piece.H.block(first, 0, 3, n);
    G.col(n) = piece.gradient.segment<3>(first);
    return G;
  };
  cost_ += piece.cost;
  sum_.topLeftCorner(n, n) += piece.H.topLeftCorner(n, n);
  sum_.row(n).head(n) += piece.gradient.head(n).transpose();
  const Eigen::Index right = n + (piece.has_left ? 3 : 0);
  Eigen::Matrix3d D_right = Eigen::Matrix3d::Zero();
  Border G_right;
  if (piece.has_right) {
    D_right = piece.H.block<3, 3>(right, right);
    G_right = border_of(right);
  }
  if (piece.has_left) {
    D_ += piece.H.block<3, 3>(n, n);
    G_ += border_of(n);
    Eigen::LLT<Eigen::Matrix3d> llt(D_);
    if (llt.info() != Eigen::Success)
      llt.compute(D_ + kSpare * (1.0 + D_.diagonal().maxCoeff()) * Eigen::Matrix3d::Identity());
    End end;
    end.L = llt.matrixL();
    const auto L = end.L.triangularView<Eigen::Lower>();
    end.Y = L.solve(G_);
    end.W.setZero();
    if (piece.has_right) {
      end.W = L.solve(Eigen::Matrix3d(piece.H.block<3, 3>(n, right)));
      D_right -= end.W.transpose() * end.W;
      G_right -= end.W.transpose() * end.Y;
    }
    sum_.triangularView<Eigen::Lower>() -= end.Y.transpose() * end.Y;
    ends_.push_back(std::move(end));
  }
  D_ = D_right;
  G_ = std::move(G_right);
}

void EndChain::add_to(ReducedSystem& system) const {
  const Eigen::Index n = sum_.rows() - 1;
  // What the ends gain stands where the gradient meets itself: -y'y.
  system.cost += cost_ + 0.5 * sum_(n, n);
  system.H += Eigen::MatrixXd(sum_.topLeftCorner(n, n).selfadjointView<Eigen::Lower>());
  system.gradient += sum_.row(n).head(n).transpose();
}

std::vector<Eigen::Vector3d> EndChain::steps(const Eigen::VectorXd& dx) const {
  std::vector<Eigen::Vector3d> steps(ends_.size());
  Eigen::Vector3d next = Eigen::Vector3d::Zero();
  for (std::size_t i = ends_.size(); i-- > 0;) {
    const End& end = ends_[i];
    const Eigen::Vector3d right = end.Y.leftCols(dx.size()) * dx + end.Y.col(dx.size()) + end.W * next;
    next = steps[i] = -end.L.triangularView<Eigen::Lower>().transpose().solve(right);
  }
  return steps;
}

}  // namespace octant::calib
