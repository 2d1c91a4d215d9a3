// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Segments matched with walls: residuals and their derivatives by moving the pose; matches of small scans.
#include "models/localizers/line_map/line_matching.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/line_map/line_map.h"
#include "models/simulator/random.h"
#include "tests/support/numeric.h"

namespace octant::test {
namespace line_matching_test {

/// Points of a wall as seen from a pose, evenly from end to end.
std::vector<Eigen::Vector2d> seen(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Pose& T,
                                  int count = 40) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d p = from + (to - from) * (i + 0.5) / count;
    points.emplace_back((T.inverse() * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>());
  }
  return points;
}

OdometryState state_at(double x, double y, double heading, double sigma_m = 0.2, double sigma_rad = 0.05) {
  OdometryState s{.p_map_m = {x, y}, .heading_rad = heading};
  s.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
  return s;
}

RC_GTEST_PROP(ObserveWall, IsNothingWhereTheSegmentLiesOnTheWallAndChangesAsItsDerivativeSays, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const Eigen::Vector2d from(draws.uniform(1, 6), draws.uniform(1, 6)),
      to = from + Eigen::Vector2d(draws.normal(), draws.normal()) * 2;
  RC_PRE((to - from).norm() > 0.5);
  const OdometryState pose = state_at(draws.normal(), draws.normal(), draws.uniform(-3, 3));
  const LineSegment segment = fit_segment(seen(from, to, pose.pose())), on_map = wall(from, to).segment;
  const LineMapOptions options;
  const WallObservation o = observe_wall(pose, segment, on_map, options);
  RC_ASSERT(o.residual.norm() < 1e-9);
  const auto residual = [&](const Eigen::VectorXd& off) -> Eigen::VectorXd {
    OdometryState moved = pose;
    moved.p_map_m += off.head<2>();
    moved.heading_rad += off[2];
    return observe_wall(moved, segment, on_map, options).residual;
  };
  // Expected change of the pose: minus the residual's derivative.
  RC_ASSERT((o.H + numeric_jacobian(residual, Eigen::Vector3d::Zero(), 1e-5)).cwiseAbs().maxCoeff() < 1e-8);
}

// Mean and slope of n evenly spread points, by least squares.
TEST(ObserveWall, NoiseIsThatOfALineThroughItsPoints) {
  LineMapOptions options;
  options.line_sigma_m = options.line_sigma_rad = 0.0;
  options.range_sigma_m = 0.03;
  constexpr int kPoints = 200;
  const Pose T;
  const LineSegment segment = fit_segment(seen({2, -1.5}, {2, 2.5}, T, kPoints));
  const WallObservation o =
      observe_wall(OdometryState{}, segment, wall({2, -1.5}, {2, 2.5}).segment, options);
  Eigen::Matrix2d N = Eigen::Matrix2d::Zero();
  for (int i = 0; i < kPoints; ++i) {
    const double s = 4.0 * ((i + 0.5) / kPoints - 0.5);  // along the wall, from its middle
    N += Eigen::Vector2d(1, s) * Eigen::RowVector2d(1, s) / (0.03 * 0.03);
  }
  const Eigen::Matrix2d C = N.inverse();
  EXPECT_NEAR(o.noise[0], C(0, 0), 1e-12);
  // The ends of the points are half a spacing inside the wall's: one in two hundred of the length.
  EXPECT_NEAR(o.noise[1], C(1, 1), 0.02 * C(1, 1));
}

TEST(ObserveWall, TakesASegmentsOwnScatterWhereThatIsMore) {
  LineMapOptions options;
  LineSegment segment = fit_segment(seen({2, -1}, {2, 1}, Pose()));
  const LineSegment on_map = wall({2, -1}, {2, 1}).segment;
  const double before = observe_wall(OdometryState{}, segment, on_map, options).noise[0];
  segment.rms_m = 10 * options.range_sigma_m;
  EXPECT_GT(observe_wall(OdometryState{}, segment, on_map, options).noise[0], before);
}

/// A corner of two walls 3 m ahead and 2 m to the side of the origin.
struct Corner {
  LineMap map;
  std::vector<LineSegment> segments;
  std::vector<Eigen::Vector2d> points;

  explicit Corner(const Pose& truth) {
    const std::pair<Eigen::Vector2d, Eigen::Vector2d> walls[] = {{{3, -4}, {3, 2}}, {{3, 2}, {-4, 2}}};
    for (const auto& [from, to] : walls) {
      map.lines.push_back(wall(from, to));
      const auto of_wall = seen(from, to, truth, 60);
      segments.push_back(fit_segment(of_wall));
      points.insert(points.end(), of_wall.begin(), of_wall.end());
    }
  }
  [[nodiscard]] std::pmr::vector<WallMatches> matches(const OdometryState& prior,
                                                      const LineMapOptions& options = {}) const {
    return match_walls(prior, segments, points, map, options);
  }
};

const WallMatches& best_of(const std::pmr::vector<WallMatches>& all) {
  return *std::min_element(all.begin(), all.end(),
                           [](const WallMatches& a, const WallMatches& b) { return a.cost < b.cost; });
}

TEST(MatchWalls, TwoWallsTellThePose) {
  const Pose truth = Pose::planar(0.15, -0.1, 0.04);
  const Corner corner(truth);
  const auto all = corner.matches(state_at(0, 0, 0));
  const WallMatches& best = best_of(all);
  EXPECT_EQ(best.matched, 2);
  EXPECT_EQ(best.wall, (std::pmr::vector<int>{0, 1}));
  // The prior pulls by the ratio of variances: 1e-4 of 0.04.
  EXPECT_LT((best.state.p_map_m - truth.translation_m.head<2>()).norm(), 5e-3);
  EXPECT_NEAR(best.state.heading_rad, 0.04, 1e-3);
  EXPECT_LT(best.state.covariance(0, 0), 1e-3);
}

// Information of prior and walls add up, and the walls' own errors are those of least squares.
TEST(MatchWalls, CovarianceIsThatOfPriorAndSegments) {
  const Corner corner{Pose()};
  const OdometryState prior = state_at(0, 0, 0);
  const LineMapOptions options;
  const auto all = corner.matches(prior, options);
  const WallMatches& best = best_of(all);
  ASSERT_EQ(best.matched, 2);
  Eigen::Matrix3d N = prior.covariance.inverse(), spread = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < 2; ++i) {
    const WallObservation o =
        observe_wall(best.state, corner.segments[i], corner.map.lines[i].segment, options);
    const Eigen::Matrix2d W = o.noise.cwiseInverse().asDiagonal();
    N += o.H.transpose() * W * o.H;
    const Eigen::Vector2d walls(options.map_sigma_m * options.map_sigma_m,
                                options.map_sigma_rad * options.map_sigma_rad);
    spread += o.H.transpose() * W * walls.asDiagonal() * W * o.H;
  }
  // Formed a last step, of less than a micrometre, before.
  EXPECT_LT((best.state.covariance * N - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((best.wall_spread - spread).cwiseAbs().maxCoeff(), 1e-4 * spread.cwiseAbs().maxCoeff());
}

TEST(MatchWalls, NoMatchAtAllIsOneOfTheWays) {
  const Corner corner{Pose()};
  const OdometryState prior = state_at(0, 0, 0);
  const auto all = corner.matches(prior);
  const bool has_none =
      std::any_of(all.begin(), all.end(), [](const WallMatches& m) { return m.matched == 0; });
  EXPECT_TRUE(has_none || best_of(all).matched == 2) << "or it ended in all of them";
  const auto nothing = match_walls(prior, {}, {}, corner.map, LineMapOptions());
  ASSERT_EQ(nothing.size(), 1U);
  EXPECT_EQ(nothing[0].matched, 0);
  EXPECT_LT((nothing[0].state.covariance - prior.covariance).cwiseAbs().maxCoeff(), 1e-12) << "the prior";
}

TEST(MatchWalls, AWallBeyondTheGatesIsNone) {
  const Corner corner(Pose::planar(0, 0, 0));
  for (const OdometryState& prior : {state_at(2.5, -2.5, 0, 3.0), state_at(0, 0, 0.5, 0.2, 1.0)})
    for (const WallMatches& m : corner.matches(prior)) EXPECT_EQ(m.matched, 0);
}

TEST(MatchWalls, OfWaysNoTwoAreTheSame) {
  const Corner corner(Pose::planar(0.1, 0.1, 0.02));
  const auto all = corner.matches(state_at(0, 0, 0, 0.5, 0.1));
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(all[i].wall, all[j].wall);
}

}  // namespace line_matching_test
}  // namespace octant::test
