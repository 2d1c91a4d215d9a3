// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/head_tail/head_tail.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/localizers/ranging_support.h"
#include "tests/support/allocation_count.h"
#include "tests/support/statistics.h"

namespace octant {
namespace head_tail_test {

using test::hear;
using Point = Eigen::Vector2d;

constexpr std::uint64_t kSeed = 31;
/// Rounding of a solution from lengths of some ten metres, magnified by distance over height near a base
/// line: 1e-15 * 10 * 100.
constexpr double kExact_m = 1e-9;

/// Four base stations near the corners of an 8 x 6 m floor, at uneven heights above the receivers' 0.4 m.
Deployment floor_site() {
  return test::ranging_site({{0.0, 0.0, 2.0}, {8.0, 0.3, 2.2}, {7.8, 6.0, 1.9}, {0.2, 5.7, 2.1}},
                            {{0.35, 0.05, 0.4}, {-0.35, -0.02, 0.4}});
}

Deployment only(Deployment d, const std::vector<std::size_t>& heard) {
  for (std::size_t i = 0; i < d.beacons.size(); ++i)
    if (std::find(heard.begin(), heard.end(), i) == heard.end())
      d.beacons[i].status = BeaconStatus::kUndetermined;
  return d;
}

std::vector<Arrival> arrivals_at(const Deployment& d, const Pose& truth, double noise_s = 0.0, int rounds = 1,
                                 std::uint64_t seed = kSeed) {
  std::mt19937_64 random(seed);
  std::vector<Arrival> all;
  for (int i = 0; i < rounds; ++i) {
    for (const Arrival& a : hear(d, truth, {.range_m = 100.0, .noise_s = noise_s}, random, 7, 0.3 * i))
      all.push_back(a);
  }
  return all;
}

Fix locate(const Deployment& d, const std::vector<Arrival>& arrivals, HeadTailOptions options = {}) {
  HeadTail localizer(d, options);
  const Fix fix = localizer.locate({.arrivals = arrivals, .bearings = {}});
  EXPECT_TRUE(test::has_no_nan(fix));
  return fix;
}

void expect_pose(const Fix& fix, const Pose& truth) {
  ASSERT_TRUE(fix.ok()) << to_string(fix.status);
  EXPECT_LT((fix.T_map_vehicle.translation_m - truth.translation_m).norm(), kExact_m);
  EXPECT_LT(std::abs(wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad())), 1e-8);
}

TEST(Orientation, FollowsTheSevenSteps) {
  // Head north of its tail: the vector to the tail points along -y.
  EXPECT_DOUBLE_EQ(head_orientation_from_y_rad({0, 1}, {0, 0}), M_PI);
  EXPECT_DOUBLE_EQ(head_orientation_from_y_rad({0, 0}, {1, 0}), M_PI / 2)
      << "+x is 90 degrees clockwise of +y";
  EXPECT_DOUBLE_EQ(head_orientation_from_y_rad({0, 0}, {-1, 0}), 3 * M_PI / 2);
  for (int k = 0; k < 360; ++k) {
    const double heading = k * M_PI / 180;
    const Point head(std::cos(heading), std::sin(heading));
    const double from_y = tail_orientation_from_y_rad(head_orientation_from_y_rad(head, -head));
    EXPECT_GE(from_y, 0.0);
    EXPECT_NEAR(wrap_angle(from_y + M_PI / 2 - heading), 0.0, 1e-14) << k;
  }
}

template <class Visit>
void for_each_pose(const Visit& visit) {
  for (double x = 0.6; x < 8; x += 0.85)
    for (double y = 0.5; y < 6; y += 0.83)
      for (int k = 0; k < 8; ++k) visit(Pose::planar(x, y, wrap_angle(0.1 + k * M_PI / 4)));
}

TEST(HeadTail, IsExactWithoutNoise) {
  for (const std::vector<std::size_t>& heard : {std::vector<std::size_t>{0, 1, 2, 3}, {0, 1, 2}, {1, 2, 3}}) {
    const Deployment d = only(floor_site(), heard);
    HeadTail localizer(d);
    for_each_pose([&](const Pose& truth) {
      const auto arrivals = arrivals_at(d, truth);
      const Fix fix = localizer.locate({.arrivals = arrivals, .bearings = {}});
      expect_pose(fix, truth);
      EXPECT_EQ(fix.epoch, 7);
      // Right below a station (15 cm) its range is not informative, and is not used.
      EXPECT_GE(fix.arrivals_used, static_cast<int>(2 * heard.size()) - 2);
      EXPECT_EQ(fix.rejections.size(), arrivals.size());
    });
  }
}

TEST(HeadTail, TwoStationsGiveEitherSideOfTheBaseLine) {
  for (std::size_t first = 0; first < 4; ++first) {
    for (std::size_t second = first + 1; second < 4; ++second) {
      const Deployment d = only(floor_site(), {first, second});
      const Point B = d.beacons[first].position_m.head<2>(), C = d.beacons[second].position_m.head<2>();
      const Point along = (C - B).normalized();
      HeadTail any(d), left(d, {.side = BaseLineSide::kLeft}), right(d, {.side = BaseLineSide::kRight});
      for_each_pose([&](const Pose& truth) {
        const Point off = truth.translation_m.head<2>() - B;
        const double beside_m = along.x() * off.y() - along.y() * off.x();
        // Near the base line a triangle is flat: the vertex is twenty times as uncertain as a range.
        if (std::abs(beside_m) < 1.0) return;
        const auto arrivals = arrivals_at(d, truth);
        const Observations seen{.arrivals = arrivals, .bearings = {}};
        EXPECT_EQ(any.locate(seen).status, FixStatus::kAmbiguous);
        expect_pose((beside_m > 0 ? left : right).locate(seen), truth);
      });
    }
  }
}

TEST(HeadTail, TheKnownLengthTellsTheTailsSide) {
  // The head receives three stations, the tail two: its mirror image would be too far from the head.
  const Deployment d = floor_site();
  const Pose truth = Pose::planar(3.1, 2.2, 0.4);
  std::vector<Arrival> arrivals = arrivals_at(d, truth);
  std::erase_if(arrivals, [](const Arrival& a) {
    return a.receiver.index() == 1 ? a.beacon.index() > 1 : a.beacon.index() == 3;
  });
  expect_pose(locate(d, arrivals), truth);
}

TEST(HeadTail, CovarianceIsThatOfNumericDerivatives) {
  const Deployment d = floor_site();
  HeadTail localizer(d);
  for_each_pose([&](const Pose& truth) {
    const auto arrivals = arrivals_at(d, truth);
    const Fix fix = localizer.locate({.arrivals = arrivals, .bearings = {}});
    ASSERT_TRUE(fix.ok());
    const Eigen::Matrix3d numeric = test::numeric_covariance(localizer, arrivals, d.noise.tof_sigma_s);
    // Weights vary with the vertices (second order, absent without noise) and central differences err by
    // step^2: 1e-4 covers.
    EXPECT_LT((Eigen::Matrix3d(fix.covariance) - numeric).norm(), 1e-4 * numeric.norm());
  });
}

/// Cramer-Rao bound of a pose from the times of both ends, from numeric derivatives of the distances.
Eigen::Matrix3d bound(const Deployment& d, const Pose& truth, double sigma_m) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const auto& b : d.beacons) {
    for (const auto& r : d.receivers) {
      Eigen::RowVector3d row;
      for (int i = 0; i < 3; ++i) {
        Eigen::Vector3d step = Eigen::Vector3d::Zero();
        step[i] = 1e-6;
        const auto distance = [&](double sign) {
          return (retract(truth, sign * step, Motion::kPlanar) * r.position_m - b.position_m).norm();
        };
        row[i] = (distance(1) - distance(-1)) / 2e-6;
      }
      information += row.transpose() * row / (sigma_m * sigma_m);
    }
  }
  return information.inverse();
}

TEST(HeadTail, WithNoiseItStaysWithinItsGeometrysBound) {
  const Deployment d = floor_site();
  HeadTail localizer(d);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> x(1.0, 7.0), y(1.0, 5.0), heading(-M_PI, M_PI);
  constexpr int kFixes = 1500;
  double sum = 0, position2 = 0, bound2 = 0, stated2 = 0;
  for (int i = 0; i < kFixes; ++i) {
    const Pose truth = Pose::planar(x(random), y(random), heading(random));
    auto arrivals = hear(d, truth, {.range_m = 100.0, .noise_s = 1e-5}, random);
    test::count_at_20_mhz(arrivals);  // adds 14 ns to 10 us
    const Fix fix = localizer.locate({.arrivals = arrivals, .bearings = {}});
    ASSERT_TRUE(fix.ok()) << i << " " << to_string(fix.status);
    sum += test::nees(fix, truth);
    position2 += (fix.T_map_vehicle.translation_m - truth.translation_m).squaredNorm();
    stated2 += fix.covariance.topLeftCorner<2, 2>().trace();
    const Eigen::Matrix3d least = bound(d, truth, 343.7e-5);
    bound2 += least.topLeftCorner<2, 2>().trace();
    // No unbiased method is better than the bound; 1 % for the weights' own noise.
    EXPECT_GT(fix.covariance(2, 2), 0.99 * least(2, 2));
  }
  RecordProperty("nees", std::to_string(sum / kFixes / 3));
  RecordProperty("rmse_over_bound", std::to_string(std::sqrt(position2 / bound2)));
  RecordProperty("rmse_mm", std::to_string(1e3 * std::sqrt(position2 / kFixes)));
  // Two-sided at 0.1 %.
  EXPECT_GT(sum, test::chi2_quantile(0.0005, 3 * kFixes));
  EXPECT_LT(sum, test::chi2_quantile(0.9995, 3 * kFixes));
  // The position does not use the known distance between the ends, but the bound does; here that is worth 2 %
  // at most.
  EXPECT_LT(stated2, 1.04 * bound2);
}

TEST(HeadTail, FourTimesHalveTheSigma) {
  const Deployment d = floor_site();
  const Pose truth = Pose::planar(3, 2, 1);
  const Fix one = locate(d, arrivals_at(d, truth)), four = locate(d, arrivals_at(d, truth, 0.0, 4));
  EXPECT_NEAR(std::sqrt(one.covariance(0, 0) / four.covariance(0, 0)), 2.0, 1e-6);
  EXPECT_EQ(four.arrivals_used, 32);
}

TEST(HeadTail, TheOddTimeOfFourIsLeftOut) {
  const Deployment d = floor_site();
  const Pose truth = Pose::planar(3, 2, 1);
  auto arrivals = arrivals_at(d, truth, 0.0, 4);
  arrivals[11].tof_s += 8e-4;  // an echo, 27 cm late
  const Fix fix = locate(d, arrivals);
  expect_pose(fix, truth);
  EXPECT_EQ(fix.rejections[11], Rejection::kOutvoted);
  EXPECT_EQ(fix.arrivals_rejected, 1);
}

TEST(HeadTail, OneStationAgainstThreeIsOutvoted) {
  const Deployment d = floor_site();
  const Pose truth = Pose::planar(3, 2, 1);
  for (std::size_t shadowed = 0; shadowed < 4; ++shadowed) {
    auto arrivals = arrivals_at(d, truth);
    for (Arrival& a : arrivals)
      if (a.beacon.index() == shadowed) a.tof_s += 2e-3;
    const Fix fix = locate(d, arrivals);
    expect_pose(fix, truth);
    for (std::size_t i = 0; i < arrivals.size(); ++i)
      EXPECT_EQ(fix.rejections[i],
                arrivals[i].beacon.index() == shadowed ? Rejection::kOutvoted : Rejection::kUsed);
  }
}

TEST(HeadTail, WhereNothingIsKnownTheReasonIs) {
  const Deployment d = floor_site();
  const Pose truth = Pose::planar(3, 2, 1);
  const auto all = arrivals_at(d, truth);
  EXPECT_EQ(locate(d, {}).status, FixStatus::kTooFewArrivals);
  EXPECT_EQ(locate(d, {all[0]}).status, FixStatus::kTooFewArrivals);
  auto head_only = all;
  std::erase_if(head_only, [](const Arrival& a) { return a.receiver.index() == 1; });
  EXPECT_EQ(locate(d, head_only).status, FixStatus::kTooFewArrivals);
  auto echoes = all;
  for (std::size_t i = 0; i < echoes.size(); ++i)
    echoes[i].tof_s += 1e-3 * (1.0 + 0.7 * static_cast<double>((5 * i) % 8));
  EXPECT_EQ(locate(d, echoes).status, FixStatus::kNoConsensus);
  EXPECT_TRUE(locate(d, echoes).rejections.empty());
  auto no_numbers = all;
  for (Arrival& a : no_numbers) a.tof_s = std::nan("");
  EXPECT_EQ(locate(d, no_numbers).status, FixStatus::kTooFewArrivals);
  auto short_times = all;
  for (Arrival& a : short_times) a.tof_s *= 0.4;  // circles that do not meet
  EXPECT_NE(locate(d, short_times).status, FixStatus::kOk);
  const Deployment two = only(d, {0, 1});
  auto open = arrivals_at(two, truth);
  for (Arrival& a : open) a.tof_s += a.beacon.index() == 0 ? 0.1 : 0.0;
  EXPECT_EQ(locate(two, open).status, FixStatus::kNoConsensus) << "sides that make no triangle";
  const Pose on_line = Pose::planar(4, 0.15, 0.0);
  EXPECT_EQ(locate(two, arrivals_at(two, on_line)).status, FixStatus::kPoorGeometry) << "on the base line";
}

TEST(HeadTail, EndsAtAWrongDistanceAreNotBelieved) {
  // Stations agree at each end, but the vehicle is 5 cm longer than its description: ten sigma of the
  // measured length.
  const Deployment built = floor_site();
  Deployment described = built;
  described.receivers[0].position_m.x() -= 0.05;
  EXPECT_EQ(locate(described, arrivals_at(built, Pose::planar(3, 2, 1))).status, FixStatus::kNoConsensus);
}

TEST(HeadTail, StationsInOneLineLeaveTheMirrorImage) {
  const Deployment d = test::ranging_site({{0, 0, 1}, {4, 0, 1}, {8, 0, 1}}, {{0.3, 0, 1}, {-0.3, 0, 1}});
  const Pose truth = Pose::planar(3, 2, 1);
  EXPECT_EQ(locate(d, arrivals_at(d, truth)).status, FixStatus::kAmbiguous);
  expect_pose(locate(d, arrivals_at(d, truth), {.side = BaseLineSide::kLeft}), truth);
}

TEST(HeadTail, OfVeryManyStationsTheNearestAreUsed) {
  std::vector<Eigen::Vector3d> stations;
  for (int i = 0; i < 40; ++i)
    stations.emplace_back(10 * std::cos(i), 10 * std::sin(1.3 * i), 2.0 + 0.01 * i);
  const Deployment d = test::ranging_site(stations, {{0.35, 0, 0.4}, {-0.35, 0, 0.4}});
  const Pose truth = Pose::planar(1, 2, 0.5);
  const auto arrivals = arrivals_at(d, truth);
  const Fix fix = locate(d, arrivals);
  expect_pose(fix, truth);
  EXPECT_EQ(fix.arrivals_used, static_cast<int>(2 * HeadTail::kMaxStations));
  double used_m = 0.0, left_out_m = 1e9;  // of the head
  for (std::size_t i = 0; i < arrivals.size(); i += 2) {
    const double distance_m =
        (truth * d.receivers[0].position_m - d.beacons[arrivals[i].beacon.index()].position_m)
            .head<2>()
            .norm();
    if (fix.rejections[i] == Rejection::kUsed) {
      used_m = std::max(used_m, distance_m);
    } else {
      left_out_m = std::min(left_out_m, distance_m);
    }
  }
  EXPECT_LT(used_m, left_out_m);
}

TEST(HeadTail, CalibrationsUncertaintyIsInTheFix) {
  const Deployment exact = floor_site();
  Deployment rough = exact;
  for (auto& b : rough.beacons) b.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
  const Pose truth = Pose::planar(4, 3, 0.3);
  const Fix a = locate(exact, arrivals_at(exact, truth)), b = locate(rough, arrivals_at(rough, truth));
  // Both ends observe an equal displacement of a station, so it moves the vehicle and hardly rotates it: by
  // the ranges' share of a centimetre.
  EXPECT_GT(b.covariance(0, 0), a.covariance(0, 0) + 1e-5);
  EXPECT_LT(std::sqrt(b.covariance(2, 2)), 2 * std::sqrt(a.covariance(2, 2)));
  Deployment warm = exact;
  warm.speed_sigma_mps = 1.0;
  EXPECT_GT(locate(warm, arrivals_at(warm, Pose::planar(1, 1, 0))).covariance(0, 0), a.covariance(0, 0));
}

TEST(HeadTail, AllocatesNothing) {
  const Deployment d = floor_site();
  const auto arrivals = arrivals_at(d, Pose::planar(3, 2, 1), 1e-5, 4);
  HeadTail localizer(d);
  Fix fix = HeadTail(d).locate({.arrivals = arrivals, .bearings = {}});
  const std::size_t before = test::allocations();
  localizer.locate({.arrivals = arrivals, .bearings = {}}, fix);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_TRUE(fix.ok());
}

TEST(HeadTail, SaysWhatADeploymentLacks) {
  EXPECT_TRUE(head_tail_fits(floor_site()));
  const auto words = [](const Deployment& d) {
    const auto fits = head_tail_fits(d);
    return fits ? std::string() : fits.error().message();
  };
  EXPECT_NE(words(only(floor_site(), {2})).find("1 usable base stations"), std::string::npos);
  EXPECT_NE(
      words(test::ranging_site({{0, 0, 1}, {4, 0, 1}}, {{0, 0, 1}, {0, 0, 1}})).find("no vehicle has a head"),
      std::string::npos);
  Deployment d = floor_site();
  d.motion = Motion::kSpatial;
  EXPECT_NE(words(d).find("planar"), std::string::npos);
  d = floor_site();
  d.timing.clock = Clock::kCycleOffset;
  EXPECT_NE(words(d).find("synchronised"), std::string::npos);
}

}  // namespace head_tail_test
}  // namespace octant
