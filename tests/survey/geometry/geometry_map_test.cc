// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/geometry_map.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "models/physics/receiver_array.h"
#include "models/simulator/random.h"
#include "tests/survey/brute_force.h"

namespace octant::survey {
namespace geometry_map_test {

using test::brute_arrivals;
using test::BruteArrival;
using test::information_of;

SurveyModel bare_model(Motion motion, Clock clock) {
  SurveyModel model;
  model.motion = motion;
  model.clock = clock;
  model.receivers = {{"r0", Eigen::Vector3d::Zero()}};
  model.unknowns = unknowns_of(motion, clock, model.receivers);
  model.noise.constant_m = 0.01;
  return model;
}

SurveyModel polygon_of(int n, Clock clock) {
  SurveyModel model = bare_model(Motion::kPlanar, clock);
  for (int i = 0; i < n; ++i) {
    const double turn = 0.3 + 2 * std::numbers::pi * i / n;
    model.beacons.push_back({"B", {10 * std::cos(turn), 10 * std::sin(turn), 0.0}});
  }
  return model;
}

PoseList at(double x, double y, double z = 0.0, double heading = 0.0) {
  PoseList poses;
  poses.add(x, y, z, heading);
  return poses;
}

// H'H = n/2 I at the centre, and the clock's column of ones is orthogonal to the sums of sines and cosines.
TEST(GeometryMap, RegularPolygonAtItsCentre) {
  for (int n = 3; n <= 40; ++n) {
    const auto same = evaluate_poses(polygon_of(n, Clock::kSynchronised), at(0, 0));
    EXPECT_NEAR(same[kHdop][0], 2 / std::sqrt(n), 1e-12) << n;
    EXPECT_NEAR(same[kSigma][0], 0.01 * 2 / std::sqrt(n), 1e-14) << n;
    EXPECT_EQ(same[kTdop][0], 0.0);
    const auto offset = evaluate_poses(polygon_of(n, Clock::kCycleOffset), at(0, 0));
    EXPECT_NEAR(offset[kHdop][0], 2 / std::sqrt(n), 1e-12) << n;
    EXPECT_NEAR(offset[kTdop][0], 1 / std::sqrt(n), 1e-12) << n;
    EXPECT_NEAR(offset[kGdop][0], std::sqrt(5.0 / n), 1e-12) << n;
    EXPECT_EQ(same[kBeacons][0], n);
    // All ranges wrong by the same part of themselves: it cancels at the centre.
    EXPECT_NEAR(same[kShiftBySpeed][0], 0.0, 1e-12);
  }
}

// An octagon of radius r: each range's derivative by the heading is r sin(angle between lever arm and
// beacon); over both full circles the sum of squares is n m r^2 / 2, and a beacon fixed by m receivers counts
// m times.
TEST(GeometryMap, HeadingOfAnArrayAtThePolygonsCentre) {
  SurveyModel model = polygon_of(12, Clock::kSynchronised);
  model.receivers.clear();
  for (const auto& corner : octagon(0.05, 0.0)) model.receivers.push_back({"r", corner.position_m});
  model.unknowns = unknowns_of(model.motion, model.clock, model.receivers);
  for (auto& beacon : model.beacons) beacon.p_map_m *= 1e6;  // plane waves
  const auto f = evaluate_poses(model, at(0, 0));
  const double r = octagon_radius_m(0.05);
  EXPECT_NEAR(f[kHeadingDop][0], 1 / (r * std::sqrt(12 * 8 / 2.0)), 1e-6);
  EXPECT_NEAR(f[kHdop][0], 2 / std::sqrt(12 * 8), 1e-6);
  EXPECT_EQ(f[kArrivals][0], 96);
}

// One satellite overhead and three evenly round the horizon: A = diag(3/2, 3/2) and [[1, 1], [1, 4]] in (z,
// t), whose inverse is
// [[4, -1], [-1, 1]] / 3; so HDOP^2 = VDOP^2 = 4/3, TDOP^2 = 1/3, GDOP = sqrt 3.
TEST(GeometryMap, SatelliteOverheadAndThreeOnTheHorizon) {
  SurveyModel model = bare_model(Motion::kSpatial, Clock::kCycleOffset);
  constexpr double kFar = 2.0e7;
  model.beacons.push_back({"zenith", {0, 0, kFar}});
  for (int i = 0; i < 3; ++i)
    model.beacons.push_back(
        {"horizon",
         {kFar * std::cos(i * 2 * std::numbers::pi / 3), kFar * std::sin(i * 2 * std::numbers::pi / 3), 0}});
  const auto f = evaluate_poses(model, at(0, 0));
  EXPECT_NEAR(f[kGdop][0], 1.7320508, 1e-6);
  EXPECT_NEAR(f[kPdop][0], std::sqrt(8.0 / 3), 1e-6);
  EXPECT_NEAR(f[kHdop][0], std::sqrt(4.0 / 3), 1e-6);
  EXPECT_NEAR(f[kVdop][0], std::sqrt(4.0 / 3), 1e-6);
  EXPECT_NEAR(f[kTdop][0], std::sqrt(1.0 / 3), 1e-6);
}

// With S = sum u u' of trace n and s = sum u, H'H = [[S, s], [s', n]]; by Schur complements its inverse has
// the blocks (S - s s'/n)^-1 >= S^-1 and 1 / (n - s' S^-1 s) >= 1/n, and tr S^-1 >= 9 / tr S: no GDOP of n
// satellites is below sqrt(10 / n), and those of a regular tetrahedron and of an octahedron (s = 0, S = n/3
// I) reach it.
TEST(GeometryMap, LeastDilutionOfPlatonicConstellations) {
  constexpr double kFar = 2.0e7;
  SurveyModel tetrahedron = bare_model(Motion::kSpatial, Clock::kCycleOffset), octahedron = tetrahedron;
  for (int i = 0; i < 4; ++i)
    tetrahedron.beacons.push_back(
        {"S",
         Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, (i == 0 || i == 3) ? 1 : -1).normalized() * kFar});
  for (int i = 0; i < 6; ++i)
    octahedron.beacons.push_back({"S", Eigen::Vector3d::Unit(i / 2) * (i % 2 ? kFar : -kFar)});
  EXPECT_NEAR(evaluate_poses(tetrahedron, at(0, 0))[kGdop][0], std::sqrt(10.0 / 4), 1e-9);
  EXPECT_NEAR(evaluate_poses(octahedron, at(0, 0))[kGdop][0], std::sqrt(10.0 / 6), 1e-9);
  Random draw(10);
  for (int n = 4; n < 30; ++n) {
    SurveyModel any = bare_model(Motion::kSpatial, Clock::kCycleOffset);
    for (int i = 0; i < n; ++i) any.beacons.push_back({"S", draw.normal3().normalized() * kFar});
    EXPECT_GE(evaluate_poses(any, at(0, 0))[kGdop][0], std::sqrt(10.0 / n)) << n;
  }
}

// Published: Stanford NAV Lab, gnss_lib_py, tests/utils/test_metrics.py (test_simple_dop, 7 Feb 2024):
// satellites at elevations of 0, 0, 45, 45 and 90 degrees at azimuths of 0, 90, 180, 270 and 0.
TEST(GeometryMap, FiveSatellitesAsPublished) {
  SurveyModel model = bare_model(Motion::kSpatial, Clock::kCycleOffset);
  constexpr double kFar = 2.0e7;
  const double half = std::sqrt(0.5), root2 = std::sqrt(2.0);
  for (const Eigen::Vector3d& east_north_up :
       {Eigen::Vector3d(0, 1, 0), {1, 0, 0}, {0, -half, half}, {-half, 0, half}, {0, 0, 1}})
    model.beacons.push_back({"S", kFar * east_north_up});
  const auto f = evaluate_poses(model, at(0, 0));
  EXPECT_NEAR(f[kGdop][0], std::sqrt(23.0 / 3), 1e-9);
  EXPECT_NEAR(f[kPdop][0], std::sqrt(77.0 / 3) / 2, 1e-9);
  EXPECT_NEAR(f[kHdop][0], std::sqrt(25.0 / 6 - root2), 1e-9);
  EXPECT_NEAR(f[kVdop][0], std::sqrt(9.0 / 4 + root2), 1e-9);
  EXPECT_NEAR(f[kTdop][0], std::sqrt(5.0) / 2, 1e-9);
}

TEST(GeometryMap, NothingDeterminedIsNoFix) {
  SurveyModel model = bare_model(Motion::kPlanar, Clock::kSynchronised);
  model.beacons = {{"A", {0, 0, 0}}, {"B", {4, 0, 0}}};
  const auto on_the_line = evaluate_poses(model, at(1, 0));
  EXPECT_EQ(on_the_line[kHdop][0], kNoFix);
  EXPECT_EQ(on_the_line[kSigma][0], kNoFix);
  EXPECT_EQ(on_the_line[kProtection][0], kNoFix);
  const auto beside = evaluate_poses(model, at(2, 2));
  EXPECT_NEAR(beside[kHdop][0], std::sqrt(2.0), 1e-12);  // at right angles
  EXPECT_EQ(beside[kProtection][0], kNoFix);             // nobody could notice a fault
  model.hearing.range_m = 2.5;
  EXPECT_EQ(evaluate_poses(model, at(2, 2))[kBeacons][0], 0);
  EXPECT_EQ(evaluate_poses(model, PoseList())[kHdop].size(), 0u);
}

/// A world full of everything: directed beacons and receivers, walls of all heights, a threshold.
SurveyModel random_model(Random& draw, Motion motion, Clock clock, bool array, int beacons, int walls) {
  SurveyModel model = bare_model(motion, clock);
  model.patterns.resize(3);
  model.patterns[0].half_angle_rad = 1.2;
  model.patterns[1] = {.name = "p", .kind = BeamPattern::Kind::kCosinePower, .exponent = 1.7};
  model.patterns[2] = {.name = "t",
                       .kind = BeamPattern::Kind::kTable,
                       .angle_rad = {0, 0.8, 1.5, 2.4},
                       .gain = {1, 0.8, 0.3, 0}};
  if (array) {
    model.receivers.clear();
    for (const auto& corner : octagon(0.3, 0.25))
      model.receivers.push_back(
          {"r", corner.position_m + 0.02 * draw.normal3(), corner.axis, draw.uniform() < 0.5 ? 0 : 2u});
  }
  model.unknowns = unknowns_of(motion, clock, model.receivers);
  for (int i = 0; i < beacons; ++i) {
    SurveyBeacon b{"B", {draw.uniform(0, 30), draw.uniform(0, 20), draw.uniform(2, 4)}};
    if (draw.uniform() < 0.7) {
      b.axis = Eigen::Vector3d(15 - b.p_map_m.x(), 10 - b.p_map_m.y(), -1.5).normalized();
      b.pattern = static_cast<std::size_t>(draw.uniform(0, 3));
    }
    model.beacons.push_back(b);
  }
  for (int i = 0; i < walls; ++i) {
    WallPiece wall;
    wall.from_m = {draw.uniform(0, 30), draw.uniform(0, 20)};
    wall.to_m = wall.from_m + Eigen::Vector2d(draw.uniform(-5, 5), draw.uniform(-5, 5));
    if (draw.uniform() < 0.6)
      wall.bottom_m = draw.uniform(0, 1.5), wall.top_m = wall.bottom_m + draw.uniform(0.5, 3);
    model.walls.push_back(wall);
  }
  model.hearing = {.amplitude_1m_v = 10, .threshold_v = 0.1, .absorption_np_per_m = 0.06};
  model.noise = {.constant_m = 0.004, .per_m = draw.uniform() < 0.5 ? 0.0 : 0.001, .per_sqrt_m = 0.0};
  if (draw.uniform() < 0.5) model.noise.per_sqrt_m = 0.002;
  return model;
}

/// The margins of gains and distances are not checked. Tables are linear over the cosine, so a pair in some
/// thousands may be on the other side of the threshold. Those cells are counted, and few.
struct Agreement {
  int cells = 0, fixes = 0, other_pairs = 0, noticed = 0, unnoticed = 0;
};

/// Ranges of one beacon after the other biased: the bias that a test of 0.1 % detects with a power of 80 %
/// (Baarda), and its effect.
void compare_integrity(const SurveyModel& model, const std::vector<BruteArrival>& arrivals,
                       const Eigen::MatrixXd& C, const GeometryFigures& f, std::size_t i,
                       Agreement& agreement) {
  constexpr double kTwoSided999 = 3.290527, kOneSided80 = 0.841621;  // quantiles of the normal distribution
  constexpr double kRounded = 1e-3;                                  // the map has them to three digits
  const auto m = static_cast<Eigen::Index>(arrivals.size());
  Eigen::MatrixXd H(m, C.rows());
  Eigen::VectorXd w(m);
  for (Eigen::Index a = 0; a < m; ++a) {
    const auto& arrival = arrivals[static_cast<std::size_t>(a)];
    H.row(a) = arrival.row, w[a] = 1 / (arrival.sigma_m * arrival.sigma_m);
  }
  double bias_m = 0.0, shift_m = 0.0;
  for (std::size_t b = 0; b < model.beacons.size(); ++b) {
    const Eigen::VectorXd of_b = Eigen::VectorXd::NullaryExpr(
        m, [&](Eigen::Index a) { return arrivals[static_cast<std::size_t>(a)].beacon == b ? 1.0 : 0.0; });
    if (of_b.isZero()) continue;
    const Eigen::VectorXd moved = C * (H.transpose() * w.cwiseProduct(of_b));
    const Eigen::VectorXd residual = of_b - H * moved;
    const double left = residual.dot(w.cwiseProduct(residual)) / of_b.dot(w.cwiseProduct(of_b));
    if (left < 1e-4 && left > 1e-8) return;  // on the verge of what counts as unnoticed, or lost to rounding
    if (left <= 1e-8) {
      ++agreement.unnoticed;
      EXPECT_EQ(f[kDetectableBias][i], kNoFix);
      EXPECT_EQ(f[kProtection][i], kNoFix);
      return;
    }
    const double just_found_m =
        (kTwoSided999 + kOneSided80) / std::sqrt(residual.dot(w.cwiseProduct(residual)));
    bias_m = std::max(bias_m, just_found_m);
    shift_m = std::max(shift_m, just_found_m * moved.head<2>().norm());
  }
  ++agreement.noticed;
  const double largest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(C.topLeftCorner<2, 2>()).eigenvalues()[1];
  EXPECT_NEAR(f[kDetectableBias][i], bias_m, kRounded * bias_m);
  EXPECT_NEAR(f[kFaultShift][i], shift_m, kRounded * shift_m);
  EXPECT_NEAR(f[kProtection][i], shift_m + kTwoSided999 * std::sqrt(largest), kRounded * f[kProtection][i]);
}

void compare(const SurveyModel& model, const PoseList& poses, Agreement& agreement) {
  const auto f = evaluate_poses(model, poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto arrivals =
        brute_arrivals(model, poses.x_m[i], poses.y_m[i], poses.z_m[i], poses.heading_rad[i]);
    ++agreement.cells;
    if (arrivals.size() != f[kArrivals][i]) {
      ++agreement.other_pairs;
      continue;
    }
    const Eigen::MatrixXd A = information_of(model, arrivals, true),
                          plain = information_of(model, arrivals, false);
    const Eigen::VectorXd scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse(),
                          plain_scale = plain.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(scaled);
    const double condition = svd.singularValues()(0) / svd.singularValues()(svd.singularValues().size() - 1);
    if (!(condition < 1e9) || A.diagonal().minCoeff() <= 0) {
      if (!(condition < 1e12)) EXPECT_EQ(f[kHdop][i], kNoFix);
      continue;
    }
    ++agreement.fixes;
    const Eigen::MatrixXd C = scale.asDiagonal() * scaled.inverse() * scale.asDiagonal();
    const Eigen::MatrixXd Q = plain_scale.asDiagonal() *
                              (plain_scale.asDiagonal() * plain * plain_scale.asDiagonal()).eval().inverse() *
                              plain_scale.asDiagonal();
    if (Q(0, 0) + Q(1, 1) > 0.9e8) continue;  // about 10,000: no fix
    // 1e-10 of the value where the geometry is sound; the inverse itself is no better than the condition
    // times rounding.
    const double tolerance = 1e-10 * std::max(1.0, condition / 1e4);
    const auto near = [&](double value, double expected) {
      EXPECT_NEAR(value, expected, tolerance * (expected + 1e-9)) << condition;
    };
    const int n = model.unknowns.count(), p = model.unknowns.position;
    near(f[kHdop][i], std::sqrt(Q(0, 0) + Q(1, 1)));
    near(f[kPdop][i], std::sqrt(Q.topLeftCorner(p, p).trace()));
    near(f[kVdop][i], p == 3 ? std::sqrt(Q(2, 2)) : 0.0);
    near(f[kTdop][i], model.unknowns.clock ? std::sqrt(Q(n - 1, n - 1)) : 0.0);
    near(f[kGdop][i],
         std::sqrt(Q.topLeftCorner(p, p).trace() + (model.unknowns.clock ? Q(n - 1, n - 1) : 0.0)));
    if (model.unknowns.rotation > 0)
      near(f[kHeadingDop][i], std::sqrt(Q(p + model.unknowns.rotation - 1, p + model.unknowns.rotation - 1)));
    near(f[kSigma][i], std::sqrt(C(0, 0) + C(1, 1)));
    near(f[kSigmaX][i], std::sqrt(C(0, 0)));
    near(f[kSigmaY][i], std::sqrt(C(1, 1)));
    near(f[kSigmaZ][i], p == 3 ? std::sqrt(C(2, 2)) : 0.0);
    near(f[kSigmaHeading][i], model.unknowns.rotation > 0 ? std::sqrt(C(p + model.unknowns.rotation - 1,
                                                                        p + model.unknowns.rotation - 1))
                                                          : 0.0);
    EXPECT_NEAR(f[kCovarianceXy][i], C(0, 1), tolerance * C.diagonal().head<2>().maxCoeff());
    compare_integrity(model, arrivals, C, f, i, agreement);
    Eigen::VectorXd by_speed = Eigen::VectorXd::Zero(n);
    for (const auto& a : arrivals) by_speed += a.row * a.distance_m / (a.sigma_m * a.sigma_m);
    EXPECT_NEAR(f[kShiftBySpeed][i], (C * by_speed).head<2>().norm(),
                1e-8 * std::max(1.0, condition / 1e4) * (1 + f[kShiftBySpeed][i]));
  }
}

TEST(GeometryMap, AgreesWithTheBruteForceInverseInTenThousandCells) {
  Random draw(20261121);
  Agreement agreement;
  for (int world = 0; world < 24; ++world) {
    const Motion motion = world % 2 == 0 ? Motion::kPlanar : Motion::kSpatial;
    const Clock clock = world / 2 % 2 == 0 ? Clock::kSynchronised : Clock::kCycleOffset;
    const SurveyModel model = random_model(draw, motion, clock, world / 4 % 2 == 1, 6 + world, 4 * world);
    // Spread and in clusters: common exclusions are examined only for neighbours. No list is a multiple of a
    // vector.
    for (int list = 0; list < 5; ++list) {
      PoseList poses;
      const double x0 = draw.uniform(1, 28), y0 = draw.uniform(1, 18), heading = draw.uniform(-3, 3);
      for (int i = 0; i < 91; ++i) {
        const double z = motion == Motion::kSpatial ? draw.uniform(0, 1.5) : 0.0;
        if (list == 0)
          poses.add(draw.uniform(0, 30), draw.uniform(0, 20), z, draw.uniform(-3, 3));
        else
          poses.add(x0 + draw.uniform(0, 0.2), y0 + draw.uniform(0, 0.2), z, heading);
      }
      compare(model, poses, agreement);
    }
  }
  EXPECT_GT(agreement.cells, 10000);
  EXPECT_GT(agreement.fixes, 4000);
  EXPECT_LT(agreement.other_pairs, 20);
  EXPECT_GT(agreement.noticed, 1000);
  EXPECT_GT(agreement.unnoticed, 100);
}

TEST(GeometryMap, LayersAddUpToTheMap) {
  Random draw(5);
  for (int world = 0; world < 8; ++world) {
    const SurveyModel model =
        random_model(draw, world % 2 ? Motion::kSpatial : Motion::kPlanar,
                     world % 4 < 2 ? Clock::kSynchronised : Clock::kCycleOffset, world > 3, 15, 10);
    PoseList poses;
    for (int i = 0; i < 1003; ++i)
      poses.add(draw.uniform(0, 30), draw.uniform(0, 20), 0.3, draw.uniform(-3, 3));
    const auto map = evaluate_poses(model, poses, {.threads = 2});
    const auto heard = heard_at(model, poses, 2);
    std::vector<BeaconLayer> layers;
    for (const auto& beacon : model.beacons) layers.push_back(beacon_layer(model, beacon, poses));
    for (std::size_t b = 0; b < layers.size(); ++b) EXPECT_EQ(layers[b].heard, heard[b]);
    std::vector<double> sigma(poses.size()), sum(layers[0].information.size());
    for (const auto& layer : layers)
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += layer.information[i];
    sigma_of_information(model.unknowns, sum, sigma);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      int beacons = 0;
      for (const auto& row : heard) beacons += row[i];
      EXPECT_EQ(map[kBeacons][i], beacons);
      // Near-singular cells may be on either side, because pivots are in another order.
      if (map[kSigma][i] < 10 || sigma[i] < 10)
        EXPECT_NEAR(sigma[i], map[kSigma][i], 1e-6 * map[kSigma][i]) << i;
    }
  }
}

TEST(GeometryMap, ThreadsDoNotMatter) {
  Random draw(9);
  const SurveyModel model = random_model(draw, Motion::kPlanar, Clock::kSynchronised, true, 20, 20);
  PoseList poses;
  for (int i = 0; i < 40000; ++i) poses.add(30.0 * (i % 200) / 200, 20.0 * (i / 200) / 200, 0, 0);
  EXPECT_EQ(evaluate_poses(model, poses, {.threads = 1})[kHdop],
            evaluate_poses(model, poses, {.threads = 3})[kHdop]);
}

}  // namespace geometry_map_test
}  // namespace octant::survey
