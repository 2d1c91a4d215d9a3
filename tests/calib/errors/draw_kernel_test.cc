// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/draw_kernel.h"

#include <array>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

namespace octant::calib {
namespace draw_kernel_test {

using Matrix = Eigen::MatrixXd;

/// Two chains, of three states with three coordinates and of one with two, observed by random rows of one
/// state or of two neighbours.
struct TwoChains {
  std::mt19937_64 random{7};
  Matrix J = Matrix::Zero(60, 11);
  StateTaps taps;
  StateChains chains;

  TwoChains() {
    std::normal_distribution<double> normal;
    const std::array<std::array<int, 2>, 4> states = {{{0, 3}, {3, 3}, {6, 3}, {9, 2}}};
    taps.first = {0};
    for (int i = 0; i < J.rows(); ++i) {
      const int at = i % 4;
      const bool both = at < 2 && i % 3 == 0;
      const int last = both ? states[at + 1][0] + states[at + 1][1] : states[at][0] + states[at][1];
      for (int c = states[at][0]; c < last; ++c) {
        J(i, c) = static_cast<float>(normal(random));
        taps.taps.push_back({static_cast<std::uint32_t>(c), static_cast<float>(J(i, c))});
      }
      taps.first.push_back(static_cast<std::uint32_t>(taps.taps.size()));
    }
    const Matrix N = J.transpose() * J;
    Matrix A = N.block(0, 0, 3, 3);
    for (int k = 0; k < 4; ++k) {
      const bool is_last = k >= 2;
      const int size = states[k][1];
      if (k == 3) A = N.block(9, 9, 2, 2);
      StateChains::Link link;
      link.first = static_cast<std::uint32_t>(states[k][0]);
      link.size = size;
      link.inverse = keep(A.inverse());
      if (!is_last) {
        const Matrix U = N.block(3 * k, 3 * k + 3, 3, 3), onward = A.inverse() * U;
        link.next_size = 3;
        link.onward = keep(onward);
        A = N.block(3 * k + 3, 3 * k + 3, 3, 3) - U.transpose() * onward;
      }
      chains.links.push_back(link);
    }
    chains.coordinates = 11;
  }

  std::size_t keep(const Matrix& block) {
    chains.blocks.insert(chains.blocks.end(), block.data(), block.data() + block.size());
    return chains.blocks.size() - static_cast<std::size_t>(block.size());
  }
};

std::vector<DrawLine> random_lines(std::size_t rows, std::mt19937_64& random) {
  std::normal_distribution<float> normal;
  std::vector<DrawLine> lines(rows);
  for (DrawLine& line : lines)
    for (float& v : line.of) v = normal(random);
  return lines;
}

Matrix matrix_of(const std::vector<DrawLine>& lines) {
  Matrix m(static_cast<Eigen::Index>(lines.size()), static_cast<Eigen::Index>(kDrawsAbreast));
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index k = 0; k < m.cols(); ++k) m(i, k) = lines[static_cast<std::size_t>(i)].of[k];
  return m;
}

constexpr double kRounding = 2e-5;  // some sixty products in single precision

TEST(DrawKernel, StatesTakeWhatADenseProjectionTakes) {
  TwoChains world;
  std::vector<DrawLine> e = random_lines(60, world.random);
  const Matrix before = matrix_of(e);
  const Matrix expected =
      before - world.J * (world.J.transpose() * world.J).ldlt().solve(world.J.transpose() * before);
  std::vector<StateLine> room;
  subtract_states(world.taps, world.chains, e, room);
  EXPECT_LT((matrix_of(e) - expected).cwiseAbs().maxCoeff(), kRounding);
}

TEST(DrawKernel, ProductsWithInfluencesAreEigens) {
  std::mt19937_64 random(8);
  for (const std::size_t rows : {1U, 7U, 8U, 61U})
    for (const std::size_t rank : {1U, 5U, 33U}) {
      std::vector<DrawLine> e = random_lines(rows, random), t = random_lines(rank, random);
      std::vector<float> F;
      Matrix dense(rows, rank);
      for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t k = 0; k < rank; ++k)
          F.push_back(static_cast<float>(dense(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
                                             static_cast<float>(std::normal_distribution<double>()(random))));
      const Matrix projected = matrix_of(t) + dense.transpose() * matrix_of(e);
      add_projection(F.data(), rows, rank, e.data(), t.data());
      EXPECT_LT((matrix_of(t) - projected).cwiseAbs().maxCoeff(), kRounding) << rows << " x " << rank;
      const Matrix left = matrix_of(e) - dense * matrix_of(t);
      subtract_product(F.data(), rows, rank, t.data(), e.data());
      EXPECT_LT((matrix_of(e) - left).cwiseAbs().maxCoeff(), 10 * kRounding) << rows << " x " << rank;
    }
}

TEST(DrawKernel, CellsAndSquaresAddUp) {
  std::mt19937_64 random(9);
  const std::vector<DrawLine> values = random_lines(20, random);
  std::vector<std::int32_t> cell;
  for (int i = 0; i < 20; ++i) cell.push_back(i * i % 3);
  std::vector<DrawLine> sums(3);
  add_to_cells(cell, values.data(), sums.data());
  Matrix expected = Matrix::Zero(3, kDrawsAbreast);
  for (int i = 0; i < 20; ++i) expected.row(cell[static_cast<std::size_t>(i)]) += matrix_of(values).row(i);
  EXPECT_LT((matrix_of(sums) - expected).cwiseAbs().maxCoeff(), kRounding);
  std::array<double, kDrawsAbreast> squares{};
  squares[2] = 5.0;
  add_squares(values.data(), values.size(), squares.data());
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(kDrawsAbreast); ++k)
    EXPECT_NEAR(squares[static_cast<std::size_t>(k)],
                matrix_of(values).col(k).squaredNorm() + (k == 2 ? 5.0 : 0.0), 1e-9);
}

}  // namespace draw_kernel_test
}  // namespace octant::calib
