// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The sparse factor and its inverse against dense ones.
#include "calib/adjust/sparse_factor.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"

namespace octant::test {
namespace sparse_factor_test {

using Sparse = Eigen::SparseMatrix<double>;

/// Positive definite: stations that observe a few of n parameters each, and a little of every one.
Sparse network(Eigen::Index n, int stations, Random& draws) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (Eigen::Index i = 0; i < n; ++i) triplets.emplace_back(i, i, 0.1 + draws.uniform(0, 1));
  for (int s = 0; s < stations; ++s) {
    const auto first = static_cast<Eigen::Index>(draws.uniform(0, static_cast<double>(n)));
    std::vector<std::pair<Eigen::Index, double>> row;
    for (Eigen::Index k = 0; k < 4; ++k) row.emplace_back((first + k * k) % n, draws.normal());
    for (const auto& [i, a] : row)
      for (const auto& [j, b] : row) triplets.emplace_back(i, j, a * b);
  }
  Sparse N(n, n);
  N.setFromTriplets(triplets.begin(), triplets.end());
  return N;
}

RC_GTEST_PROP(SparseFactor, SolvesAndInvertsAsADenseMatrixDoes, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const int n = *rc::gen::inRange(5, 40);
  const Sparse N = network(n, 2 * n, draws);
  const auto factor = calib::SparseFactor::of(N);
  RC_ASSERT(factor != nullptr);
  const Eigen::MatrixXd dense = N, C = dense.fullPivLu().inverse();
  Eigen::MatrixXd rhs(n, 3);
  for (Eigen::Index i = 0; i < rhs.size(); ++i) rhs(i) = draws.normal();
  // The condition is below some 1e4 / 0.1.
  RC_ASSERT((factor->solve(rhs) - C * rhs).cwiseAbs().maxCoeff() < 1e-10 * C.cwiseAbs().maxCoeff());
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto element = factor->inverse(i, j);
      RC_ASSERT(element == factor->inverse(j, i));
      if (element) RC_ASSERT(std::abs(*element - C(i, j)) < 1e-10 * C.cwiseAbs().maxCoeff());
    }
  for (Eigen::Index j = 0; j < n; ++j)  // what an observation connects is told
    for (Sparse::InnerIterator it(N, j); it; ++it) RC_ASSERT(factor->inverse(it.row(), j).has_value());
}

TEST(SparseFactor, OfSeparatePartsTellsNothingAcrossThem) {
  Random draws(3);
  const Sparse part = network(12, 40, draws);
  std::vector<Eigen::Triplet<double>> triplets;
  for (Eigen::Index j = 0; j < 12; ++j)
    for (Sparse::InnerIterator it(part, j); it; ++it)
      for (const Eigen::Index at : {0, 12}) triplets.emplace_back(at + it.row(), at + j, it.value());
  Sparse both(24, 24);
  both.setFromTriplets(triplets.begin(), triplets.end());
  const auto factor = calib::SparseFactor::of(both);
  ASSERT_NE(factor, nullptr);
  for (Eigen::Index i = 0; i < 12; ++i)
    for (Eigen::Index j = 0; j < 12; ++j) {
      const double across = factor->inverse(i, 12 + j).value_or(0.0);  // zeros may stand in the pattern
      EXPECT_EQ(across, 0.0);
    }
  EXPECT_NEAR(*factor->inverse(3, 3), *factor->inverse(15, 15), 1e-12 * *factor->inverse(3, 3));
}

TEST(SparseFactor, OfADiagonalIsItsReciprocal) {
  Sparse N(5, 5);
  for (int i = 0; i < 5; ++i) N.insert(i, i) = std::pow(4.0, i);
  N.makeCompressed();
  const auto factor = calib::SparseFactor::of(N);
  ASSERT_NE(factor, nullptr);
  for (int i = 0; i < 5; ++i) EXPECT_DOUBLE_EQ(*factor->inverse(i, i), std::pow(4.0, -i));
  EXPECT_DOUBLE_EQ(factor->condition(), std::pow(4.0, -4)) << "smallest pivot over the largest";
}

TEST(SparseFactor, OfOneNumber) {
  Sparse N(1, 1);
  N.insert(0, 0) = 9.0;
  N.makeCompressed();
  const auto factor = calib::SparseFactor::of(N);
  ASSERT_NE(factor, nullptr);
  EXPECT_DOUBLE_EQ(*factor->inverse(0, 0), 1.0 / 9.0);
  EXPECT_DOUBLE_EQ(factor->solve(Eigen::MatrixXd::Constant(1, 1, 3.0))(0, 0), 1.0 / 3.0);
  EXPECT_EQ(factor->condition(), 1.0);
}

TEST(SparseFactor, ThereIsNoneOfWhatIsNotPositiveDefinite) {
  Random draws(5);
  const Sparse good = network(20, 60, draws);
  for (const double bad : {-1.0, std::nan("")}) {
    Sparse N = good;
    N.coeffRef(7, 7) = bad;
    EXPECT_EQ(calib::SparseFactor::of(N), nullptr) << bad;
  }
}

TEST(SparseFactor, OfASingularMatrixHasNoConditionToSpeakOf) {
  // Differences alone: a level net without a bench mark, whose heights all may rise together.
  std::vector<Eigen::Triplet<double>> triplets;
  for (int i = 0; i + 1 < 30; ++i)
    for (const auto& [r, c, v] :
         {std::tuple{i, i, 1.0}, {i + 1, i + 1, 1.0}, {i, i + 1, -1.0}, {i + 1, i, -1.0}})
      triplets.emplace_back(r, c, v);
  Sparse N(30, 30);
  N.setFromTriplets(triplets.begin(), triplets.end());
  const auto factor = calib::SparseFactor::of(N);
  if (factor != nullptr) EXPECT_LT(factor->condition(), 1e-14);
  // Fixed at one end it is a chain of unit steps: the variance grows by one with each step.
  N.coeffRef(0, 0) += 1.0;
  const auto held = calib::SparseFactor::of(N);
  ASSERT_NE(held, nullptr);
  for (int i = 0; i < 30; ++i) EXPECT_NEAR(*held->inverse(i, i), i + 1.0, 1e-10);
}

}  // namespace sparse_factor_test
}  // namespace octant::test
