// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Ends joined one by one against the Schur complement of one dense matrix of all of them; with the chains
// that they come from: tests/calib/chain/chain_reduction_test.cc.
#include "calib/stream/drives/end_chain.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "calib/adjust/tile.h"
#include "calib/chain/chain_reduction.h"
#include "models/simulator/random.h"

namespace octant::test {
namespace end_chain_test {

/// Pieces of a drive as quadratic forms of parameters, left end and right end.
struct Pieces {
  Eigen::Index n;
  std::vector<calib::OpenChain> pieces;
  Eigen::MatrixXd H;  ///< information of parameters and all ends
  Eigen::VectorXd g;
  double cost = 0.0;

  Pieces(Eigen::Index parameters, std::size_t count, Random& draws) : n(parameters) {
    const auto ends = static_cast<Eigen::Index>(count - 1);
    H = Eigen::MatrixXd::Zero(n + 3 * ends, n + 3 * ends);
    g = Eigen::VectorXd::Zero(n + 3 * ends);
    for (std::size_t k = 0; k < count; ++k) {
      calib::OpenChain piece;
      piece.has_left = k > 0;
      piece.has_right = k + 1 < count;
      const Eigen::Index size = n + 3 * (piece.has_left + piece.has_right);
      Eigen::MatrixXd A(size + 3, size);
      for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = draws.normal();
      piece.H = A.transpose() * A;
      piece.gradient.resize(size);
      for (double& v : piece.gradient) v = draws.normal();
      piece.cost = draws.uniform(1, 2);
      std::vector<Eigen::Index> at;
      for (Eigen::Index i = 0; i < n; ++i) at.push_back(i);
      const auto end = static_cast<Eigen::Index>(k);
      for (Eigen::Index i = 0; piece.has_left && i < 3; ++i) at.push_back(n + 3 * (end - 1) + i);
      for (Eigen::Index i = 0; piece.has_right && i < 3; ++i) at.push_back(n + 3 * end + i);
      H(at, at) += piece.H;
      g(at) += piece.gradient;
      cost += piece.cost;
      pieces.push_back(std::move(piece));
    }
  }
  [[nodiscard]] calib::EndChain joined() const {
    calib::EndChain chain(n, 3);
    for (const calib::OpenChain& piece : pieces) chain.append(piece);
    return chain;
  }
};

RC_GTEST_PROP(EndChain, LeavesTheSchurComplementOfAllEnds, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const int n = *rc::gen::inRange(1, 9);
  const Pieces all(n, static_cast<std::size_t>(*rc::gen::inRange(1, 8)), draws);
  const Eigen::Index ends = all.H.rows() - n;
  Eigen::MatrixXd H = all.H.topLeftCorner(n, n);
  Eigen::VectorXd g = all.g.head(n);
  double cost = all.cost;
  if (ends > 0) {
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(all.H.bottomRightCorner(ends, ends));
    H -= all.H.topRightCorner(n, ends) * lu.solve(all.H.bottomLeftCorner(ends, n));
    g -= all.H.topRightCorner(n, ends) * lu.solve(all.g.tail(ends));
    cost -= 0.5 * all.g.tail(ends).dot(lu.solve(all.g.tail(ends)));
  }
  calib::ReducedSystem out;  // to what stands there already it is added
  out.cost = 5.0;
  out.H = Eigen::MatrixXd::Identity(n, n);
  out.gradient = Eigen::VectorXd::Ones(n);
  all.joined().add_to(out);
  // The ends' blocks are conditioned to some 1e4.
  const double scale = 1e-9 * all.H.cwiseAbs().maxCoeff();
  RC_ASSERT((out.H - H - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff() < scale);
  RC_ASSERT((out.gradient - g - Eigen::VectorXd::Ones(n)).cwiseAbs().maxCoeff() < scale);
  RC_ASSERT(std::abs(out.cost - cost - 5.0) < scale);
}

RC_GTEST_PROP(EndChain, StepsAreThoseOfTheWholeSystem, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const int n = *rc::gen::inRange(1, 6);
  const Pieces all(n, static_cast<std::size_t>(*rc::gen::inRange(2, 8)), draws);
  Eigen::VectorXd dx(n);
  for (double& v : dx) v = draws.normal();
  const std::vector<NodeVector> steps = all.joined().steps(dx);
  const Eigen::Index ends = all.H.rows() - n;
  RC_ASSERT(static_cast<Eigen::Index>(3 * steps.size()) == ends);
  const Eigen::VectorXd want = -all.H.bottomRightCorner(ends, ends)
                                    .fullPivLu()
                                    .solve(all.g.tail(ends) + all.H.bottomLeftCorner(ends, n) * dx);
  for (std::size_t k = 0; k < steps.size(); ++k)
    RC_ASSERT((steps[k] - want.segment<3>(static_cast<Eigen::Index>(3 * k))).norm() <
              1e-8 * (1 + want.norm()));
}

TEST(EndChain, OfOnePieceHasNoEnds) {
  Random draws(1);
  const Pieces one(4, 1, draws);
  EXPECT_TRUE(one.joined().steps(Eigen::VectorXd::Zero(4)).empty());
}

TEST(EndChain, AnEndThatNothingObservesLeavesNumbers) {
  Random draws(2);
  Pieces all(3, 3, draws);
  for (calib::OpenChain& piece : all.pieces) {
    const Eigen::Index rest = piece.H.rows() - 3;
    piece.H.bottomRows(rest).setZero();
    piece.H.rightCols(rest).setZero();
    piece.gradient.tail(rest).setZero();
  }
  calib::ReducedSystem out;
  out.H = Eigen::MatrixXd::Zero(3, 3);
  out.gradient = Eigen::VectorXd::Zero(3);
  all.joined().add_to(out);
  Eigen::MatrixXd want = Eigen::MatrixXd::Zero(3, 3);
  for (const calib::OpenChain& piece : all.pieces) want += piece.H.topLeftCorner(3, 3);
  EXPECT_LT((out.H - want).cwiseAbs().maxCoeff(), 1e-12 * want.cwiseAbs().maxCoeff())
      << "nothing is taken away";
  for (const NodeVector& step : all.joined().steps(Eigen::VectorXd::Ones(3))) EXPECT_EQ(step.norm(), 0.0);
}

}  // namespace end_chain_test
}  // namespace octant::test
