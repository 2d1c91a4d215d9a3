// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The elimination of a window of states against a dense Schur complement of the bordered matrix.
#include "calib/chain/chain_kernel.h"

#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "calib/chain/stretch_window.h"
#include "models/simulator/random.h"

namespace octant::test {
namespace chain_kernel_test {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The whole of a window as one matrix: its states, the one behind them, the border.
struct DenseWindow {
  int block;
  std::size_t states, width;
  Eigen::MatrixXd A;
  std::vector<char> plain;

  [[nodiscard]] Eigen::Index at(std::size_t state) const { return static_cast<Eigen::Index>(state) * block; }
  [[nodiscard]] Eigen::Index border() const { return at(states + 1); }

  /// Rows of observations: of a state and the next, and (where it is not plain) of some columns of the
  /// border.
  DenseWindow(int n, std::size_t count, std::size_t columns, Random& draws, bool some_plain = false)
      : block(n), states(count), width(columns), plain(count + 1, 0) {
    const auto w = static_cast<Eigen::Index>(width);
    A = Eigen::MatrixXd::Zero(border() + w, border() + w);
    for (std::size_t k = 1; some_plain && k < states; ++k) plain[k] = k % 4 != 0 ? 1 : 0;
    for (std::size_t k = 0; k <= states; ++k) {
      for (int row = 0; row < 2 * n; ++row) {
        Eigen::VectorXd a = Eigen::VectorXd::Zero(A.rows());
        for (int i = 0; i < n; ++i) {
          a[at(k) + i] = draws.normal();
          if (k < states) a[at(k + 1) + i] = draws.normal();
        }
        // Coupling to the neighbour of a plain state only: rows between two states do not belong to the
        // border.
        const bool sees = plain[k] == 0 && (k == states || plain[k + 1] == 0) && row >= n;
        for (Eigen::Index c = 0; sees && c + 1 < w; ++c)
          a[border() + c] = c % 3 == row % 3 ? draws.normal() : 0.0;
        a[border() + w - 1] = draws.normal();  // the residual: the gradient's column
        A += a * a.transpose();
      }
    }
  }

  /// Remainder of the next state and the border.
  [[nodiscard]] Eigen::MatrixXd schur() const {
    const Eigen::Index m = at(states), rest = A.rows() - m;
    return A.bottomRightCorner(rest, rest) -
           A.bottomLeftCorner(rest, m) * A.topLeftCorner(m, m).fullPivLu().solve(A.topRightCorner(m, rest));
  }
};

/// As the kernel takes it.
struct Laid {
  calib::chain::AlignedDoubles D, U, G, H;
  calib::ChainWindow window;

  explicit Laid(const DenseWindow& w, bool tell_plain = false) {
    const auto n = static_cast<std::size_t>(w.block);
    D.assign_zero((w.states + 1) * n * n);
    U.assign_zero(w.states * n * n);
    G.assign_zero((w.states + 1) * n * w.width);
    H.assign_zero(w.width * w.width);
    for (std::size_t k = 0; k <= w.states; ++k) {
      D_of(k, w) = w.A.block(w.at(k), w.at(k), w.block, w.block);
      if (k < w.states)
        Eigen::Map<RowMajor>(U.data() + k * n * n, w.block, w.block) =
            w.A.block(w.at(k), w.at(k + 1), w.block, w.block);
      G_of(k, w) = w.A.block(w.at(k), w.border(), w.block, static_cast<Eigen::Index>(w.width));
    }
    H_of(w) = w.A.bottomRightCorner(static_cast<Eigen::Index>(w.width), static_cast<Eigen::Index>(w.width));
    window = {.block = w.block,
              .states = w.states,
              .width = w.width,
              .D = D.data(),
              .U = U.data(),
              .G = G.data(),
              .H = H.data(),
              .is_plain = tell_plain ? w.plain.data() : nullptr,
              .gradient = w.width - 1};
  }
  Eigen::Map<RowMajor> D_of(std::size_t k, const DenseWindow& w) {
    return {D.data() + k * static_cast<std::size_t>(w.block * w.block), w.block, w.block};
  }
  Eigen::Map<RowMajor> G_of(std::size_t k, const DenseWindow& w) {
    return {G.data() + k * static_cast<std::size_t>(w.block) * w.width, w.block,
            static_cast<Eigen::Index>(w.width)};
  }
  Eigen::Map<RowMajor> H_of(const DenseWindow& w) {
    return {H.data(), static_cast<Eigen::Index>(w.width), static_cast<Eigen::Index>(w.width)};
  }
};

/// Largest difference of the remaining systems, in the scale of the whole; only the lower triangle of H is
/// defined.
double off(Laid& laid, const DenseWindow& w, const Eigen::MatrixXd& schur) {
  const Eigen::MatrixXd D = laid.D_of(w.states, w) - schur.topLeftCorner(w.block, w.block),
                        G = laid.G_of(w.states, w) - schur.topRightCorner(w.block, schur.cols() - w.block);
  Eigen::MatrixXd H = laid.H_of(w) - schur.bottomRightCorner(schur.rows() - w.block, schur.cols() - w.block);
  H = H.triangularView<Eigen::Lower>();
  return std::max({D.cwiseAbs().maxCoeff(), G.cwiseAbs().maxCoeff(), H.cwiseAbs().maxCoeff()}) /
         w.A.cwiseAbs().maxCoeff();
}

// The matrices are conditioned to some 1e4 a state.
constexpr double kRounding = 1e-9;

RC_GTEST_PROP(ChainKernel, LeavesTheSchurComplement, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const int n = *rc::gen::element(3, 4, 6, 7);
  const auto states = static_cast<std::size_t>(*rc::gen::inRange(1, 12));
  const std::size_t width = calib::kBorderPad * static_cast<std::size_t>(*rc::gen::inRange(1, 6));
  const DenseWindow w(n, states, width, draws);
  Laid laid(w);
  calib::eliminate(laid.window, 0.0, 1e-12);
  RC_ASSERT(off(laid, w, w.schur()) < kRounding);
}

RC_GTEST_PROP(ChainKernel, StatesThatDoNotSeeTheBorderMayGoFirst, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const int n = *rc::gen::element(3, 4, 6, 7);
  const auto states = static_cast<std::size_t>(*rc::gen::inRange(2, 12));
  const DenseWindow w(n, states, 2 * calib::kBorderPad, draws, true);
  Laid laid(w, true);
  calib::eliminate(laid.window, 0.0, 1e-12);
  RC_ASSERT(off(laid, w, w.schur()) < kRounding);
}

TEST(ChainKernel, EndsWithTheLastStateWhereNoneFollows) {
  Random draws(11);
  for (const int n : {3, 4, 6, 7}) {
    DenseWindow w(n, 5, calib::kBorderPad, draws);
    // There is no coupling to a later state.
    w.A.middleRows(w.at(5), n).setZero();
    w.A.middleCols(w.at(5), n).setZero();
    Laid laid(w);
    constexpr double kFloor = 1e-10;
    calib::eliminate(laid.window, kFloor, kFloor);
    // A floor of this share of the largest diagonal changes the result by this share, times the condition of
    // the states.
    EXPECT_LT(off(laid, w, w.schur()), 1e-6) << n;
  }
}

TEST(ChainKernel, ADirectionThatNothingSeesTakesNothingAway) {
  Random draws(12);
  DenseWindow w(3, 1, calib::kBorderPad, draws);
  w.A.middleRows(w.at(1), 3).setZero();
  w.A.middleCols(w.at(1), 3).setZero();
  w.A.row(2).setZero();  // the heading of a lone antenna
  w.A.col(2).setZero();
  Laid laid(w);
  calib::eliminate(laid.window, 1e-9, 1e-9);
  const Eigen::Index rest = static_cast<Eigen::Index>(w.width);
  const Eigen::MatrixXd want =
      w.A.bottomRightCorner(rest, rest) -
      w.A.bottomLeftCorner(rest, 2) * w.A.topLeftCorner(2, 2).fullPivLu().solve(w.A.topRightCorner(2, rest));
  Eigen::MatrixXd H = laid.H_of(w) - want;
  H = H.triangularView<Eigen::Lower>();
  EXPECT_LT(H.cwiseAbs().maxCoeff(), 1e-6 * w.A.cwiseAbs().maxCoeff());
}

TEST(ChainKernel, AStateWithoutAnyInformationIsHeldAndLeavesNumbers) {
  Random draws(13);
  DenseWindow w(3, 4, calib::kBorderPad, draws);
  w.A.middleRows(w.at(2), 3).setZero();
  w.A.middleCols(w.at(2), 3).setZero();
  Laid laid(w);
  calib::eliminate(laid.window, 0.0, 1e-9);
  EXPECT_TRUE(laid.H_of(w).allFinite());
  // Without it: neither its elimination nor the coupling through it.
  Eigen::MatrixXd A = w.A;
  for (int i = 0; i < 3; ++i) A(w.at(2) + i, w.at(2) + i) = 1.0;
  w.A = A;
  EXPECT_LT(off(laid, w, w.schur()), kRounding);
}

}  // namespace chain_kernel_test
}  // namespace octant::test
