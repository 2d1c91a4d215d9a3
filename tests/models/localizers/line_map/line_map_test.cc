// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/line_map/line_map_localizer.h"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "models/localizers/line_map/line_matching.h"
#include "tests/models/localizers/walls.h"
#include "tests/support/allocation_count.h"
#include "tests/support/statistics.h"

namespace octant {
namespace line_map_test {

using test::range_to;
using test::scan_of;
using test::Scanner;
using test::Wall;

constexpr std::uint64_t kSeed = 42;

/// Two rooms with a door between them and an oblique wall, without any symmetry.
const std::vector<Wall> kRooms = {{{0, 0}, {12, 0}},    {{12, 0}, {12, 7}},     {{12, 7}, {9, 9}},
                                  {{9, 9}, {0, 9}},     {{0, 9}, {0, 0}},       {{6, 0}, {6, 3.5}},
                                  {{6, 5.0}, {6, 9}},   {{2, 3}, {3.5, 3}},     {{3.5, 3}, {3.5, 4.2}},
                                  {{9, 2.2}, {9, 4.0}}, {{9, 4.0}, {10.4, 4.0}}};
const std::vector<Wall> kCorridor = {{{-200, 1.1}, {200, 1.1}}, {{-200, -1.1}, {200, -1.1}}};

LineMap map_of(const std::vector<Wall>& walls) {
  LineMap map;
  for (const Wall& w : walls) map.lines.push_back(wall(w.from_m, w.to_m));
  return map;
}

struct Drive {
  std::vector<Scan> scans;
  std::vector<OdometryStep> odometry;
  std::vector<Pose> truth;  ///< at the scans
};

/// Round through both rooms (or straight on), with noisy odometry and a scan each step.
Drive drive(const std::vector<Wall>& walls, int steps, const OdometryAccuracy& noise, double beam_m,
            Random& random, bool straight = false) {
  Drive d;
  Pose T;
  for (int k = 0; k < steps; ++k) {
    const double a = 2 * M_PI * k / 80;
    // A loop through the door, heading along the track.
    const auto at = [](double u) {
      return Eigen::Vector2d(6 + 4.6 * std::cos(u), 4.4 + 1.6 * std::sin(2 * u));
    };
    const Eigen::Vector2d p = at(a), ahead = at(a + 0.01) - p;
    const Pose next = straight ? Pose::planar(0.2 * k, 0.1, 0.0)
                               : Pose::planar(p.x(), p.y(), std::atan2(ahead.y(), ahead.x()));
    OdometryStep step{.time_s = 0.5 * k, .vehicle = VehicleId(0)};
    if (k > 0) {
      const Pose move = T.inverse() * next;
      const double length = move.translation_m.norm(), turn = move.heading_rad();
      const double m = std::hypot(noise.distance_sigma_m_per_sqrt_m * std::sqrt(length), noise.floor_m);
      const double r = std::hypot(noise.heading_sigma_rad_per_sqrt_m * std::sqrt(length),
                                  noise.heading_sigma_per_rad * turn, noise.floor_rad);
      step.dx_m = move.translation_m.x() + m * random.normal();
      step.dy_m = move.translation_m.y() + m * random.normal();
      step.dheading_rad = turn + r * random.normal();
    }
    d.odometry.push_back(step);
    T = next;
    d.truth.push_back(T);
    d.scans.push_back(scan_of(walls, T, Scanner{.range_max_m = 15.0}, beam_m, random, 0.5 * k));
  }
  return d;
}

Eigen::Vector3d error(const Fix& fix, const Pose& truth) {
  return {fix.T_map_vehicle.translation_m.x() - truth.translation_m.x(),
          fix.T_map_vehicle.translation_m.y() - truth.translation_m.y(),
          wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad())};
}

const OdometryAccuracy kOdometry{.distance_sigma_m_per_sqrt_m = 0.05, .heading_sigma_rad_per_sqrt_m = 0.03};
const PoseAccuracy kStart{.position_sigma_m = 0.02, .heading_sigma_rad = 0.01};

TEST(LineMap, IsBuiltFromScansAtKnownPoses) {
  Random random(kSeed);
  const Drive d = drive(kRooms, 80, kOdometry, 0.01, random);
  const LineMap map = build_line_map(d.scans, d.truth, {});
  double longest = 0.0;
  for (const MapLine& line : map.lines) {
    longest = std::max(longest, line.segment.length_m());
    // Each line is one of the walls: both ends within 30 mm (three sigma of a beam), and not beyond its ends.
    bool is_wall = false;
    for (const Wall& w : kRooms) {
      const MapLine truth = wall(w.from_m, w.to_m);
      is_wall = is_wall ||
                may_join(truth.segment, line.segment, {.angle_rad = 0.05, .offset_m = 0.03, .gap_m = 0.0});
    }
    EXPECT_TRUE(is_wall) << line.segment.from_m.transpose() << " - " << line.segment.to_m.transpose();
  }
  EXPECT_GE(map.lines.size(), 9u);
  EXPECT_LE(map.lines.size(), 16u);
  EXPECT_GT(longest, 8.0);
}

TEST(LineMap, CorrectsOdometry) {
  Random random(kSeed);
  const Drive d = drive(kRooms, 160, kOdometry, 0.01, random);
  const TimedPose start{0.0, d.truth[0]};
  const auto corrected =
      LineMapLocalizer(map_of(kRooms)).locate(d.scans, d.odometry, kOdometry, start, kStart);
  const auto alone = LineMapLocalizer(LineMap{}).locate(d.scans, d.odometry, kOdometry, start, kStart);
  ASSERT_EQ(corrected.size(), d.scans.size());
  double with = 0.0, without = 0.0;
  for (std::size_t k = 0; k < corrected.size(); ++k) {
    with = std::max(with, error(corrected[k], d.truth[k]).head<2>().norm());
    without = std::max(without, error(alone[k], d.truth[k]).head<2>().norm());
    EXPECT_EQ(alone[k].arrivals_used, 0);
  }
  std::cout << "largest error " << with << " m, odometry alone " << without << " m\n";
  EXPECT_LT(with, 0.1);
  EXPECT_GT(without, 0.5);
  EXPECT_GT(corrected[40].arrivals_used, 2);
}

/// Where two walls without ends are all there is, the way along them stays with odometry.
TEST(LineMap, CorrectsNothingAlongACorridor) {
  Random random(kSeed + 1);
  const Drive d = drive(kCorridor, 100, kOdometry, 0.01, random, true);
  const TimedPose start{0.0, d.truth[0]};
  LineMapOptions options;
  const auto fixes =
      LineMapLocalizer(map_of(kCorridor), options).locate(d.scans, d.odometry, kOdometry, start, kStart);
  const auto alone =
      LineMapLocalizer(LineMap{}, options).locate(d.scans, d.odometry, kOdometry, start, kStart);
  const Fix& last = fixes.back();
  EXPECT_LT(std::sqrt(last.covariance(1, 1)), 0.1);
  EXPECT_LT(std::abs(error(last, d.truth.back()).y()), 0.1);
  // Along x: the steps' own noise adds up, 0.05 m per sqrt(m) over 20 m and 0.05 m each of 99 steps, as
  // without the map; but for what heading adds without it.
  const double steps_variance = 0.0025 * 0.2 * 99 + 0.0025 * 99 + 4e-4 + 1e-8 * 99;
  EXPECT_NEAR(last.covariance(0, 0), steps_variance, 0.02 * steps_variance);
  EXPECT_GE(alone.back().covariance(0, 0), 0.99 * steps_variance);
  EXPECT_GT(fixes[50].arrivals_used, 0);
}

/// Odometry, beams and walls with the random errors of the options: the last fix of each drive.
TEST(LineMap, CovarianceIsHonest) {
  std::cout << "seed " << kSeed + 2 << "\n";
  Random random(kSeed + 2);
  LineMapOptions options;
  options.step_sigma_m = options.step_sigma_rad = 1e-4;
  options.turn_sigma_per_rad = 0.0;
  options.range_sigma_m = 0.02;
  options.map_sigma_m = 0.03;
  options.map_sigma_rad = 0.002;
  double nees = 0.0;
  constexpr int kDrives = 40;
  int count = 0;
  for (int run = 0; run < kDrives; ++run) {
    const Drive d = drive(kRooms, 30, kOdometry, 0.02, random);
    std::vector<Wall> drawn = kRooms;
    for (Wall& w : drawn) {
      const Eigen::Vector2d along = (w.to_m - w.from_m).normalized(), normal(-along.y(), along.x()),
                            middle = (w.from_m + w.to_m) / 2;
      const Eigen::Rotation2Dd turn(0.002 * random.normal());
      const Eigen::Vector2d shift = 0.03 * random.normal() * normal;
      w = {middle + turn * (w.from_m - middle) + shift, middle + turn * (w.to_m - middle) + shift};
    }
    const auto fixes = LineMapLocalizer(map_of(drawn), options)
                           .locate(d.scans, d.odometry, kOdometry, {0.0, d.truth[0]}, kStart);
    if (!fixes.back().ok()) continue;
    const Eigen::Vector3d e = error(fixes.back(), d.truth.back());
    nees += e.dot(Eigen::Matrix3d(fixes.back().covariance).inverse() * e);
    ++count;
  }
  std::cout << "NEES over degrees of freedom " << nees / (3 * count) << "\n";
  EXPECT_GE(count, kDrives - 2);
  // The walls' errors count as fully correlated from scan to scan, an upper bound: not above chi-square, but
  // below it.
  EXPECT_LT(nees, test::chi2_quantile(0.999, 3 * count));
  EXPECT_GT(nees, 0.2 * 3 * count);
}

TEST(LineMap, PointsSpeakForAndAgainstAPose) {
  const LineMap map = map_of({{{2, -3}, {2, 3}}});
  const std::vector<int> walls = {0};
  LineMapOptions options;
  options.support_every = 1;
  const std::vector<Eigen::Vector2d> points = {{2.05, 0.0},  // on the wall
                                               {1.2, 0.5},   // before it: anything may stand there
                                               {3.0, 0.1},   // behind it
                                               {3.0, 4.4}};  // past its end
  const MapSupport support = map_support(OdometryState{}, points, map, walls, options);
  EXPECT_EQ(support.points, 4);
  EXPECT_EQ(support.on_wall, 1);
  EXPECT_EQ(support.through, 1);
}

/// Started between two positions that agree equally well (pillars 0.8 m apart), the right one is found once
/// the end wall is visible.
TEST(LineMap, FollowsSeveralPosesUntilOneIsClear) {
  Random random(kSeed + 5);
  std::vector<Wall> walls = {{{-20, 1.5}, {12, 1.5}}, {{-20, -1.5}, {12, -1.5}}, {{12, -1.5}, {12, 1.5}}};
  for (double x = -19.6; x < 11.5; x += 0.8) walls.push_back({{x, 0.9}, {x, 1.5}});
  Drive d = drive(kCorridor, 60, kOdometry, 0.01, random, true);
  for (std::size_t k = 0; k < d.scans.size(); ++k)
    d.scans[k] = scan_of(walls, d.truth[k], Scanner{.range_max_m = 4.0}, 0.01, random, d.scans[k].time_s);
  LineMapOptions options;
  const Pose off = Pose::planar(0.42, 0.1, 0.0);
  const PoseAccuracy rough{.position_sigma_m = 0.4, .heading_sigma_rad = 0.02};
  const auto fixes =
      LineMapLocalizer(map_of(walls), options).locate(d.scans, d.odometry, kOdometry, {0.0, off}, rough);
  EXPECT_LT(error(fixes.back(), d.truth.back()).head<2>().norm(), 0.1);
  std::cout << "first status " << to_string(fixes.front().status) << ", last error "
            << error(fixes.back(), d.truth.back()).transpose() << "\n";
}

/// The map of another building: some of its walls are near those of the scans, and must not give a confident
/// fix.
TEST(LineMap, OffItsMapThereIsNoFix) {
  const std::vector<Wall> elsewhere = {{{1, 1.3}, {9, -1.2}}, {{9, -1.2}, {14, 8}}, {{14, 8}, {7.5, 11}},
                                       {{7.5, 11}, {1, 1.3}}, {{5, 4}, {8, 6.5}},   {{3, 6.1}, {3.8, 8.4}}};
  Random random(kSeed + 9);
  const Drive d = drive(kRooms, 80, kOdometry, 0.01, random);
  const auto fixes =
      LineMapLocalizer(map_of(elsewhere)).locate(d.scans, d.odometry, kOdometry, {0.0, d.truth[0]}, kStart);
  std::size_t ok = 0;
  // After two of the windows over which the share is computed.
  for (std::size_t k = 16; k < fixes.size(); ++k) ok += fixes[k].ok();
  EXPECT_EQ(ok, 0u) << "of " << fixes.size() - 16;
  EXPECT_EQ(fixes.back().status, FixStatus::kNoConsensus);
}

TEST(LineMap, SaysWhatARunLacks) {
  const LineMap map = map_of(kRooms);
  MeasurementLog log;
  EXPECT_NE(line_map_fits(map, log).error().message().find("no scans"), std::string::npos);
  log.scans.emplace_back();
  EXPECT_NE(line_map_fits(map, log).error().message().find("no odometry"), std::string::npos);
  log.odometry.emplace_back();
  EXPECT_NE(line_map_fits(map, log).error().message().find("starts"), std::string::npos);
  log.poses.emplace_back();
  EXPECT_TRUE(line_map_fits(map, log));
  EXPECT_FALSE(line_map_fits(LineMap{}, log));
  EXPECT_FALSE(build_line_map(log));
  EXPECT_TRUE(LineMapLocalizer(LineMap{}).locate(log).empty());
}

TEST(LineMap, LivesWithEmptyScansAndOdometryGaps) {
  Random random(kSeed);
  Drive d = drive(kRooms, 20, kOdometry, 0.01, random);
  d.scans[5].range_m.assign(181, std::nan(""));
  d.scans[6].range_m.clear();
  d.odometry.erase(d.odometry.begin() + 12, d.odometry.end());
  const auto fixes =
      LineMapLocalizer(map_of(kRooms)).locate(d.scans, d.odometry, kOdometry, {0.0, d.truth[0]}, kStart);
  ASSERT_EQ(fixes.size(), d.scans.size());
  for (const Fix& fix : fixes)
    EXPECT_TRUE(Eigen::Matrix3d(fix.covariance).allFinite() && fix.T_map_vehicle.translation_m.allFinite());
  EXPECT_EQ(fixes[5].arrivals_used, 0);
}

/// Interface for runs: a map from a run with measured poses, the next run located on it.
TEST(LineMap, FromOneRunToTheNext) {
  Random random(kSeed + 3);
  MeasurementLog first, second;
  const Drive a = drive(kRooms, 80, kOdometry, 0.01, random), b = drive(kRooms, 60, kOdometry, 0.01, random);
  first.scans = a.scans;
  for (std::size_t k = 0; k < a.truth.size(); ++k)
    first.poses.push_back({0.5 * static_cast<double>(k), a.truth[k]});
  const auto map = build_line_map(first);
  ASSERT_TRUE(map) << map.error().message();
  second.scans = b.scans;
  second.odometry = b.odometry;
  second.odometry_accuracy = kOdometry;
  second.pose_accuracy = kStart;
  second.poses.push_back({0.0, b.truth[0]});
  const auto fixes = LineMapLocalizer(*map).locate(second);
  ASSERT_EQ(fixes.size(), b.scans.size());
  EXPECT_LT(error(fixes.back(), b.truth.back()).head<2>().norm(), 0.05);
}

TEST(LineMap, AScanAllocatesNothing) {
  Random random(kSeed);
  const Drive d = drive(kRooms, 60, kOdometry, 0.01, random);
  LineMapLocalizer localizer(map_of(kRooms));
  localizer.start(d.truth[0], kStart, kOdometry);
  Fix fix;
  fix.rejections.reserve(256);
  const std::size_t before = test::allocations();
  int corrected = 0;
  for (std::size_t k = 0; k < d.scans.size(); ++k) {
    if (k > 0) localizer.move(d.odometry[k]);
    localizer.locate(d.scans[k], fix);
    corrected += fix.ok() && fix.arrivals_used > 0;
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GT(corrected, 50);
  EXPECT_LT((fix.T_map_vehicle.translation_m - d.truth.back().translation_m).norm(), 0.05);
}

TEST(LineMap, WithoutAStartThereIsNoFix) {
  Random random(kSeed);
  LineMapLocalizer localizer(map_of(kRooms));
  Fix fix;
  localizer.move({.dx_m = 1.0});
  localizer.locate(drive(kRooms, 1, kOdometry, 0.01, random).scans[0], fix);
  EXPECT_EQ(fix.status, FixStatus::kPoorGeometry);
}

}  // namespace line_map_test
}  // namespace octant
