// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/calibration_part.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "models/support/observed.h"
#include "models/support/scratch.h"

namespace octant {
namespace {

/// Removes negative eigenvalues that rounding leaves. Parameters may be known far less well than the
/// combination that a fix depends on, and then nearly all of C cancels.
PoseCovariance positive(const PoseCovariance& part, const PoseCovariance& covariance) {
  if (Eigen::LLT<PoseCovariance>(covariance + part).info() == Eigen::Success) return part;
  const Eigen::SelfAdjointEigenSolver<PoseCovariance> eigen(part);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace

CalibrationPart::CalibrationPart(const Deployment& deployment) : covariance_(deployment.covariance.matrix) {
  const ParameterIndex at(deployment.covariance.parameters);
  for (std::size_t b = 0; b < deployment.beacons.size(); ++b) beacon_.push_back(at.beacon(b));
  for (std::size_t r = 0; r < deployment.receivers.size(); ++r) receiver_.push_back(at.receiver(r));
  site_delay_ = at[parameters::site_delay()];
  speed_ = at[parameters::speed()];
  for (std::size_t i = 0; i < attenuation_.size(); ++i) attenuation_[i] = at[parameters::attenuation(i)];
}

void CalibrationPart::add_to(PoseCovariance& covariance, const Trajectory& t, const Segment& segment,
                             const SharedState& state) const {
  const Eigen::MatrixXd& C = covariance_;
  if (C.rows() == 0) return;
  const int n = t.block_size(), dof = pose_dof(t.motion);
  NodeBlock D = NodeBlock::Zero(n, n);
  // Computes G by columns, only for the parameters that the segment depends on, because a fix uses a few of
  // many beacons.
  std::pmr::vector<NodeVector> G(scratch());
  std::pmr::vector<int> touched(scratch()), place(static_cast<std::size_t>(C.cols()), -1, scratch());
  for_each_row(t, segment, state, [&](const ObservationRow& row) {
    D.noalias() += row.by_node.transpose() * row.by_node;
    for_each_coupling(row, [&](int at, double derivative) {
      int& where = place[static_cast<std::size_t>(at)];
      if (where < 0) {
        where = static_cast<int>(touched.size());
        touched.push_back(at);
        G.push_back(NodeVector::Zero(n));
      }
      G[static_cast<std::size_t>(where)] += derivative * row.by_node.transpose();
    });
  });
  // Unobserved rotations get the variance of an unknown angle.
  add_vague_angles(t.motion, D);
  const ObservedState<NodeBlock> observed(D);
  if (!observed.all()) return;
  for (NodeVector& column : G) column = observed.solve(column);  // D^-1 G
  NodeBlock sum = NodeBlock::Zero(n, n);
  for (std::size_t j = 0; j < G.size(); ++j) {
    NodeVector weighed = NodeVector::Zero(n);
    for (std::size_t i = 0; i < G.size(); ++i) weighed += C(touched[i], touched[j]) * G[i];
    sum.noalias() += weighed * G[j].transpose();
  }
  const PoseCovariance part = 0.5 * (sum + sum.transpose()).topLeftCorner(dof, dof);
  covariance += positive(part, covariance);
}

}  // namespace octant
