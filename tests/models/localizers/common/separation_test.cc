// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/separation.h"

#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"

namespace octant {
namespace separation_test {

/// A linear problem of three unknowns: four rows of each of five beacons, two that are no beacon's.
struct LinearProblem {
  Eigen::MatrixXd J;
  Eigen::VectorXd r;
  std::vector<int> beacon;  ///< group of each row; -1: no group

  explicit LinearProblem(std::uint64_t seed) {
    Random random(seed, 1);
    J.resize(22, 3);
    r.resize(22);
    for (int i = 0; i < 22; ++i) {
      beacon.push_back(i < 20 ? i / 4 : -1);
      for (int k = 0; k < 3; ++k) J(i, k) = random.normal();
      r[i] = random.normal();
    }
  }
  /// Rows that are not of a beacon.
  [[nodiscard]] LinearProblem without(int b) const {
    LinearProblem out = *this;
    for (int i = 0; i < J.rows(); ++i)
      if (beacon[static_cast<std::size_t>(i)] == b) {
        out.J.row(i).setZero();
        out.r[i] = 0.0;
      }
    return out;
  }
  [[nodiscard]] Eigen::Vector3d solution() const { return -J.colPivHouseholderQr().solve(r); }
  [[nodiscard]] Eigen::Matrix3d covariance() const { return (J.transpose() * J).inverse(); }
  [[nodiscard]] BeaconSums sums() const {
    BeaconSums sums(3, 5);
    for (int i = 0; i < J.rows(); ++i) {
      const int b = beacon[static_cast<std::size_t>(i)];
      if (b < 0) {
        sums.add(J.row(i), r[i]);
      } else {
        sums.add(BeaconId(static_cast<std::size_t>(b)), J.row(i), r[i], 0.0);
      }
    }
    return sums;
  }
};

// Against the least-squares problem solved again by QR without the beacon's rows.
TEST(BeaconSums, AreTheSolutionsWithoutEachBeacon) {
  const LinearProblem p(7);
  const auto separations = p.sums().separations();
  ASSERT_EQ(separations.size(), 5u);
  for (int b = 0; b < 5; ++b) {
    const BeaconSeparation& s = separations[static_cast<std::size_t>(b)];
    const LinearProblem q = p.without(b);
    ASSERT_TRUE(s.determined);
    EXPECT_EQ(s.arrivals, 4);
    // The residuals are those at a zero state; the fix without the beacon has an offset there.
    EXPECT_NEAR(s.shift_m, q.solution().head<2>().norm(), 1e-12);
    const Eigen::Matrix2d P = q.covariance().topLeftCorner<2, 2>();
    EXPECT_NEAR(s.variance_m2, P.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff(), 1e-12);
  }
}

// At the solution, the misfit of a beacon is the decrease of the cost without its rows.
TEST(BeaconSums, TheMisfitIsWhatTheCostLoses) {
  LinearProblem p(11);
  p.r += p.J * p.solution();
  const auto separations = p.sums().separations();
  for (int b = 0; b < 5; ++b) {
    const LinearProblem q = p.without(b);
    const double left = (q.r + q.J * q.solution()).squaredNorm();
    EXPECT_NEAR(separations[static_cast<std::size_t>(b)].misfit, p.r.squaredNorm() - left, 1e-11);
  }
}

TEST(BeaconSums, NoLevelOnABeaconThatTheFixHangsOnNorOnOneAtFault) {
  LinearProblem p(3);
  p.r += p.J * p.solution();
  EXPECT_GT(p.sums().level_m(1.0), kFaultFreeSigmas - 1e-12);
  LinearProblem bad = p;
  bad.r[4] += 30.0;  // sigmas, of beacon 1
  EXPECT_EQ(bad.sums().protection(1.0).at_fault, BeaconId(1));
  EXPECT_EQ(bad.sums().level_m(1.0), 0.0);
  BeaconSums one(3, 1);
  for (int i = 0; i < 3; ++i) one.add(BeaconId(0), p.J.row(i), 0.0, 0.0);
  EXPECT_EQ(one.level_m(1.0), 0.0);
  one.clear();
  EXPECT_EQ(one.separations().size(), 0u);
}

}  // namespace separation_test
}  // namespace octant
