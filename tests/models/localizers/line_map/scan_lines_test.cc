// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/line_map/scan_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/LU>

#include "models/localizers/drive/odometry_track.h"
#include "models/simulator/random.h"
#include "tests/models/localizers/walls.h"

namespace octant {
namespace scan_lines_test {

using test::scan_of;
using test::Wall;

constexpr double kDegree = std::numbers::pi / 180.0;

/// Smieszek's table 1: normal form of three lines.
struct Row {
  double c_mm, alpha_deg;
};
constexpr std::array<Row, 3> kTable1 = {{{8700, 92}, {4600, 1}, {1600, 178}}};

/// A driveway with these lines: the building ahead (92 deg) and a wall on either side, observed by a scanner
/// of 190 degrees and 80 m with half a degree between beams (LMS511) in the direction of +y.
std::vector<Wall> driveway() {
  std::vector<Wall> walls;
  const double from[3] = {-1.9, -5.0, -8.5}, to[3] = {4.8, 8.5, 0.5};
  for (std::size_t i = 0; i < 3; ++i) {
    const double alpha = kTable1[i].alpha_deg * kDegree, c = kTable1[i].c_mm / 1000;
    const Eigen::Vector2d normal(std::cos(alpha), std::sin(alpha)), along(-normal.y(), normal.x());
    // Along runs left of the normal: backwards for the building, up on the right side, down on the left one.
    const double sign = i == 0 ? -1 : 1;
    walls.push_back({c * normal + sign * from[i] * along, c * normal + sign * to[i] * along});
  }
  return walls;
}
Scan driveway_scan(double noise_m, Random& random) {
  return scan_of(
      driveway(), Pose(),
      {.angle_min_rad = -5 * kDegree, .step_rad = 0.5 * kDegree, .beams = 381, .range_max_m = 80.0}, noise_m,
      random);
}

TEST(Table1, IterativeSegmentsFindTheThreeLines) {
  Random random(2);
  const auto segments = scan_segments(driveway_scan(0.02, random), {.split_m = 0.08});
  for (const LineSegment& s : segments)
    std::cout << 1000 * s.line.c_m << " mm at " << s.line.alpha_rad / kDegree << " deg, " << s.count
              << " points, " << s.length_m() << " m\n";
  for (const Row& row : kTable1) {
    // Each wall's largest segment: 20 mm noise over 40 points or more leaves 10 mm and 0.2 degrees, at three
    // sigma.
    const LineSegment* largest = nullptr;
    for (const LineSegment& s : segments)
      if (std::abs(s.line.alpha_rad / kDegree - row.alpha_deg) < 3 &&
          (largest == nullptr || s.count > largest->count))
        largest = &s;
    ASSERT_NE(largest, nullptr) << row.alpha_deg;
    EXPECT_NEAR(1000 * largest->line.c_m, row.c_mm, 12);
    EXPECT_NEAR(largest->line.alpha_rad / kDegree, row.alpha_deg, 0.4);
  }
}

TEST(Cluster, DividesAtGaps) {
  const std::vector<Eigen::Vector2d> points = {{1, 0}, {1, 0.1}, {1, 0.2}, {1, 0.51}, {1, 0.8}, {3, 0.9}};
  // eq. 2 holds at the threshold itself: a gap of 0.3 m does not divide, one of 0.31 m does.
  const auto first = cluster(points, 0.0, {.gap_m = 0.3, .gap_beams = 0.0});
  EXPECT_THAT(first, testing::ElementsAre(0, 3, 5, 6));
  EXPECT_THAT(cluster(points, 0.2, {.gap_m = 0.3, .gap_beams = 4.0}), testing::ElementsAre(0, 5, 6));
  EXPECT_THAT(cluster({}, 0.1), testing::ElementsAre(0));
}

TEST(Segments, SplitAtTheCorner) {
  std::vector<Eigen::Vector2d> corner;
  for (int i = 0; i <= 20; ++i) corner.emplace_back(2.0, -1.0 + 0.1 * i);
  for (int i = 1; i <= 15; ++i) corner.emplace_back(2.0 - 0.1 * i, 1.0);
  const auto segments = iterative_segments(corner);
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_NEAR(segments[0].line.c_m, 2.0, 1e-12);
  EXPECT_NEAR(segments[0].line.alpha_rad, 0.0, 1e-12);
  EXPECT_NEAR(segments[0].length_m(), 2.0, 1e-12);
  EXPECT_NEAR(segments[1].line.c_m, 1.0, 1e-12);
  EXPECT_NEAR(segments[1].line.alpha_rad, std::numbers::pi / 2, 1e-12);
  EXPECT_TRUE(iterative_segments(std::span(corner).first(1)).empty());
  EXPECT_TRUE(iterative_segments({}).empty());
}

TEST(Segments, LeaveOutWhatSawNothing) {
  Scan scan{.time_s = 0,
            .angle_min_rad = 0,
            .angle_increment_rad = 0.1,
            .range_m = {1.0, std::nan(""), 80.0, -1.0, 2.0}};
  EXPECT_EQ(scan_points(scan, {.range_max_m = 80.0}).size(), 2u);
}

/// A segment observed in two parts equals the whole segment, and moves with its frame.
TEST(Segments, JoinAndMove) {
  Random random(3);
  std::vector<Eigen::Vector2d> all;
  for (int i = 0; i < 60; ++i) all.emplace_back(0.05 * i, 1.0 + 0.02 * i + 0.01 * random.normal());
  const LineSegment whole = fit_segment(all), a = fit_segment(std::span(all).first(25)),
                    b = fit_segment(std::span(all).subspan(25));
  ASSERT_TRUE(may_join(a, b, {}));
  const LineSegment both = joined(a, b);
  EXPECT_NEAR(both.line.c_m, whole.line.c_m, 1e-12);
  EXPECT_NEAR(both.line.alpha_rad, whole.line.alpha_rad, 1e-12);
  EXPECT_NEAR(both.rms_m, whole.rms_m, 1e-12);
  const Pose T = Pose::planar(3.0, -2.0, 0.7);
  std::vector<Eigen::Vector2d> moved;
  for (const auto& p : all) moved.push_back((T * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>());
  const LineSegment there = fit_segment(moved), carried = transformed(whole, T);
  EXPECT_NEAR(carried.line.c_m, there.line.c_m, 1e-12);
  EXPECT_NEAR(carried.line.alpha_rad, there.line.alpha_rad, 1e-12);
  EXPECT_FALSE(may_join(whole, carried, {}));
}

TEST(Odometry, CovarianceIsConsistent) {
  Random random(5);
  const OdometryAccuracy accuracy{.distance_sigma_m_per_sqrt_m = 0.02,
                                  .heading_sigma_rad_per_sqrt_m = 0.03,
                                  .heading_sigma_per_rad = 0.05};
  std::vector<OdometryStep> steps(
      40, {.time_s = 0, .dx_m = 0.1, .dy_m = 0.01, .dheading_rad = 0.02, .vehicle = {}});
  OdometryState mean;
  for (const OdometryStep& s : steps) advance(mean, s, accuracy);
  double sum = 0.0;
  constexpr int kRuns = 1000;
  const Eigen::Matrix3d information = mean.covariance.inverse();
  for (int k = 0; k < kRuns; ++k) {
    Pose T;
    for (const OdometryStep& s : steps) {
      const double d = std::hypot(s.dx_m, s.dy_m);
      const double m = std::hypot(0.02 * std::sqrt(d), 1e-4),
                   r = std::hypot(0.03 * std::sqrt(d), 0.05 * s.dheading_rad, 1e-4);
      T = T * Pose::planar(s.dx_m + m * random.normal(), s.dy_m + m * random.normal(),
                           s.dheading_rad + r * random.normal());
    }
    const Eigen::Vector3d e(T.translation_m.x() - mean.p_map_m.x(), T.translation_m.y() - mean.p_map_m.y(),
                            wrap_angle(T.heading_rad() - mean.heading_rad));
    sum += e.dot(information * e);
  }
  // 1000 times 3 degrees of freedom: sigma of the mean is sqrt(2 / 3000) of it, and the linearisation's
  // second order in a heading sigma of 0.06 rad is some per cent of a sigma.
  EXPECT_NEAR(sum / (3 * kRuns), 1.0, 4 * std::sqrt(2.0 / (3 * kRuns)));
}

}  // namespace scan_lines_test
}  // namespace octant
