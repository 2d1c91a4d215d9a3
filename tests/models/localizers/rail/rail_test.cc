// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/rail/rail.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "models/localizers/rail/one_beacon.h"
#include "tests/models/localizers/ranging_support.h"
#include "tests/support/allocation_count.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"

namespace octant {
namespace rail_test {

using Point = Eigen::Vector2d;

constexpr std::uint64_t kSeed = 291;
/// Rounding of ranges and places of some tens of metres, magnified where a range hardly changes with the
/// place (a hundred times).
constexpr double kExact_m = 1e-9;

const Rail kStraight{.from_m = {1.0, 0.5}, .to_m = {39.0, 2.5}};
const Rail kArc{.shape = Rail::Shape::kArc, .centre_m = {6.0, 5.0}, .radius_m = 4.0};

Deployment on_rail(const Rail& rail, const std::vector<Eigen::Vector3d>& beacons,
                   const std::vector<Eigen::Vector3d>& receivers = {{0.25, 0.1, 0.5}, {-0.25, 0.1, 0.5}}) {
  Deployment d = test::ranging_site(beacons, receivers);
  d.vehicles[0].rail = rail;
  return d;
}

std::vector<Arrival> arrivals_at(const Deployment& d, double s_m, double noise_s = 0.0, double time_s = 0.0,
                                 double range_m = 100.0, std::uint64_t seed = kSeed) {
  std::mt19937_64 random(seed);
  return test::hear(d, rail_point(*d.vehicles[0].rail, s_m).T_map_vehicle,
                    {.range_m = range_m, .noise_s = noise_s}, random, 9, time_s);
}

Fix locate(RailLocalizer& localizer, const std::vector<Arrival>& arrivals) {
  const Fix fix = localizer.locate({.arrivals = arrivals, .bearings = {}});
  EXPECT_TRUE(test::has_no_nan(fix));
  return fix;
}

Fix locate(const Deployment& d, const std::vector<Arrival>& arrivals, RailOptions options = {}) {
  RailLocalizer localizer(d, options);
  return locate(localizer, arrivals);
}

void expect_at(const Fix& fix, const Rail& rail, double s_m) {
  ASSERT_TRUE(fix.ok()) << to_string(fix.status) << " at " << s_m;
  const Pose truth = rail_point(rail, s_m).T_map_vehicle;
  EXPECT_LT((fix.T_map_vehicle.translation_m - truth.translation_m).norm(), kExact_m) << s_m;
  EXPECT_LT(std::abs(wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad())), kExact_m) << s_m;
}

std::vector<Eigen::Vector3d> wall_beacons() {
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < 10; ++i) out.emplace_back(2.0 + 4.0 * i, i % 2 == 0 ? -2.0 : 5.0, 2.0 + 0.05 * i);
  return out;
}

TEST(Rail, IsExactAlongAStraightRailWithTenBeacons) {
  const Deployment d = on_rail(kStraight, wall_beacons());
  for (double s = 0; s < 38; s += 0.17) expect_at(locate(d, arrivals_at(d, s, 0.0, 0.0, 6.0)), kStraight, s);
}

TEST(Rail, TwoReceiversTellTheSideOfASingleBeacon) {
  for (const Rail& rail : {kStraight, kArc}) {
    const Deployment d = on_rail(rail, {{9.0, 7.5, 2.0}});
    for (double s = -11; s < 12; s += 0.23) {
      if (rail.shape == Rail::Shape::kStraight && s < 0) continue;
      const Fix fix = locate(d, arrivals_at(d, s));
      if (fix.status == FixStatus::kAmbiguous || fix.status == FixStatus::kPoorGeometry)
        continue;  // abreast; counted below
      expect_at(fix, rail, s);
    }
  }
  // Half a metre apart and 3.4 mm a range, abreast of a beacon 6 m away: both places merge into one within
  // 0.2 m.
  const Deployment d = on_rail(kStraight, {{9.0, 7.5, 2.0}});
  int without = 0;
  for (double s = 0; s < 38; s += 0.1) without += locate(d, arrivals_at(d, s)).ok() ? 0 : 1;
  EXPECT_LE(without, 10);
}

TEST(Rail, OneReceiverLeavesTwoPlacesUnlessTheLastPositionTells) {
  const Deployment d = on_rail(kStraight, {{9.0, 7.5, 2.0}, {15.0, 7.0, 2.0}}, {{0.0, 0.0, 0.5}});
  RailLocalizer localizer(d);
  auto both = arrivals_at(d, 5.0);
  const std::vector<Arrival> one(both.begin(), both.begin() + 1);
  EXPECT_EQ(locate(localizer, one).status, FixStatus::kAmbiguous);
  expect_at(locate(localizer, both), kStraight, 5.0);
  expect_at(locate(localizer, one), kStraight, 5.0);
  auto later = arrivals_at(d, 5.6, 0.0, 1.0);
  later.resize(1);
  expect_at(locate(localizer, later), kStraight, 5.6);
  auto much_later = arrivals_at(d, 5.6, 0.0, 100.0);
  much_later.resize(1);
  EXPECT_EQ(locate(localizer, much_later).status, FixStatus::kAmbiguous)
      << "it may have gone past the beacon";
}

TEST(Rail, IsExactOnAnArc) {
  const Deployment d = on_rail(kArc, {{10.5, 9.0, 2.0}, {1.0, 1.0, 2.2}, {11.0, 0.5, 1.9}});
  for (double s = -12.5; s < 12.5; s += 0.11) expect_at(locate(d, arrivals_at(d, s)), kArc, s);
}

TEST(Rail, CovarianceIsThatOfNumericDerivatives) {
  for (const Rail& rail : {kStraight, kArc}) {
    const Deployment d = on_rail(rail, {{9.0, 7.5, 2.0}, {3.0, -2.0, 1.8}});
    RailLocalizer localizer(d, {.rail_sigma_m = 0.0, .heading_sigma_rad = 0.0});
    for (double s = 0.5; s < 12; s += 0.7) {
      const auto arrivals = arrivals_at(d, s);
      localizer.forget();
      const Fix fix = locate(localizer, arrivals);
      ASSERT_TRUE(fix.ok());
      const Eigen::Matrix3d numeric = test::numeric_covariance(localizer, arrivals, 1e-5);
      EXPECT_LT((Eigen::Matrix3d(fix.covariance) - numeric).norm(), 1e-4 * numeric.norm()) << s;
    }
  }
}

TEST(Rail, NoiseAndSwayStayWithinWhatIsStated) {
  const Deployment d = on_rail(kStraight, wall_beacons());
  RailLocalizer localizer(d, {.rail_sigma_m = 0.01, .heading_sigma_rad = 0.005});
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> s(0.0, 38.0);
  std::normal_distribution<double> normal;
  constexpr int kFixes = 1500;
  double sum = 0.0;
  for (int i = 0; i < kFixes; ++i) {
    const Pose ideal = rail_point(kStraight, s(random)).T_map_vehicle;
    const Pose truth = ideal * Pose::planar(0, 0.01 * normal(random), 0.005 * normal(random));
    const auto arrivals = test::hear(d, truth, {.range_m = 6.0, .noise_s = 1e-5}, random);
    localizer.forget();
    const Fix fix = locate(localizer, arrivals);
    ASSERT_TRUE(fix.ok()) << i << " " << to_string(fix.status);
    sum += test::nees(fix, truth);
  }
  RecordProperty("nees", std::to_string(sum / kFixes / 3));
  // Two-sided at 0.1 %.
  EXPECT_GT(sum, test::chi2_quantile(0.0005, 3 * kFixes));
  EXPECT_LT(sum, test::chi2_quantile(0.9995, 3 * kFixes));
}

TEST(Rail, EchoesAreLeftOutAsLate) {
  const Deployment d = on_rail(kStraight, wall_beacons());
  for (double s = 3; s < 35; s += 1.3) {
    auto arrivals = arrivals_at(d, s, 0.0, 0.0, 8.0);
    ASSERT_GE(arrivals.size(), 6u);
    for (Arrival& a : arrivals)
      if (a.beacon == arrivals[0].beacon) a.tof_s += 2e-3;
    const Fix fix = locate(d, arrivals);
    expect_at(fix, kStraight, s);
    EXPECT_EQ(fix.rejections[0], Rejection::kLate);
    const auto echoes = std::count_if(arrivals.begin(), arrivals.end(),
                                      [&](const Arrival& a) { return a.beacon == arrivals[0].beacon; });
    EXPECT_EQ(fix.arrivals_rejected, echoes);
  }
}

TEST(Rail, ABeaconHeardLateByBothIsNotBelievedAgainstTheLastPosition) {
  const Deployment d = on_rail(kStraight, {{9.0, 7.5, 2.0}});
  RailLocalizer localizer(d, {.max_speed_mps = 0.1});
  expect_at(locate(localizer, arrivals_at(d, 15.0)), kStraight, 15.0);
  auto shadowed = arrivals_at(d, 15.1, 0.0, 1.0);
  for (Arrival& a : shadowed) a.tof_s += 0.9e-3;  // 0.3 m of detour: 0.4 m along the rail
  EXPECT_EQ(locate(localizer, shadowed).status, FixStatus::kNoConsensus);
  expect_at(locate(localizer, arrivals_at(d, 15.2, 0.0, 2.0)), kStraight, 15.2);
  localizer.forget();
  const Fix alone = locate(localizer, shadowed);
  EXPECT_TRUE(alone.ok()) << to_string(alone.status) << ": alone it looks like any other place";
}

TEST(Rail, OfTwoBeaconsTheLateOneIsLeftOut) {
  // Either could be right, but if the late one were, the other would be early; echoes are late.
  const Deployment d = on_rail(kStraight, {{9.0, 7.5, 2.0}, {11.0, 7.0, 2.0}});
  auto arrivals = arrivals_at(d, 20.0);
  for (Arrival& a : arrivals)
    if (a.beacon.index() == 1) a.tof_s += 3e-3;
  const Fix fix = locate(d, arrivals);
  expect_at(fix, kStraight, 20.0);
  EXPECT_EQ(std::count(fix.rejections.begin(), fix.rejections.end(), Rejection::kLate), 2);
}

TEST(Rail, OfTwoRangesTheOneThatWouldBeEarlyIsRight) {
  // One receiver, so that one range contradicts another; both positions are within reach of the last.
  const Deployment d = on_rail(kStraight, {{1.5, 3.0, 2.0}, {2.5, 3.2, 2.0}}, {{0.0, 0.0, 0.5}});
  RailLocalizer localizer(d);
  expect_at(locate(localizer, arrivals_at(d, 19.9)), kStraight, 19.9);
  auto arrivals = arrivals_at(d, 20.0, 0.0, 1.0);
  arrivals[1].tof_s += 1e-3;
  const Fix fix = locate(localizer, arrivals);
  expect_at(fix, kStraight, 20.0);
  EXPECT_EQ(fix.rejections[1], Rejection::kLate);
}

TEST(Rail, AShadowedBeaconPaysOnce) {
  // A behind is late at both receivers, B ahead is received by one: two ranges do not outvote one, because
  // they share an obstacle.
  const Deployment d = on_rail(kStraight, {{1.5, 3.0, 2.0}, {38.5, 5.0, 2.0}});
  auto arrivals = arrivals_at(d, 20.0);
  ASSERT_EQ(arrivals.size(), 4u);
  arrivals.pop_back();
  for (std::size_t i = 0; i < 2; ++i) arrivals[i].tof_s += 1.5e-3;
  EXPECT_EQ(locate(d, arrivals).status, FixStatus::kAmbiguous);
}

TEST(Rail, AMinorityIsNoConsensus) {
  const Deployment d = on_rail(kStraight, {{1.5, 3.0, 2.0}, {2.0, 3.5, 2.0}, {2.5, 3.2, 2.0}});
  auto arrivals = arrivals_at(d, 20.0);
  for (std::size_t i = 2; i < 6; ++i) arrivals[i].tof_s += 4e-3 * static_cast<double>(i * i);
  EXPECT_EQ(locate(d, arrivals).status, FixStatus::kNoConsensus);
}

TEST(Rail, TwoBeaconsThatAgreeOverruleTheLastPosition) {
  const Deployment d = on_rail(kStraight, {{9.0, 7.5, 2.0}, {15.0, 7.0, 2.0}});
  RailLocalizer localizer(d, {.max_speed_mps = 0.5});
  expect_at(locate(localizer, arrivals_at(d, 5.0)), kStraight, 5.0);
  expect_at(locate(localizer, arrivals_at(d, 20.0, 0.0, 1.0)), kStraight, 20.0);
}

TEST(Rail, WhereNothingIsKnownTheReasonIs) {
  const Deployment d = on_rail(kStraight, {{9.0, 7.5, 2.0}, {20.0, 7.0, 2.0}});
  EXPECT_EQ(locate(d, {}).status, FixStatus::kTooFewArrivals);
  const auto all = arrivals_at(d, 5.0);
  EXPECT_EQ(locate(d, {all[0]}).status, FixStatus::kAmbiguous);
  const Deployment end = on_rail(kStraight, {{-1.0, 0.4, 2.0}});
  EXPECT_EQ(locate(end, {arrivals_at(end, 5.0)[0]}).status, FixStatus::kTooFewArrivals)
      << "one place, and nothing to confirm it";
  auto echoes = all;
  for (std::size_t i = 0; i < echoes.size(); ++i) echoes[i].tof_s += 4e-3 * static_cast<double>(1 + i * i);
  EXPECT_FALSE(locate(d, echoes).ok());
  auto too_short = all;
  for (Arrival& a : too_short) a.tof_s = 0.01;
  EXPECT_EQ(locate(d, too_short).status, FixStatus::kNoConsensus);
  const Deployment one = on_rail(kStraight, {{9.0, 7.5, 2.0}}, {{0, 0, 0.5}});
  const Eigen::Vector2d along = (kStraight.to_m - kStraight.from_m).normalized();
  const double abreast_m = along.dot(Point(9.0, 7.5) - kStraight.from_m);
  EXPECT_EQ(locate(one, arrivals_at(one, abreast_m)).status, FixStatus::kPoorGeometry);
  const Deployment centre = on_rail(kArc, {{6.0, 5.0, 2.0}});
  EXPECT_EQ(locate(centre, arrivals_at(centre, 1.0)).status, FixStatus::kNoConsensus);
  Deployment no_rail = d;
  no_rail.vehicles[0].rail.reset();
  EXPECT_EQ(locate(no_rail, all).status, FixStatus::kTooFewArrivals);
}

TEST(Rail, AllocatesNothing) {
  const Deployment d = on_rail(kArc, {{10.5, 9.0, 2.0}, {1.0, 1.0, 2.2}, {11.0, 0.5, 1.9}});
  RailLocalizer localizer(d);
  const auto first = arrivals_at(d, 1.0, 1e-5), second = arrivals_at(d, 1.2, 1e-5, 0.5);
  Fix fix = RailLocalizer(d).locate({.arrivals = first, .bearings = {}});
  const std::size_t before = test::allocations();
  localizer.locate({.arrivals = first, .bearings = {}}, fix);
  localizer.locate({.arrivals = second, .bearings = {}}, fix);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_TRUE(fix.ok());
}

TEST(Rail, SaysWhatADeploymentLacks) {
  const auto words = [](const Deployment& d) {
    const auto fits = rail_fits(d);
    return fits ? std::string() : fits.error().message();
  };
  Deployment d = on_rail(kStraight, wall_beacons());
  EXPECT_EQ(words(d), "");
  d.vehicles[0].rail = Rail{};
  EXPECT_NE(words(d).find("has a rail"), std::string::npos) << "a rail without length is none";
  EXPECT_NE(words(on_rail(kStraight, {})).find("no usable beacon"), std::string::npos);
}

/// The paper's greenhouse: 40 m, ten beacons on walls or beams, receivers on both sides of the robot's
/// middle.
Scenario greenhouse() {
  Scenario s;
  s.site.name = "greenhouse";
  s.site.medium = {.model = MediumModel::kLinearTemperature, .temperature_degC = 24.0};
  s.site.noise.tof_sigma_s = 2e-5;
  s.site.timing.delay_per.beacon = true;
  s.site.timing.delay_s = 1e-4;
  s.site.timing.delay_sigma_s = 2e-5;
  for (int i = 0; i < 10; ++i) {
    std::string name = "B";
    name += std::to_string(i);
    s.site.beacons.push_back(test::beacon(name, {2.0 + 4.0 * i, 3.0, 1.6}, 0.0));
  }
  test::add_receivers(s.site, {{-0.25, 0.0, 1.4}, {0.25, 0.0, 1.4}});
  s.site.vehicles[0].rail = Rail{.from_m = {0, 0}, .to_m = {40, 0}};
  s.hall_m = {40, 6};
  s.range_m = 5.0;
  s.path.kind = PathKind::kWaypoints;
  s.path.waypoints_m = {{0, 0}, {40, 0}};
  s.path.epochs = 201;
  s.path.epoch_period_s = 1.0;
  s.heldout_path = s.path;
  return s;
}

/// Figure 7: along the whole rail no serious fault; the paper's larger errors are where one beacon's range
/// ends.
TEST(Figure7, NoGrossFaultAlongTheGreenhouse) {
  const World world = test::must(simulate(greenhouse(), 5));
  RailLocalizer rail(world.truth, {.max_speed_mps = 0.5});
  OneBeacon one(world.truth);
  for (Localizer* localizer : {static_cast<Localizer*>(&rail), static_cast<Localizer*>(&one)}) {
    const std::string name = localizer == &rail ? "rail" : "one_beacon";
    double sum2 = 0.0, worst_m = 0.0, z2 = 0.0;
    int fixes = 0;
    std::size_t begin = 0;
    for (int k = 0; k < 201; ++k) {
      std::size_t end = begin;
      while (end < world.heldout.arrivals.size() && world.heldout.arrivals[end].epoch == k) ++end;
      const Fix fix = localizer->locate(
          {.arrivals = std::span(world.heldout.arrivals).subspan(begin, end - begin), .bearings = {}});
      begin = end;
      ASSERT_TRUE(fix.ok()) << k << " " << to_string(fix.status);
      const double error_m = fix.T_map_vehicle.translation_m.x() - 0.2 * k;
      sum2 += error_m * error_m;
      worst_m = std::max(worst_m, std::abs(error_m));
      z2 += error_m * error_m / fix.covariance(0, 0);
      // One of 201 beyond its sigma by so much comes by chance once in a thousand runs.
      EXPECT_LT(error_m * error_m / fix.covariance(0, 0), test::chi2_quantile(1 - 1e-3 / 201, 1))
          << name << " " << k;
      ++fixes;
    }
    RecordProperty(name + "_rmse_mm", std::to_string(1e3 * std::sqrt(sum2 / fixes)));
    RecordProperty(name + "_worst_mm", std::to_string(1e3 * worst_m));
    RecordProperty(name + "_nees", std::to_string(z2 / fixes));
    EXPECT_LT(z2, test::chi2_quantile(0.9995, fixes)) << name;
    EXPECT_LT(worst_m, 0.5)
        << name << ": a gross fault would be a wrong side or a wrong beacon, half a metre or more";
  }
}

}  // namespace rail_test
}  // namespace octant
