// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/change_search.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/changes/chi_square.h"
#include "models/simulator/random.h"

namespace octant {
namespace change_search_test {

constexpr double kWide = 1e3;  ///< prior of a change

/// Twelve positions with three coordinates and a number each, determined by random observations.
class Search : public ::testing::Test {
 protected:
  static constexpr int kOwners = 12, kSize = 4 * kOwners;
  Search() : random_(4711, 0), P_(Eigen::MatrixXd::Zero(kSize, kSize)), N_(P_) {
    for (std::size_t i = 0; i < kOwners; ++i) {
      const int first = 4 * static_cast<int>(i);
      hypotheses_.push_back(
          {ChangeKind::kBeaconMoved, i, {first, first + 1, first + 2}, {kWide, kWide, kWide}});
      hypotheses_.push_back({ChangeKind::kDelay, i, {first + 3}, {kWide}});
    }
    const Eigen::MatrixXd A = matrix(3 * kSize, kSize), K = matrix(kSize, kSize);
    N_ = A.transpose() * A;
    P_ = 0.01 * K * K.transpose() + 0.02 * Eigen::MatrixXd::Identity(kSize, kSize);
  }
  Eigen::MatrixXd matrix(int rows, int columns) {
    Eigen::MatrixXd M(rows, columns);
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) M(i, j) = random_.normal();
    return M;
  }
  Eigen::VectorXd noise(const Eigen::MatrixXd& C) {
    return Eigen::LLT<Eigen::MatrixXd>(C).matrixL() * matrix(kSize, 1);
  }
  /// Two estimates of a truth to which b was added between them, as an innovation.
  Innovation visit(const Eigen::VectorXd& b) {
    const Eigen::VectorXd difference = b + noise(P_) + noise(N_.inverse());
    return innovation_of_information(P_, N_, N_ * difference);
  }

  Random random_;
  Eigen::MatrixXd P_, N_;
  std::vector<ChangeHypothesis> hypotheses_;
};

TEST_F(Search, InformationAndDifferenceSayTheSame) {
  const Eigen::VectorXd d = matrix(kSize, 1);
  const Innovation by_information = innovation_of_information(P_, N_, N_ * d),
                   by_difference = innovation_of_difference(d, P_ + N_.inverse().eval());
  EXPECT_EQ(by_information.degrees_of_freedom, kSize);
  EXPECT_NEAR(by_information.y.squaredNorm(), by_difference.y.squaredNorm(),
              1e-7 * by_difference.y.squaredNorm());
  EXPECT_TRUE((by_information.B.transpose() * by_information.B)
                  .isApprox(by_difference.B.transpose() * by_difference.B, 1e-7));
  EXPECT_TRUE((by_information.B.transpose() * by_information.y)
                  .isApprox(by_difference.B.transpose() * by_difference.y, 1e-7));
}

TEST_F(Search, WhatIsNotSeenSaysNothing) {
  Eigen::MatrixXd N = N_;
  N.bottomRows(4).setZero();
  N.rightCols(4).setZero();
  Eigen::VectorXd d = Eigen::VectorXd::Zero(kSize);
  d.tail(4).setConstant(1e6);
  const Innovation innovation = innovation_of_information(P_, N, N * d);
  EXPECT_EQ(innovation.degrees_of_freedom, kSize - 4);
  EXPECT_TRUE(search_changes(innovation, hypotheses_).held().empty());
}

TEST_F(Search, FreeOfADirectionForgetsIt) {
  const Eigen::MatrixXd T = matrix(kSize, 2);
  Eigen::VectorXd d = matrix(kSize, 1);
  const Innovation a = free_of(innovation_of_information(P_, N_, N_ * d), T);
  d += T * Eigen::Vector2d(3.0, -5.0);
  const Innovation b = free_of(innovation_of_information(P_, N_, N_ * d), T);
  EXPECT_EQ(a.degrees_of_freedom, kSize - 2);
  EXPECT_NEAR(a.y.squaredNorm(), b.y.squaredNorm(), 1e-6 * a.y.squaredNorm());
}

/// In 400 visits without a change, the number of false alarms is at most the quantile of kFalseAlarm that is
/// exceeded once in a thousand.
TEST_F(Search, FalseAlarmsAreAsRareAsStated) {
  int alarms = 0;
  double chi2 = 0.0;
  for (int i = 0; i < 400; ++i) {
    const ChangeSearch search = search_changes(visit(Eigen::VectorXd::Zero(kSize)), hypotheses_);
    alarms += !search.held().empty();
    chi2 += search.chi2 / 400;
  }
  EXPECT_LE(alarms, 11);  // binomial, 400 times 0.01: more than 11 once in a thousand
  EXPECT_NEAR(chi2, kSize, 4 * std::sqrt(2.0 * kSize / 400));
}

TEST_F(Search, FindsThreeMovesAndADelayAndAccusesNobodyElse) {
  int right = 0, innocent = 0;
  double nees = 0.0;
  for (int i = 0; i < 50; ++i) {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(kSize);
    b.segment<3>(0) << 4, -3, 2;
    b.segment<3>(8) << 0, 6, -2;
    b.segment<3>(20) << -4, 1, 4;
    b[31] = 5;
    const ChangeSearch search = search_changes(visit(b), hypotheses_);
    const std::vector<std::size_t> wanted = {0, 4, 10, 15};
    const std::vector<std::size_t> held = search.held();
    right += std::includes(held.begin(), held.end(), wanted.begin(), wanted.end());
    innocent += static_cast<int>(held.size()) > 4;
    const TestedChange& first = search.tested[0];
    const Eigen::Vector3d off = first.estimate - b.head<3>();
    nees += off.dot(first.covariance.ldlt().solve(off)) / 50;
  }
  EXPECT_EQ(right, 50);
  EXPECT_LE(innocent, 4);                           // binomial, 50 times 0.01: more than 4 once in a thousand
  EXPECT_NEAR(nees, 3.0, 4 * std::sqrt(6.0 / 50));  // chi-square with three degrees of freedom
}

/// Information that is only rounding error moves no parameter by more than its prior, for any gradient.
TEST_F(Search, ChangesAreBoundedByTheirPriors) {
  const std::vector<ChangeHypothesis> hypotheses = {{ChangeKind::kDelay, 0, {0}, {kWide}},
                                                    {ChangeKind::kDelay, 1, {1}, {kWide}}};
  Innovation innovation{Eigen::Matrix2d::Identity(), Eigen::Vector2d(0.0, 30.0), 2};
  innovation.B(1, 1) = 1e-9;
  const ChangeSearch search = search_changes(innovation, hypotheses);
  EXPECT_TRUE(search.held().empty());
  EXPECT_LT(std::abs(search.tested[1].estimate[0]), kWide);
  EXPECT_NEAR(std::sqrt(search.tested[1].covariance(0, 0)), kWide, 1e-6 * kWide);
  EXPECT_EQ(search.tested[1].degrees_of_freedom, 0);
}

/// A change that was accepted first, for lack of a better one, is removed when others explain it.
TEST_F(Search, GivesUpWhatOthersExplain) {
  // A sum of two changes that a third hypothesis explains almost as well as both together.
  std::vector<ChangeHypothesis> hypotheses = {{ChangeKind::kDelay, 0, {0}, {kWide}},
                                              {ChangeKind::kDelay, 1, {1}, {kWide}},
                                              {ChangeKind::kDelay, 2, {2}, {kWide}}};
  Innovation innovation{Eigen::MatrixXd::Zero(3, 3), Eigen::Vector3d(10, 10, 8), 3};
  innovation.B << 1, 0, 1, 0, 1, 1, 0.8, 0, 0;
  EXPECT_EQ(search_changes(innovation, hypotheses).held(), (std::vector<std::size_t>{0, 1}));
}

}  // namespace change_search_test
}  // namespace octant
