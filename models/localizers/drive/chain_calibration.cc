// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/chain_calibration.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace octant {
namespace {

/// The rows that depend on shared parameters, and on which.
struct CoupledRows {
  struct Row {
    std::size_t node = 0;  ///< of the segment
    bool has_next = false;
    NodeRow by_node, by_next;
    std::size_t first = 0, last = 0;  ///< of `terms`
    int pair = -1;
    double by_delay = 0.0;
  };
  struct Term {
    int column = 0;  ///< among those touched
    double derivative = 0.0;
  };
  std::vector<Row> rows;
  std::vector<Term> terms;
  std::vector<int> touched;  ///< columns of C
  std::vector<char> pairs;   ///< heard
};

CoupledRows coupled_rows(const Trajectory& t, const Segment& segment, const SharedState& state,
                         const CalibrationPart& calibration) {
  CoupledRows out;
  std::vector<int> place(static_cast<std::size_t>(calibration.covariance().cols()), -1);
  const std::size_t receivers = state.receiver_p_vehicle_m.size();
  out.pairs.assign(state.beacon_p_map_m.size() * receivers, 0);
  for_each_row(t, segment, state, [&](const ObservationRow& row) {
    if (!row.has_shared) return;
    CoupledRows::Row coupled{row.node - segment.first_node,
                             row.has_next,
                             row.by_node,
                             row.by_next,
                             out.terms.size(),
                             0,
                             -1,
                             row.by(kByDelay)};
    calibration.for_each_coupling(row, [&](int at, double derivative) {
      int& where = place[static_cast<std::size_t>(at)];
      if (where < 0) {
        where = static_cast<int>(out.touched.size());
        out.touched.push_back(at);
      }
      out.terms.push_back({where, derivative});
    });
    coupled.last = out.terms.size();
    if (row.kind == RowKind::kTof) {
      coupled.pair = static_cast<int>(row.beacon.index() * receivers + row.receiver.index());
      out.pairs[static_cast<std::size_t>(coupled.pair)] = 1;
    }
    out.rows.push_back(coupled);
  });
  return out;
}

/// R with R R' = C of the parameters touched, from the eigenvectors of C with a unit diagonal: a parameter
/// that is held has none.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& C, const std::vector<int>& touched) {
  const auto n = static_cast<Eigen::Index>(touched.size());
  if (n == 0) return {};
  Eigen::MatrixXd part(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      part(i, j) = C(touched[static_cast<std::size_t>(i)], touched[static_cast<std::size_t>(j)]);
  const Eigen::VectorXd sigma = part.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd scale = sigma.unaryExpr([](double s) { return s > 0 ? 1.0 / s : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * part * scale.asDiagonal());
  if (eigen.info() != Eigen::Success) return sigma.asDiagonal();
  const Eigen::MatrixXd root =
      sigma.asDiagonal() * eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  Eigen::Index zero = 0;  // ascending: the first have nothing to give
  while (zero < n && !(eigen.eigenvalues()[zero] > 1e-12)) ++zero;
  return root.rightCols(n - zero);
}

void add_states(const std::pmr::vector<NodeVector>& x, const Segment& segment,
                std::span<const DriveInstant> instants, std::vector<PoseCovariance>& covariances) {
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const NodeVector at = at_instant(x, segment, instants[i], static_cast<int>(covariances[i].rows()));
    covariances[i] += at * at.transpose();
  }
}

}  // namespace

NodeVector at_instant(std::span<const NodeVector> x, const Segment& segment, const DriveInstant& instant,
                      int dof) {
  const std::size_t k = instant.node - segment.first_node;
  const double alpha = k + 1 < x.size() ? instant.alpha : 0.0;
  NodeVector at = (1.0 - alpha) * x[k].head(dof);
  if (alpha > 0.0) at += alpha * x[k + 1].head(dof);
  return at;
}

void add_drive_calibration(const Trajectory& t, const Segment& segment, const SharedState& state,
                           const ChainFactor& chain, const CalibrationPart& calibration, double pair_sigma_s,
                           std::span<const DriveInstant> instants, std::vector<PoseCovariance>& covariances) {
  if (calibration.covariance().size() == 0 && !(pair_sigma_s > 0)) return;
  const CoupledRows coupled = coupled_rows(t, segment, state, calibration);
  const NodeVector zero = NodeVector::Zero(t.block_size());
  std::pmr::vector<NodeVector> x(chain.inverse.size(), zero, scratch());
  const auto solve_and_add = [&](auto&& error_of) {
    std::fill(x.begin(), x.end(), zero);
    for (const CoupledRows::Row& row : coupled.rows) {
      const double error = error_of(row);
      if (error == 0.0) continue;
      x[row.node] += error * row.by_node.transpose();
      if (row.has_next) x[row.node + 1] += error * row.by_next.transpose();
    }
    chain.solve(x);
    add_states(x, segment, instants, covariances);
  };
  const Eigen::MatrixXd root = root_of(calibration.covariance(), coupled.touched);
  for (Eigen::Index k = 0; k < root.cols(); ++k)
    solve_and_add([&](const CoupledRows::Row& row) {
      double sum = 0.0;
      for (std::size_t i = row.first; i < row.last; ++i)
        sum += coupled.terms[i].derivative * root(coupled.terms[i].column, k);
      return sum;
    });
  for (std::size_t pair = 0; pair_sigma_s > 0 && pair < coupled.pairs.size(); ++pair)
    if (coupled.pairs[pair])
      solve_and_add([&](const CoupledRows::Row& row) {
        return row.pair == static_cast<int>(pair) ? row.by_delay * pair_sigma_s : 0.0;
      });
}

void node_calibration(const Trajectory& t, const Segment& segment, const SharedState& state,
                      const ChainFactor& chain, const CalibrationPart& calibration, std::size_t node,
                      NodeCalibration& out) {
  // The rows of H^-1 that belong to the pose of the node, by its columns.
  const int n = t.block_size(), dof = pose_dof(t.motion);
  std::pmr::vector<NodeBlock> z(chain.inverse.size(), NodeBlock::Zero(n, dof), scratch());
  z[node - segment.first_node].topRows(dof).setIdentity();
  chain.solve(z);
  out.by_parameter.setZero();
  out.by_pair.setZero();
  const std::size_t receivers = state.receiver_p_vehicle_m.size();
  for_each_row(t, segment, state, [&](const ObservationRow& row) {
    const std::size_t k = row.node - segment.first_node;
    NodeVector gain = z[k].transpose() * row.by_node.transpose();
    if (row.has_next) gain += z[k + 1].transpose() * row.by_next.transpose();
    // The state gives way to an error of a parameter so that the residuals stay small: the opposite sign.
    calibration.for_each_coupling(
        row, [&](int at, double derivative) { out.by_parameter.col(at) -= derivative * gain; });
    if (row.kind == RowKind::kTof && out.by_pair.cols() > 0)
      out.by_pair.col(static_cast<Eigen::Index>(row.beacon.index() * receivers + row.receiver.index())) -=
          row.by(kByDelay) * gain;
  });
}

}  // namespace octant
