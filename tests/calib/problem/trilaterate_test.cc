// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/trilaterate.h"

#include <random>

#include <gtest/gtest.h>

namespace octant::calib {
namespace trilaterate_test {

/// Ranges from places spread as given to a beacon, with noise and some late by metres.
std::vector<RangeFrom> ranges_to(const Eigen::Vector3d& beacon, const Eigen::Vector3d& spread, int count,
                                 double noise_m, double late_share, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1), share(0, 1);
  std::normal_distribution<double> n;
  std::vector<RangeFrom> ranges;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p(spread.x() * u(random), spread.y() * u(random), 0.3 + spread.z() * u(random));
    const double late = share(random) < late_share ? 1.0 + 3.0 * share(random) : 0.0;
    ranges.push_back({p, (p - beacon).norm() + noise_m * n(random) + late});
  }
  return ranges;
}

TEST(Trilaterate, ExactRangesGiveThePlace) {
  const Eigen::Vector3d beacon(4, -3, 2.5);
  const Trilateration t = trilaterate(ranges_to(beacon, {5, 5, 0.5}, 20, 0.0, 0.0, 1), {.scale_m = 0.01});
  ASSERT_TRUE(t.ok);
  EXPECT_LT((t.p_map_m - beacon).norm(), 1e-6);
}

TEST(Trilaterate, ForgivesAThirdOfEchoes) {
  const Eigen::Vector3d beacon(8, 2, 2.2);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Trilateration t =
        trilaterate(ranges_to(beacon, {5, 5, 0.0}, 60, 0.01, 0.33, seed), {.scale_m = 0.02});
    ASSERT_TRUE(t.ok) << seed;
    EXPECT_LT((t.p_map_m - beacon).norm(), 0.1) << seed;
  }
}

TEST(Trilaterate, FromAPlaneTakesThePlaceAbove) {
  const Trilateration t =
      trilaterate(ranges_to({3, 1, 2.5}, {5, 5, 0.0}, 40, 0.003, 0.0, 2), {.scale_m = 0.01});
  ASSERT_TRUE(t.ok);
  EXPECT_GT(t.p_map_m.z(), 0.3);
  EXPECT_NEAR(t.p_map_m.z(), 2.5, 0.05);
}

/// Everything is fixed, but the agreement of the ranges is still computed (found by fuzzing).
TEST(Trilaterate, APlaceHeldAltogetherIsHeldAgainstItsRanges) {
  const Eigen::Vector3d beacon(4, -3, 2.5);
  const auto ranges = ranges_to(beacon, {5, 5, 0.5}, 20, 0.0, 0.0, 1);
  TrilaterationOptions options{.held = {true, true, true}, .guess = beacon, .scale_m = 0.01};
  const Trilateration there = trilaterate(ranges, options);
  EXPECT_TRUE(there.ok);
  EXPECT_EQ(there.p_map_m, beacon);
  EXPECT_EQ(there.agreeing, 20);
  options.guess.x() += 1.0;
  const Trilateration elsewhere = trilaterate(ranges, options);
  EXPECT_EQ(elsewhere.p_map_m, options.guess);
  EXPECT_LT(elsewhere.agreeing, 5);
}

/// One or two ranges do not span the space: the remaining directions follow from the range (found by
/// fuzzing). One range has two such positions, above and below its origin.
TEST(Trilaterate, OneRangeFindsTheOneCoordinateThatIsOpen) {
  const Eigen::Vector3d beacon(4, -3, 2.5);
  for (const int count : {1, 2}) {
    const auto ranges = ranges_to(beacon, {5, 5, 0.5}, count, 0.0, 0.0, 1);
    const TrilaterationOptions options{.held = {true, true, false}, .guess = {4, -3, 2.0}, .scale_m = 0.01};
    const Trilateration t = trilaterate(ranges, options);
    EXPECT_EQ(t.ok, count == 2);
    EXPECT_EQ(t.agreeing, count);
    const double from_m = ranges.front().p_map_m.z();
    const double height_m = count == 1 ? from_m + std::abs(t.p_map_m.z() - from_m) : t.p_map_m.z();
    EXPECT_NEAR(height_m, 2.5, 1e-3) << count;
  }
}

TEST(Trilaterate, AStraightTrackLeavesAMirrorImage) {
  TrilaterationOptions options{.held = {false, false, true}, .guess = {0, 0, 2.5}, .scale_m = 0.01};
  const std::vector<RangeFrom> ranges = ranges_to({3, 4, 2.5}, {6, 0, 0}, 40, 0.003, 0.0, 3);
  const Trilateration t = trilaterate(ranges, options);
  ASSERT_TRUE(t.ok);
  const auto image = mirror_image_of(t.p_map_m, ranges, options);
  ASSERT_TRUE(image);
  EXPECT_NEAR(image->y(), -t.p_map_m.y(), 0.05);
}

// All observations together determine a position decimetres from that of its ranges alone. Another position
// on the same side that explains the ranges equally well is not an image.
TEST(Trilaterate, TheImageIsOnTheOtherSideOfALineWhereverThePlaceIs) {
  for (int k = 0; k < 24; ++k) {
    const double along_rad = 0.05 + k * M_PI / 12;
    const Eigen::Vector3d u(std::cos(along_rad), std::sin(along_rad), 0.0), across(-u.y(), u.x(), 0.0);
    const Eigen::Vector3d first(10.2, 3.8, 1.5), second = first + 3.4 * u;
    const Eigen::Vector3d beacon = first - 11.8 * u + 5.2 * across + Eigen::Vector3d(0, 0, 1.0),
                          image = beacon - 10.4 * across;
    const Eigen::Vector3d aside =
        Eigen::Vector3d(beacon - first).cross(Eigen::Vector3d::UnitZ()).normalized();
    std::vector<RangeFrom> ranges;
    for (int i = 0; i < 26; ++i) {
      const Eigen::Vector3d& from = i < 21 ? first : second;
      ranges.push_back({from, (beacon - from).norm() + 0.02 * std::sin(7.0 * i)});
    }
    for (const double off_m : {-0.5, 0.5}) {
      const auto found =
          mirror_image_of(beacon + off_m * aside, ranges,
                          {.held = {false, false, true}, .guess = beacon, .scale_m = 0.15, .above = true});
      ASSERT_TRUE(found) << k;
      EXPECT_LT((*found - image).norm(), 0.3) << k;
    }
  }
}

TEST(Trilaterate, RaysTellTheSideOfAStraightTrack) {
  TrilaterationOptions options{.held = {false, false, true}, .guess = {0, 0, 2.5}, .scale_m = 0.01};
  for (const double side : {4.0, -4.0}) {
    const std::vector<RangeFrom> ranges = ranges_to({3, side, 2.5}, {6, 0, 0}, 40, 0.003, 0.0, 3);
    std::vector<RayFrom> rays;
    for (const RangeFrom& r : ranges)
      rays.push_back({r.p_map_m.head<2>(), std::atan2(side - r.p_map_m.y(), 3 - r.p_map_m.x()) + 0.02, 0.01});
    const Trilateration t = trilaterate(ranges, options, rays);
    ASSERT_TRUE(t.ok);
    EXPECT_NEAR(t.p_map_m.y(), side, 0.1);
    EXPECT_NEAR(mirror_image_of(t.p_map_m, ranges, options).value_or(Eigen::Vector3d::Zero()).y(), -side,
                0.1);  // by the ranges alone
  }
}

TEST(Trilaterate, RaysAloneGiveAPlace) {
  TrilaterationOptions options{.held = {false, false, true}, .guess = {0, 0, 2.5}, .scale_m = 0.01};
  std::vector<RayFrom> rays;
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector2d p(i, 0.2 * i * i);
    rays.push_back({p, std::atan2(9 - p.y(), 4 - p.x()), 0.01});
  }
  rays[3].direction_rad += 1.0;
  const Trilateration t = trilaterate({}, options, rays);
  ASSERT_TRUE(t.ok);
  EXPECT_LT((t.p_map_m - Eigen::Vector3d(4, 9, 2.5)).norm(), 0.05);
}

TEST(Trilaterate, HeldCoordinatesStay) {
  TrilaterationOptions options{.held = {false, false, true}, .guess = {0, 0, 1.7}, .scale_m = 0.05};
  const Trilateration t = trilaterate(ranges_to({3, 4, 1.7}, {5, 5, 0}, 30, 0.01, 0.0, 4), options);
  ASSERT_TRUE(t.ok);
  EXPECT_EQ(t.p_map_m.z(), 1.7);
}

TEST(Trilaterate, TooFewRangesAreNoPlace) {
  EXPECT_FALSE(trilaterate({}, {}).ok);
  EXPECT_FALSE(trilaterate(ranges_to({3, 4, 1}, {5, 5, 0}, 2, 0.0, 0.0, 5), {}).ok);
}

}  // namespace trilaterate_test
}  // namespace octant::calib
