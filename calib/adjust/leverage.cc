// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/leverage.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "models/support/decompositions.h"
#include "models/support/observed.h"
#include "models/support/unit_diagonal.h"

namespace octant::calib {
namespace {

constexpr std::size_t kNodesPerBlock = 256;
/// Pivots of the scaled covariance below this are rounding.
constexpr double kNoVariance = 1e-13;

/// L with C = L L' of the few parameters of a segment, one column for each direction that is not zero.
Eigen::MatrixXd pivoted_root_of(const Eigen::MatrixXd& C) {
  if (C.rows() == 0) return C;
  const UnitDiagonal<Eigen::MatrixXd> unit(C);
  const DenseLdlt ldlt(unit.scaled);
  const Eigen::VectorXd d = ldlt.vectorD();
  const Eigen::MatrixXd L = ldlt.matrixL();
  Eigen::MatrixXd root = ldlt.transpositionsP().transpose() * L;
  Eigen::Index rank = 0;
  for (Eigen::Index i = 0; i < d.size(); ++i)
    if (d[i] > kNoVariance)
      root.col(rank++) = (std::sqrt(d[i]) * unit.scale.cwiseProduct(root.col(i))).eval();
  return root.leftCols(rank);
}

/// L with C = L L' of all parameters, symmetric except for their units. Errors are drawn by its columns. The
/// order of pivots depends on rounding if variances are scaled alike, and the stated sigmas would depend on
/// it too.
Eigen::MatrixXd symmetric_root_of(const Eigen::MatrixXd& C) {
  if (C.rows() == 0) return C;
  const UnitDiagonal<Eigen::MatrixXd> unit(C);
  return unit.scale.asDiagonal() * symmetric_root(unit.scaled);
}

/// Inverse in the directions that are observed, zero in the others.
NodeBlock observed_inverse(const NodeBlock& D) {
  const UnitDiagonal<NodeBlock> unit(D);
  const SymmetricEigen<NodeBlock> eigen(unit.scaled);
  NodeVector inverse_values = NodeVector::Zero(D.rows());
  for (Eigen::Index i = 0; i < D.rows(); ++i)
    if (eigen.eigenvalues()[i] > kUnobserved) inverse_values[i] = 1.0 / eigen.eigenvalues()[i];
  const NodeBlock V = unit.inverse_scale.asDiagonal() * eigen.eigenvectors();
  return V * inverse_values.asDiagonal() * V.transpose();
}

}  // namespace

LeverageSweep::LeverageSweep(const ParameterLayout& layout, const Covariance& C)
    : layout_(layout), C_(&C), place_(static_cast<std::size_t>(layout.size()), -1) {
  if (C.matrix() == nullptr) return;
  std::iota(place_.begin(), place_.end(), 0);
  set_root(symmetric_root_of(*C.matrix()), layout.beacon_columns());
  lateness_total_.assign(layout.beacon.size(), 0.0);
  lateness_remaining_.assign(layout.beacon.size(), 0.0);
  lateness_shared_.setZero(static_cast<Eigen::Index>(layout.beacon.size()), root_.cols());
}

/// @param coordinates  rows of L that are coordinates of beacons
void LeverageSweep::set_root(const Eigen::MatrixXd& L, const std::vector<int>& coordinates) {
  root_ = L;
  beacon_root_.resize(static_cast<Eigen::Index>(coordinates.size()), root_.cols());
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    beacon_root_.row(static_cast<Eigen::Index>(i)) = root_.row(coordinates[i]);
  beacon_C_ = beacon_root_ * root_.transpose();
}

/// L for the parameters of a segment.
void LeverageSweep::focus(const Trajectory& t, const Segment& segment, const SharedState& state) {
  for (const int column : touched_) place_[static_cast<std::size_t>(column)] = -1;
  touched_.clear();
  std::vector<int> coordinates;
  const auto add_column = [&](int column) {
    if (column < 0 || place_[static_cast<std::size_t>(column)] >= 0) return false;
    place_[static_cast<std::size_t>(column)] = static_cast<int>(touched_.size());
    touched_.push_back(column);
    return true;
  };
  for_each_row(t, segment, state, [&](const ObservationRow& row) {
    if (!row.has_shared) return;
    for (const int column : layout_.beacon[row.beacon.index()])
      if (add_column(column)) coordinates.push_back(place_[static_cast<std::size_t>(column)]);
    const RowEntries entries = row_entries(row, t.run, layout_, state);
    for (std::size_t i = 0; i < static_cast<std::size_t>(entries.count); ++i)
      static_cast<void>(add_column(entries.column[i]));
  });
  set_root(pivoted_root_of(C_->block(touched_)), coordinates);
}

double LeverageSweep::leverage_of(const std::vector<std::pair<int, double>>& entries) const {
  if (C_->matrix() == nullptr) {
    double h = 0.0;
    for (const auto& [i, a] : entries)
      for (const auto& [j, b] : entries) h += a * b * (*C_)(i, j);
    return h;
  }
  Eigen::RowVectorXd f = Eigen::RowVectorXd::Zero(root_.cols());
  for (const auto& [column, value] : entries) f += value * root_.row(column);
  return f.squaredNorm();
}

std::vector<LatenessInformation> LeverageSweep::lateness() const {
  std::vector<LatenessInformation> out(lateness_total_.size());
  for (std::size_t b = 0; b < out.size(); ++b) {
    const Eigen::VectorXd q = lateness_shared_.row(static_cast<Eigen::Index>(b)).transpose();
    out[b].total = lateness_total_[b];
    out[b].remaining = std::max(0.0, lateness_remaining_[b] - q.squaredNorm());
    if (beacon_root_.rows() > 0) out[b].shift_m_per_s = (beacon_root_ * q).lpNorm<Eigen::Infinity>();
  }
  return out;
}

Segment LeverageSweep::part(const Trajectory& t, const Segment& segment, std::size_t block) const {
  if (block_count() == 1) return segment;
  Segment s = segment;
  s.first_node = segment.first_node + block * kNodesPerBlock;
  s.last_node = std::min(segment.last_node, s.first_node + kNodesPerBlock);
  for_each_list([&](auto list, auto first, auto last) {
    s.*first = first_of_node(t.*list, s.first_node, s.*first, s.*last);
    s.*last = first_of_node(t.*list, s.last_node, s.*first, s.*last);
  });
  return s;
}

/// f_ = Js L of a row.
void LeverageSweep::project(const ObservationRow& row, std::size_t run) {
  entries_ = row_entries(row, run, layout_, *state_);
  f_.setZero(root_.cols());
  for (std::size_t i = 0; i < static_cast<std::size_t>(entries_.count); ++i)
    f_.noalias() += entries_.value[i] * root_.row(place_[static_cast<std::size_t>(entries_.column[i])]);
}

void LeverageSweep::forward(const Trajectory& t, const Segment& segment, const SharedState& state) {
  state_ = &state;
  count_ = segment.last_node - segment.first_node;
  n_ = t.block_size();
  D_.assign(count_, NodeBlock::Zero(n_, n_));
  U_.assign(count_, NodeBlock::Zero(n_, n_));
  inverse_.resize(count_);
  shifts_[0].known = shifts_[1].known = false;
  carry_.assign((count_ + kNodesPerBlock - 1) / kNodesPerBlock, RowMatrix());
  carry_[0].setZero(n_, root_.cols());
  lateness_G_.setZero(n_, static_cast<Eigen::Index>(lateness_total_.size()));
  for (std::size_t block = 0; block < block_count(); ++block) {
    assemble(t, segment, state, block, true);
    eliminate(true);
    if (block + 1 < block_count()) carry_[block + 1] = G_.bottomRows(n_);
  }
}

void LeverageSweep::assemble(const Trajectory& t, const Segment& segment, const SharedState& state,
                             std::size_t block, bool first_pass) {
  first_ = block * kNodesPerBlock;
  last_ = std::min(count_, first_ + kNodesPerBlock);
  const auto rows = static_cast<Eigen::Index>(last_ - first_ + 1) * n_;
  G_.setZero(rows, root_.cols());
  G_.topRows(n_) = carry_[block];
  if (first_pass) {
    const RowMatrix passed_on = lateness_G_.bottomRows(n_);
    lateness_G_.setZero(rows, static_cast<Eigen::Index>(lateness_total_.size()));
    lateness_G_.topRows(n_) = passed_on;
  }
  for_each_row(t, part(t, segment, block), state, [&](const ObservationRow& row) {
    const std::size_t k = row.node - segment.first_node;
    const auto at = static_cast<Eigen::Index>(k - first_) * n_;
    if (row.has_shared) {
      project(row, t.run);
      G_.middleRows(at, n_).noalias() += row.by_node.transpose() * f_;
      if (row.has_next) G_.middleRows(at + n_, n_).noalias() += row.by_next.transpose() * f_;
    }
    if (!first_pass) return;
    D_[k].noalias() += row.by_node.transpose() * row.by_node;
    if (row.has_next) {
      D_[k + 1].noalias() += row.by_next.transpose() * row.by_next;
      U_[k].noalias() += row.by_node.transpose() * row.by_next;
    }
    if (row.kind != RowKind::kTof || lateness_total_.empty()) return;
    const auto b = static_cast<Eigen::Index>(row.beacon.index());
    const double c = row.by(kByDelay);  // a lateness acts as a delay does
    lateness_total_[row.beacon.index()] += c * c;
    lateness_remaining_[row.beacon.index()] += c * c;
    lateness_shared_.row(b) += c * f_;
    lateness_G_.col(b).segment(at, n_) += c * row.by_node.transpose();
    if (row.has_next) lateness_G_.col(b).segment(at + n_, n_) += c * row.by_next.transpose();
  });
}

/// Front to back; the node beyond the block's end receives the elimination of the previous ones.
void LeverageSweep::eliminate(bool first_pass) {
  for (std::size_t k = first_; k < last_; ++k) {
    const auto at = static_cast<Eigen::Index>(k - first_) * n_;
    if (first_pass) {
      inverse_[k] = observed_inverse(D_[k]);
      for (Eigen::Index b = 0; b < lateness_G_.cols(); ++b) {
        const NodeVector g = lateness_G_.col(b).segment(at, n_);
        if (g.isZero(0.0)) continue;
        const NodeVector solved = inverse_[k] * g;
        lateness_remaining_[static_cast<std::size_t>(b)] -= g.dot(solved);
        lateness_shared_.row(b).noalias() -= solved.transpose() * G_.middleRows(at, n_);
        if (k + 1 < count_) lateness_G_.col(b).segment(at + n_, n_) -= U_[k].transpose() * solved;
      }
    }
    if (k + 1 == count_) break;
    const NodeBlock W = U_[k].transpose() * inverse_[k];
    if (first_pass) D_[k + 1].noalias() -= W * U_[k];
    G_.middleRows(at + n_, n_).noalias() -= W * G_.middleRows(at, n_);
  }
}

/// States' answers X and covariances P of the block's nodes; what follows the block is known from the block
/// behind it.
void LeverageSweep::backward(const Trajectory& t, const Segment& segment, const SharedState& state,
                             std::size_t block) {
  const bool at_end = block + 1 == block_count();
  RowMatrix X_beyond = at_end ? RowMatrix() : RowMatrix(X_.topRows(n_));
  const NodeBlock P_beyond = at_end ? NodeBlock() : P_[0];
  if (!at_end) {
    assemble(t, segment, state, block, false);
    eliminate(false);
  }
  const std::size_t size = last_ - first_;
  X_.resize(static_cast<Eigen::Index>(size + 1) * n_, root_.cols());
  P_.resize(size + 1);
  cross_.resize(size);
  if (!at_end) {
    X_.bottomRows(n_) = X_beyond;
    P_[size] = P_beyond;
  }
  for (std::size_t i = size; i-- > 0;) {
    const auto at = static_cast<Eigen::Index>(i) * n_;
    const NodeBlock& inverse = inverse_[first_ + i];
    X_.middleRows(at, n_).noalias() = -inverse * G_.middleRows(at, n_);
    P_[i] = inverse;
    if (first_ + i + 1 == count_) continue;
    const NodeBlock gain = inverse * U_[first_ + i];
    X_.middleRows(at, n_).noalias() -= gain * X_.middleRows(at + n_, n_);
    cross_[i] = -gain * P_[i + 1];
    P_[i].noalias() -= cross_[i] * gain.transpose();
  }
}

/// Shift of the beacon coordinates by a push on the state of a node, beacon_root X_k'.
const Eigen::MatrixXd& LeverageSweep::beacon_shift(std::size_t node) {
  StateShift& shift = shifts_[node % 2];
  if (!shift.known || shift.node != node) {
    shift.by_state.noalias() =
        beacon_root_ * X_.middleRows(static_cast<Eigen::Index>(node - first_) * n_, n_).transpose();
    shift.node = node;
    shift.known = true;
  }
  return shift.by_state;
}

RowLeverage LeverageSweep::leverage_of(const Trajectory& t, const Segment& segment,
                                       const ObservationRow& row) {
  const std::size_t k = row.node - segment.first_node;
  const auto at = static_cast<Eigen::Index>(k - first_) * n_;
  project(row, t.run);
  f_.noalias() += row.by_node * X_.middleRows(at, n_);
  double h = (row.by_node * P_[k - first_]).dot(row.by_node);
  if (row.has_next) {
    f_.noalias() += row.by_next * X_.middleRows(at + n_, n_);
    h += (row.by_next * P_[k - first_ + 1]).dot(row.by_next) +
         2.0 * (row.by_node * cross_[k - first_]).dot(row.by_next);
  }
  RowLeverage out{t, row, std::clamp(h + f_.squaredNorm(), 0.0, 1.0), 0.0, f_};
  if (row.kind != RowKind::kTof || beacon_root_.rows() == 0) return out;
  Eigen::VectorXd shift = beacon_shift(k) * row.by_node.transpose();
  if (row.has_next) shift.noalias() += beacon_shift(k + 1) * row.by_next.transpose();
  for (std::size_t i = 0; i < static_cast<std::size_t>(entries_.count); ++i)
    shift += entries_.value[i] * beacon_C_.col(place_[static_cast<std::size_t>(entries_.column[i])]);
  out.shift_m = shift.lpNorm<Eigen::Infinity>();
  return out;
}

}  // namespace octant::calib
