// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Both ways of a covariance, dense and sparse, against inverses and pseudo-inverses of textbooks.
#include "calib/adjust/covariance.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"

namespace octant::test {
namespace covariance_test {

using Sparse = Eigen::SparseMatrix<double>;

/// Information of places in the plane by ranges between neighbours on a ring: x, y of each.
struct RingNet {
  Eigen::MatrixXd N, datum;
  std::vector<Eigen::Vector2d> place;

  explicit RingNet(int points) {
    Random draws(7);
    const Eigen::Index n = 2 * points;
    N = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < points; ++i) {
      const double a = 2 * M_PI * i / points;
      place.emplace_back(8 * std::cos(a) + 0.3 * draws.normal(), 5 * std::sin(a) + 0.3 * draws.normal());
    }
    for (int i = 0; i < points; ++i)
      for (const int step : {1, 2, 5}) {
        const int j = (i + step) % points;
        const Eigen::Vector2d u =
            (place[static_cast<std::size_t>(i)] - place[static_cast<std::size_t>(j)]).normalized();
        Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
        row.segment<2>(2 * i) = u / 0.02;
        row.segment<2>(2 * j) = -u / 0.02;
        N += row * row.transpose();
      }
    Eigen::MatrixXd F(n, 3);  // two shifts, one turn
    for (int i = 0; i < points; ++i)
      F.middleRows<2>(2 * i) << 1, 0, -place[static_cast<std::size_t>(i)].y(), 0, 1,
          place[static_cast<std::size_t>(i)].x();
    datum = Eigen::HouseholderQR<Eigen::MatrixXd>(F).householderQ() * Eigen::MatrixXd::Identity(n, 3);
  }
  /// The smallest of all matrices C with N C N = N, by singular values (Moore and Penrose).
  [[nodiscard]] Eigen::MatrixXd pseudo_inverse() const {
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(N, Eigen::ComputeThinU | Eigen::ComputeThinV);
    Eigen::VectorXd inverse = svd.singularValues();
    for (double& s : inverse) s = s > 1e-9 * svd.singularValues()[0] ? 1 / s : 0.0;
    return svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose();
  }
  [[nodiscard]] Sparse sparse() const { return N.sparseView(); }
};

Eigen::MatrixXd none(const Eigen::MatrixXd& N) { return Eigen::MatrixXd(N.rows(), 0); }

/// Compares all results of a covariance with those of a matrix.
void expect_is(const calib::Covariance& C, const Eigen::MatrixXd& want, double tolerance) {
  ASSERT_EQ(C.size(), want.rows());
  const double most = tolerance * want.cwiseAbs().maxCoeff();
  EXPECT_TRUE(C.all_finite());
  for (Eigen::Index i = 0; i < want.rows(); ++i)
    for (Eigen::Index j = 0; j < want.cols(); ++j) EXPECT_NEAR(C(i, j), want(i, j), most) << i << ", " << j;
  const std::vector<int> some = {5, 0, 3};
  EXPECT_LT((C.block(some) - want(some, some)).cwiseAbs().maxCoeff(), most);
  EXPECT_LT((C.columns(some) - want(Eigen::all, some)).cwiseAbs().maxCoeff(), most);
  Eigen::VectorXd v(want.rows());
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = std::sin(1.0 + static_cast<double>(i));
  EXPECT_LT((C.times(v) - want * v).cwiseAbs().maxCoeff(), most * static_cast<double>(v.size()));
}

TEST(Covariance, IsTheInverseOfTheInformation) {
  RingNet net(12);
  net.N.diagonal().array() += 30.0;  // priors to 0.18 m
  const Eigen::MatrixXd want = net.N.fullPivLu().inverse();
  // Condition of some 1e3.
  expect_is(calib::Covariance(net.N, none(net.N)), want, 1e-11);
  expect_is(calib::Covariance(net.sparse(), none(net.N)), want, 1e-11);
}

TEST(Covariance, OfAFreeNetIsThePseudoInverse) {
  const RingNet net(12);
  const Eigen::MatrixXd want = net.pseudo_inverse();
  for (const bool sparse : {false, true}) {
    const calib::Covariance C =
        sparse ? calib::Covariance(net.sparse(), net.datum) : calib::Covariance(net.N, net.datum);
    SCOPED_TRACE(sparse ? "sparse" : "dense");
    expect_is(C, want, 1e-9);  // of directions of no variance the weight of the datum leaves a rounding
    for (Eigen::Index k = 0; k < 3; ++k)
      EXPECT_LT(C.times(net.datum.col(k)).norm(), 1e-12) << "the datum's own motions have no variance";
  }
}

TEST(Covariance, DoesNotDependOnTheScaleOfAParameter) {
  RingNet net(10);
  net.N.diagonal().array() += 30.0;
  const calib::Covariance plain(net.N, none(net.N));
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(20);
  unit[3] = 1e7;
  unit[8] = 1e-6;
  const calib::Covariance scaled(Eigen::MatrixXd(unit.asDiagonal() * net.N * unit.asDiagonal()), none(net.N));
  for (Eigen::Index i = 0; i < 20; ++i)
    for (Eigen::Index j = 0; j < 20; ++j)
      EXPECT_NEAR(scaled(i, j) * unit[i] * unit[j], plain(i, j),
                  1e-12 * std::sqrt(plain(i, i) * plain(j, j)));
}

TEST(Covariance, OfWhatNothingTellsIsHugeAndFinite) {
  for (const bool sparse : {false, true}) {
    SCOPED_TRACE(sparse ? "sparse" : "dense");
    RingNet net(10);
    net.N.diagonal().array() += 30.0;
    net.N.row(4).setZero();  // nobody sees parameter 4,
    net.N.col(4).setZero();
    net.N(4, 4) = -1e-13;  // but rounding
    const calib::Covariance C =
        sparse ? calib::Covariance(net.sparse(), none(net.N)) : calib::Covariance(net.N, none(net.N));
    EXPECT_TRUE(C.all_finite());
    EXPECT_GT(C(4, 4), 1e8);
    std::vector<int> others;
    for (int i = 0; i < 20; ++i)
      if (i != 4) others.push_back(i);
    const Eigen::MatrixXd want = net.N(others, others).fullPivLu().inverse();
    EXPECT_LT((C.block(others) - want).cwiseAbs().maxCoeff(), 1e-11 * want.cwiseAbs().maxCoeff());
  }
}

TEST(Covariance, OfADirectionThatNothingTellsIsHugeAlongItAlone) {
  for (const bool sparse : {false, true}) {
    SCOPED_TRACE(sparse ? "sparse" : "dense");
    const RingNet net(10);  // without a datum: the whole may shift and turn
    const calib::Covariance C =
        sparse ? calib::Covariance(net.sparse(), none(net.N)) : calib::Covariance(net.N, none(net.N));
    EXPECT_TRUE(C.all_finite());
    EXPECT_GT(C(0, 0), 1e3);
    // The distance of two neighbours is known as well as ever: its variance is the free net's.
    Eigen::VectorXd row = Eigen::VectorXd::Zero(20);
    const Eigen::Vector2d u = (net.place[0] - net.place[1]).normalized();
    row.head<2>() = u;
    row.segment<2>(2) = -u;
    const double want = row.dot(net.pseudo_inverse() * row);
    // The huge part is orthogonal to it, to a rounding.
    EXPECT_NEAR(row.dot(C.times(row)), want, 1e-3 * want);
  }
}

TEST(Covariance, OfNoNumberIsNotFinite) {
  RingNet net(10);
  net.N.diagonal().array() += 30.0;
  net.N(3, 4) = net.N(4, 3) = std::nan("");
  EXPECT_FALSE(calib::Covariance(net.sparse(), none(net.N)).all_finite());
}

TEST(Covariance, OfNothingIsEmpty) {
  EXPECT_EQ(calib::Covariance().size(), 0);
  EXPECT_EQ(calib::Covariance(Eigen::MatrixXd(0, 0), Eigen::MatrixXd(0, 0)).size(), 0);
  EXPECT_TRUE(calib::Covariance().all_finite());
}

TEST(Covariance, ShowsItsMatrixWhereThereIsOne) {
  RingNet net(8);
  net.N.diagonal().array() += 30.0;
  const calib::Covariance dense(net.N, none(net.N)), sparse(net.sparse(), none(net.N));
  ASSERT_NE(dense.matrix(), nullptr);
  EXPECT_EQ((*dense.matrix())(2, 3), dense(2, 3));
  EXPECT_EQ(sparse.matrix(), nullptr);
}

/// Weighted variances, largest first, as a full decomposition has them.
TEST(Covariance, LargestDirectionsAreTheEigenvectors) {
  RingNet net(40);
  net.N.diagonal().array() += 0.5;
  Eigen::VectorXd weights(80);
  for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = i % 2 == 0 ? 1.0 : 0.3;
  const Eigen::MatrixXd C = net.N.fullPivLu().inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(weights.asDiagonal() * C * weights.asDiagonal());
  for (const bool sparse : {false, true}) {
    SCOPED_TRACE(sparse ? "sparse" : "dense");
    const calib::Covariance of =
        sparse ? calib::Covariance(net.sparse(), none(net.N)) : calib::Covariance(net.N, none(net.N));
    const auto directions = of.largest(weights, 4, 0.0);
    ASSERT_EQ(directions.size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Index at = 79 - static_cast<Eigen::Index>(k);
      EXPECT_NEAR(directions[k].variance, eigen.eigenvalues()[at], 1e-9 * eigen.eigenvalues()[79]) << k;
      EXPECT_NEAR(directions[k].v.norm(), 1.0, 1e-12);
      // Lanczos ends at a residual of a millionth of the eigenvalue.
      const Eigen::VectorXd left = weights.cwiseProduct(C * weights.cwiseProduct(directions[k].v)) -
                                   directions[k].variance * directions[k].v;
      EXPECT_LT(left.norm(), 2e-6 * directions[k].variance) << k;
    }
    const double least = 0.5 * (eigen.eigenvalues()[78] + eigen.eigenvalues()[77]);
    EXPECT_EQ(of.largest(weights, 10, least).size(), 2U) << "none below the least";
    EXPECT_TRUE(of.largest(weights, 10, 2 * eigen.eigenvalues()[79]).empty());
    EXPECT_TRUE(of.largest(weights, 0, 0.0).empty());
  }
}

}  // namespace covariance_test
}  // namespace octant::test
