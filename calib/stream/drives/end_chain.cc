// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drives/end_chain.h"

#include <Eigen/Cholesky>

namespace octant::calib {

void EndChain::append(const OpenChain& piece) {
  constexpr double kSpare = 1e-9;  // where nothing at all observes an end
  const Eigen::Index n = sum_.rows() - 1, N = block_;
  const auto border_of = [&](Eigen::Index first) {
    Border G(N, n + 1);
    G.leftCols(n) = piece.H.block(first, 0, N, n);
    G.col(n) = piece.gradient.segment(first, N);
    return G;
  };
  cost_ += piece.cost;
  sum_.topLeftCorner(n, n) += piece.H.topLeftCorner(n, n);
  sum_.row(n).head(n) += piece.gradient.head(n).transpose();
  const Eigen::Index right = n + (piece.has_left ? N : 0);
  NodeBlock D_right = NodeBlock::Zero(N, N);
  Border G_right;
  if (piece.has_right) {
    D_right = piece.H.block(right, right, N, N);
    G_right = border_of(right);
  }
  if (piece.has_left) {
    D_ += piece.H.block(n, n, N, N);
    G_ += border_of(n);
    Eigen::LLT<NodeBlock> llt(D_);
    if (llt.info() != Eigen::Success)
      llt.compute(D_ + kSpare * (1.0 + D_.diagonal().maxCoeff()) * NodeBlock::Identity(N, N));
    EliminatedEnd end;
    end.L = llt.matrixL();
    const auto L = end.L.triangularView<Eigen::Lower>();
    end.Y = L.solve(G_);
    end.W = NodeBlock::Zero(N, N);
    if (piece.has_right) {
      end.W = L.solve(NodeBlock(piece.H.block(n, right, N, N)));
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
  // The gain of the ends is in the diagonal element of the gradient: -y'y.
  system.cost += cost_ + 0.5 * sum_(n, n);
  system.H += Eigen::MatrixXd(sum_.topLeftCorner(n, n).selfadjointView<Eigen::Lower>());
  system.gradient += sum_.row(n).head(n).transpose();
}

std::vector<NodeVector> EndChain::steps(const Eigen::VectorXd& dx) const {
  std::vector<NodeVector> steps(ends_.size());
  NodeVector next = NodeVector::Zero(block_);
  for (std::size_t i = ends_.size(); i-- > 0;) {
    const EliminatedEnd& end = ends_[i];
    const NodeVector right = end.Y.leftCols(dx.size()) * dx + end.Y.col(dx.size()) + end.W * next;
    next = steps[i] = -end.L.triangularView<Eigen::Lower>().transpose().solve(right);
  }
  return steps;
}

}  // namespace octant::calib
