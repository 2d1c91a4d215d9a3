// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Bearings and scans of simulated worlds.
#include <cmath>

#include <gtest/gtest.h>

#include "models/simulator/synthetic.h"
#include "tests/models/localizers/walls.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"

namespace octant {
namespace synthetic_sensors_test {

using test::drive_scenario;
using test::hall_scenario;
using test::must;

Scenario with_sensors(Scenario s) {
  s.bearings = Scenario::Bearings{.range_m = 10.0, .unlabelled_fraction = 0.3};
  s.scans = Scenario::Scans{};
  s.walls_m = {{0, 0, 20, 0}, {20, 0, 20, 12}, {20, 12, 0, 12}, {0, 12, 0, 0}, {7, 0, 7, 5}};
  return s;
}

bool same(const std::vector<Arrival>& a, const std::vector<Arrival>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].time_s != b[i].time_s || a[i].tof_s != b[i].tof_s || a[i].beacon != b[i].beacon ||
        a[i].receiver != b[i].receiver)
      return false;
  return true;
}

/// Sensors have a random stream of their own: the rest of the world is the same to the last bit.
TEST(SyntheticSensors, LeaveTheRestOfTheWorldAlone) {
  for (const Scenario& s : {hall_scenario(), drive_scenario(20.0)}) {
    const World without = must(simulate(s, 7)), with = must(simulate(with_sensors(s), 7));
    EXPECT_TRUE(same(with.run.arrivals, without.run.arrivals));
    EXPECT_TRUE(same(with.heldout.arrivals, without.heldout.arrivals));
    ASSERT_EQ(with.run.odometry.size(), without.run.odometry.size());
    for (std::size_t i = 0; i < with.run.odometry.size(); ++i)
      EXPECT_EQ(with.run.odometry[i].dx_m, without.run.odometry[i].dx_m);
    EXPECT_TRUE(without.run.bearings.empty() && without.run.scans.empty());
    EXPECT_FALSE(with.run.bearings.empty() || with.run.scans.empty() || with.heldout.bearings.empty() ||
                 with.heldout.scans.empty());
  }
}

TEST(SyntheticSensors, BearingsAreThoseOfTheTruePoses) {
  Scenario s = with_sensors(hall_scenario());
  s.site.noise.bearing_sigma_rad = 0.004;
  const World world = must(simulate(s, 3));
  double sum = 0.0;
  int unlabelled = 0, named = 0;
  for (const Bearing& b : world.run.bearings) {
    if (!b.reflector.valid()) {
      ++unlabelled;
      continue;
    }
    ++named;
    const auto at = std::find_if(world.run.truth.begin(), world.run.truth.end(),
                                 [&](const TimedPose& t) { return t.time_s == b.time_s; });
    ASSERT_NE(at, world.run.truth.end());
    const Eigen::Vector3d v =
        at->T_map_vehicle.inverse() * world.truth.beacons[b.reflector.index()].position_m;
    EXPECT_LT(v.head<2>().norm(), 10.0);
    sum += std::pow(wrap_angle(b.bearing_rad - std::atan2(v.y(), v.x())) / 0.004, 2);
  }
  EXPECT_GT(sum, test::chi2_quantile(0.001, named));
  EXPECT_LT(sum, test::chi2_quantile(0.999, named));
  // Binomial, four sigma.
  const double n = named + unlabelled;
  EXPECT_NEAR(unlabelled, 0.3 * n, 4 * std::sqrt(0.21 * n));
}

TEST(SyntheticSensors, ScansSeeTheWalls) {
  Scenario s = with_sensors(drive_scenario(10.0));
  s.site.noise.range_sigma_m = 0.01;
  s.scans->range_max_m = 6.0;
  const World world = must(simulate(s, 3));
  ASSERT_EQ(world.run.scans.size(), 20u);  // every half second, short of the drive's end
  std::vector<test::Wall> walls;
  for (const auto& [x1, y1, x2, y2] : s.walls_m) walls.push_back({{x1, y1}, {x2, y2}});
  double sum = 0.0;
  int seen = 0;
  for (const Scan& scan : world.run.scans) {
    const auto at = std::find_if(world.run.truth.begin(), world.run.truth.end(),
                                 [&](const TimedPose& t) { return t.time_s == scan.time_s; });
    ASSERT_NE(at, world.run.truth.end());
    for (std::size_t k = 0; k < scan.range_m.size(); ++k) {
      const double angle = at->T_map_vehicle.heading_rad() + scan.angle_min_rad +
                           static_cast<double>(k) * scan.angle_increment_rad;
      const double truth = test::range_to(walls, at->T_map_vehicle.translation_m.head<2>(),
                                          {std::cos(angle), std::sin(angle)});
      EXPECT_EQ(std::isnan(scan.range_m[k]), truth >= 6.0);
      if (std::isnan(scan.range_m[k])) continue;
      ++seen;
      sum += std::pow((scan.range_m[k] - truth) / 0.01, 2);
    }
  }
  // Rounding to millimetres adds a variance of 1/12 mm^2 to 100 mm^2.
  sum /= 1 + 1.0 / 1200;
  EXPECT_GT(sum, test::chi2_quantile(0.001, seen));
  EXPECT_LT(sum, test::chi2_quantile(0.999, seen));
}

TEST(SyntheticSensors, ASiteWithoutTimesOfFlightHasNoArrivals) {
  Scenario s = with_sensors(hall_scenario());
  s.site.tof_sigma_given = false;
  EXPECT_TRUE(must(simulate(s, 1)).run.arrivals.empty());
  s = with_sensors(drive_scenario(5.0));
  s.site.beacons.clear();
  s.bearings.reset();
  const World world = must(simulate(s, 1));
  EXPECT_TRUE(world.run.arrivals.empty());
  EXPECT_FALSE(world.run.scans.empty());
}

TEST(SyntheticSensors, ContradictionsAreRefused) {
  const auto message = [](auto make) {
    Scenario s = with_sensors(hall_scenario());
    make(s);
    const auto world = simulate(s, 1);
    return world ? std::string("accepted") : world.error().message();
  };
  EXPECT_NE(message([](Scenario& s) { s.walls_m.clear(); }).find("walls_m"), std::string::npos);
  EXPECT_NE(message([](Scenario& s) {
              s.walls_m[0] = {1, 1, 1, 1};
            }).find("without length"),
            std::string::npos);
  EXPECT_NE(message([](Scenario& s) { s.bearings->unlabelled_fraction = 1.5; }).find("unlabelled_fraction"),
            std::string::npos);
  EXPECT_NE(message([](Scenario& s) { s.bearings->period_s = 0; }).find("period_s"), std::string::npos);
  EXPECT_NE(message([](Scenario& s) { s.scans->beams = 0; }).find("beams"), std::string::npos);
  EXPECT_NE(message([](Scenario& s) { s.site.motion = Motion::kSpatial; }).find("spatial"),
            std::string::npos);
}

}  // namespace synthetic_sensors_test
}  // namespace octant
