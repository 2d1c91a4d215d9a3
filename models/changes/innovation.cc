// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/innovation.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "models/support/decompositions.h"
#include "models/support/unit_diagonal.h"

namespace octant {
namespace {

/// Smallest share of the total that a direction must determine.
constexpr double kUnobservableShare = 1e-9;

/// L of C = L L', by a Cholesky decomposition of the correlations.
class Root {
 public:
  explicit Root(const Eigen::MatrixXd& covariance) : unit_(covariance), llt_(unit_.scaled) {}
  [[nodiscard]] Eigen::MatrixXd inverse() const {
    Eigen::MatrixXd X = unit_.inverse_scale.asDiagonal();
    llt_.matrixL().solveInPlace(X);
    return X;
  }
  [[nodiscard]] Eigen::MatrixXd lower() const {
    return unit_.scale.asDiagonal() * Eigen::MatrixXd(llt_.matrixL());
  }

 private:
  UnitDiagonal<Eigen::MatrixXd> unit_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

}  // namespace

Innovation innovation_of_difference(const Eigen::VectorXd& difference, const Eigen::MatrixXd& covariance) {
  Innovation out;
  out.B = Root(covariance).inverse();
  out.y = out.B * difference;
  out.degrees_of_freedom = static_cast<int>(out.y.size());
  return out;
}

Innovation innovation_of_information(const Eigen::MatrixXd& P, const Eigen::MatrixXd& N,
                                     const Eigen::VectorXd& gradient) {
  if (P.rows() == 0) return {};  // all parameters are fixed, so there are no changes
  const Root root(P);
  const Eigen::MatrixXd L = root.lower();
  const SymmetricEigen<Eigen::MatrixXd> eigen(L.transpose() * N * L);
  const Eigen::VectorXd& l = eigen.eigenvalues();
  const double least = kUnobservableShare * std::max(l.maxCoeff(), 1.0);
  const Eigen::Index observable = (l.array() > least).count();
  const Eigen::MatrixXd V = eigen.eigenvectors().rightCols(observable);
  const Eigen::ArrayXd information = l.tail(observable).array();
  Innovation out;
  out.B = (information / (1.0 + information)).sqrt().matrix().asDiagonal() * (V.transpose() * root.inverse());
  out.y = (V.transpose() * (L.transpose() * gradient)).array() / (information * (1.0 + information)).sqrt();
  out.degrees_of_freedom = static_cast<int>(observable);
  return out;
}

Innovation free_of(const Innovation& innovation, const Eigen::MatrixXd& T) {
  constexpr double kUnnoticed = 1e-3;
  const Eigen::MatrixXd BT = innovation.B * T;
  if (BT.size() == 0 || BT.norm() < kUnnoticed) return innovation;
  const Eigen::MatrixXd Q = PivotedQr(BT).basis();
  return {innovation.B - Q * (Q.transpose() * innovation.B),
          innovation.y - Q * (Q.transpose() * innovation.y),
          innovation.degrees_of_freedom - static_cast<int>(Q.cols())};
}

}  // namespace octant
