// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/spatial_start.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/simulator/random.h"

namespace octant::test {
namespace spatial_start_test {

SearchProblem ranges_of(const std::vector<Eigen::Vector3d>& beacons, const Eigen::Vector3d& p,
                        double offset_m = 0.0) {
  SearchProblem problem;
  for (const Eigen::Vector3d& b : beacons) {
    SearchRange r;
    r.p_beacon_map_m = b;
    r.range_m = (p - b).norm() + offset_m;
    problem.ranges.push_back(r);
  }
  return problem;
}

std::vector<Eigen::Vector3d> scattered(int count, Random& draws) {
  std::vector<Eigen::Vector3d> beacons;
  for (int i = 0; i < count; ++i)
    beacons.emplace_back(draws.uniform(0, 20), draws.uniform(0, 12), draws.uniform(0, 6));
  return beacons;
}

/// Smallest over largest extent of the beacons about their centre.
double flatness(const std::vector<Eigen::Vector3d>& beacons) {
  Eigen::MatrixXd B(3, static_cast<Eigen::Index>(beacons.size()));
  for (std::size_t i = 0; i < beacons.size(); ++i) B.col(static_cast<Eigen::Index>(i)) = beacons[i];
  const Eigen::MatrixXd C = B.colwise() - B.rowwise().mean();
  const Eigen::Vector3d s = Eigen::JacobiSVD<Eigen::MatrixXd>(C).singularValues();
  return s[2] / s[0];
}

RC_GTEST_PROP(LinearPositions, OfExactRangesAreThePlace, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const auto beacons = scattered(*rc::gen::inRange(5, 12), draws);
  RC_PRE(flatness(beacons) > 0.05);
  const Eigen::Vector3d p(draws.uniform(0, 20), draws.uniform(0, 12), draws.uniform(0, 3));
  const LinearPositions found = linear_positions(ranges_of(beacons, p));
  RC_ASSERT(found.count == 1U);
  // Squares of twenty metres lose half their digits to the normal equations.
  RC_ASSERT((found.p_map_m[0] - p).norm() < 1e-6);
}

RC_GTEST_PROP(LinearPositions, AnUnknownOffsetIsFoundBesideThePlace, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const auto beacons = scattered(9, draws);
  RC_PRE(flatness(beacons) > 0.1);
  const Eigen::Vector3d p(draws.uniform(5, 15), draws.uniform(3, 9), draws.uniform(1, 4));
  SearchProblem problem = ranges_of(beacons, p, draws.uniform(-2, 15));
  problem.has_offset = true;
  const LinearPositions found = linear_positions(problem);
  RC_ASSERT(found.count == 1U);
  // If ranges hardly differ, the offset absorbs the position. It is then omitted, and there is no fix.
  RC_ASSERT((found.p_map_m[0] - p).norm() < 1e-3);
}

RC_GTEST_PROP(LinearPositions, BeaconsInAPlaneLeaveBothSides, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  auto beacons = scattered(6, draws);
  for (Eigen::Vector3d& b : beacons) b.z() = 0.0;
  const Eigen::Vector3d p(draws.uniform(3, 17), draws.uniform(2, 10), draws.uniform(1, 4));
  const Pose tipped{draws.normal3(), exp_rotation(draws.normal3())};  // a plane of any direction
  for (Eigen::Vector3d& b : beacons) b = tipped * b;
  const Eigen::Vector3d here = tipped * p, image = tipped * Eigen::Vector3d(p.x(), p.y(), -p.z());
  const LinearPositions found = linear_positions(ranges_of(beacons, here));
  RC_ASSERT(found.count == 2U);
  const bool first = (found.p_map_m[0] - here).norm() < (found.p_map_m[1] - here).norm();
  // Heights of a metre come out of differences of squares of twenty.
  RC_ASSERT((found.p_map_m[first ? 0 : 1] - here).norm() < 1e-5);
  RC_ASSERT((found.p_map_m[first ? 1 : 0] - image).norm() < 1e-5);
}

TEST(CoarseRotations, AreThoseOfTheCubeEachOnce) {
  const auto all = coarse_rotations();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Eigen::Matrix3d R = all[i].toRotationMatrix();
    EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
    // Axes go to axes.
    EXPECT_LT((R.cwiseAbs() - R.cwiseAbs().array().round().matrix()).cwiseAbs().maxCoeff(), 1e-12);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT(all[i].angularDistance(all[j]), M_PI / 2 - 1e-9) << i << ", " << j;
  }
}

RC_GTEST_PROP(CoarseRotations, NoneIsFurtherThan63Degrees, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const Eigen::Quaterniond q(draws.normal(), draws.normal(), draws.normal(), draws.normal());
  double nearest = M_PI;
  for (const Eigen::Quaterniond& r : coarse_rotations())
    nearest = std::min(nearest, r.angularDistance(q.normalized()));
  RC_ASSERT(nearest <= 63.0 / 180 * M_PI);
}

TEST(Differs, ByADistanceOrATenthOfARadian) {
  const Pose a = Pose::planar(1, 2, 0.5);
  EXPECT_FALSE(differs(a, a, 0.0));
  EXPECT_FALSE(differs(a, Pose::planar(1.09, 2, 0.5), 0.1));
  EXPECT_TRUE(differs(a, Pose::planar(1.11, 2, 0.5), 0.1));
  EXPECT_FALSE(differs(a, Pose::planar(1, 2, 0.59), 0.1));
  EXPECT_TRUE(differs(a, Pose::planar(1, 2, 0.61), 0.1));
  EXPECT_FALSE(differs(a, Pose::planar(1, 2, 0.5 + 2 * M_PI), 0.1));
}

}  // namespace spatial_start_test
}  // namespace octant::test
