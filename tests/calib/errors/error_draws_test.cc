// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_draws.h"

#include <array>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

namespace octant::calib {
namespace error_draws_test {

TEST(DrawBits, AreNormal) {
  DrawBits random(3);
  DrawLine line;
  constexpr int kLines = 20'000;
  constexpr double n = kLines * static_cast<double>(kDrawsAbreast);
  double sum = 0.0, squares = 0.0, fourth = 0.0, next = 0.0;
  int beyond = 0;
  float last = 0.0F;
  for (int i = 0; i < kLines; ++i) {
    random.normal(line);
    for (const float v : line.of) {
      sum += v;
      squares += v * v;
      fourth += std::pow(v, 4);
      next += v * last;
      beyond += v > 1.6448536F;
      last = v;
    }
  }
  // Four sigmas of each: variances 1, 2, 96, 1 and p (1 - p) a draw.
  EXPECT_NEAR(sum / n, 0.0, 4 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 1.0, 4 * std::sqrt(2 / n));
  EXPECT_NEAR(fourth / n, 3.0, 4 * std::sqrt(96 / n));
  EXPECT_NEAR(next / n, 0.0, 4 / std::sqrt(n));
  EXPECT_NEAR(beyond / n, 0.05, 4 * std::sqrt(0.05 * 0.95 / n));
}

TEST(CellSums, CoarsePartitionsAreSummedFromFineOnes) {
  constexpr std::size_t kRows = 90;
  std::vector<std::uint32_t> rows;  // every other row of the sample is of this kind
  for (std::uint32_t i = 0; i < kRows; ++i) rows.push_back(2 * i + 1);
  std::vector<std::vector<std::int32_t>> partitions(4, std::vector<std::int32_t>(kRows));
  const std::array<std::int32_t, 4> counts = {2, 10, 30, 9};
  for (std::size_t i = 0; i < kRows; ++i) {
    const auto k = static_cast<std::int32_t>(i);
    partitions[0][i] = k / 45;
    partitions[1][i] = k / 9;  // joins the third's cells
    partitions[2][i] = k / 3;
    partitions[3][i] = k % 9;  // cuts across all of them
  }
  CellSums sums(rows);
  for (std::size_t p = 0; p < 4; ++p) EXPECT_EQ(sums.add(partitions[p], counts[p]), p);
  sums.arrange();
  std::vector<DrawLine> values(2 * kRows);
  DrawBits random(4);
  for (DrawLine& line : values) random.normal(line);
  CellSums::Scratch scratch;
  for (int again = 0; again < 2; ++again) {  // the room is used anew
    const Eigen::MatrixXd squares = sums.squares(values, scratch);
    ASSERT_EQ(squares.rows(), 5);
    for (std::size_t k = 0; k < kDrawsAbreast; ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      double all = 0.0;
      for (const std::uint32_t row : rows) all += std::pow(values[row].of[k], 2);
      EXPECT_NEAR(squares(4, column), all, 1e-4);
      for (std::size_t p = 0; p < 4; ++p) {
        std::vector<double> of_cell(static_cast<std::size_t>(counts[p]), 0.0);
        for (std::size_t i = 0; i < kRows; ++i)
          of_cell[static_cast<std::size_t>(partitions[p][i])] += values[rows[i]].of[k];
        const double expected = std::inner_product(of_cell.begin(), of_cell.end(), of_cell.begin(), 0.0);
        EXPECT_NEAR(squares(static_cast<Eigen::Index>(p), column), expected, 1e-4 * (1 + expected));
      }
    }
  }
}

TEST(ProductOfRows, IsTheProduct) {
  const std::vector<float> A = {1, 2, 3, 4, 5, 6}, B = {1, 0, -1, 2, 2, 2};
  const Eigen::MatrixXd product = product_of_rows(A, B, 3);
  const Eigen::Map<const Eigen::Matrix<float, 2, 3, Eigen::RowMajor>> a(A.data()), b(B.data());
  EXPECT_EQ(product, (a.transpose() * b).cast<double>());
}

}  // namespace error_draws_test
}  // namespace octant::calib
