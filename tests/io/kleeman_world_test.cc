// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The headings in the worlds of datasets/kleeman are as its README states: of the run that ships, and of 2000 stops anywhere.
#include <cmath>
#include <iostream>

#include "io/scenario_yaml.h"
#include "models/localizers/kleeman.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace {

Scenario scenario(const std::string& file) {
  const auto read = read_scenario(std::string(OCTANT_SOURCE_DIR) + "/datasets/kleeman/" + file);
  EXPECT_TRUE(read) << file;
  EXPECT_THAT(read->warnings, testing::IsEmpty());
  return *read;
}

/// The same room with more stops: what a share of 99 % takes.
Scenario anywhere(const std::string& file) {
  Scenario s = scenario(file);
  s.heldout_path = s.path;
  s.heldout_path.epochs = 2000;
  return s;
}

/// Errors in degrees.
struct Tally {
  int fixes = 0, none = 0;
  double rms = 0.0, within_1 = 0.0, within_10 = 0.0, worst = 0.0;
};

Tally headings(const Scenario& s, KleemanHeading heading) {
  const World world = simulate(s, 1).value();
  Kleeman kleeman(world.truth, {.heading = heading});
  const std::span<const Arrival> all = world.heldout.arrivals;
  Tally t;
  std::size_t truth = 0;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].epoch == all[begin].epoch) ++end;
    const Fix fix = kleeman.locate(Observations{all.subspan(begin, end - begin), {}});
    if (!fix.ok()) {
      ++t.none;
      continue;
    }
    while (truth + 1 < world.heldout.truth.size() && world.heldout.truth[truth + 1].time_s <= fix.time_s) ++truth;
    const double true_rad = world.heldout.truth[truth].T_map_vehicle.heading_rad();
    const double degrees = std::abs(wrap_angle(fix.T_map_vehicle.heading_rad() - true_rad)) * 180 / M_PI;
    ++t.fixes;
    t.rms += degrees * degrees;
    t.within_1 += degrees <= 1;
    t.within_10 += degrees <= 10;
    t.worst = std::max(t.worst, degrees);
  }
  t.rms = std::sqrt(t.rms / t.fixes);
  t.within_1 /= t.fixes;
  t.within_10 /= t.fixes;
  std::cout << s.site.name << ": " << t.fixes << " of " << t.fixes + t.none << ", rms " << t.rms
            << ", within 1: " << 100 * t.within_1 << " %, within 10: " << 100 * t.within_10 << " %, worst " << t.worst << "\n";
  return t;
}

/// One arrival in ten is an echo in both worlds; hearing does not depend on the noise of the times.
TEST(KleemanWorld, HeadingFromHearing) {
  for (const char* file : {"scenario.yaml", "clock.yaml"}) {
    const Scenario room = anywhere(file);
    const Tally published = headings(room, KleemanHeading::kMeanAxes), sectors = headings(room, KleemanHeading::kHearing);
    EXPECT_GE(sectors.fixes, 1900);
    EXPECT_LT(sectors.rms, 4.0);
    EXPECT_LT(sectors.rms, 0.85 * published.rms);
    EXPECT_GE(sectors.within_10, 0.983);
    EXPECT_GE(sectors.within_10, published.within_10 + 0.02);
    EXPECT_LT(sectors.worst, 15.0);
    EXPECT_GE(headings(scenario(file), KleemanHeading::kHearing).within_10, 0.97);
  }
}

TEST(KleemanWorld, InterpolatedHeadingAtTenMicroseconds) {
  const Tally t = headings(anywhere("scenario.yaml"), KleemanHeading::kInterpolation);
  EXPECT_GE(t.fixes, 1900);
  EXPECT_LT(t.rms, 1.56);
  EXPECT_EQ(t.within_10, 1.0);
}

TEST(KleemanWorld, InterpolatedHeadingIsWithinADegreeAtTheTimersResolution) {
  const Tally run = headings(scenario("clock.yaml"), KleemanHeading::kInterpolation);
  EXPECT_GE(run.fixes, 190);
  EXPECT_LT(run.rms, 0.36);
  EXPECT_GE(run.within_1, 0.985);
  EXPECT_LT(run.worst, 1.15);
  const Tally room = headings(anywhere("clock.yaml"), KleemanHeading::kInterpolation);
  EXPECT_GE(room.fixes, 1900);
  EXPECT_LT(room.rms, 0.39);
  EXPECT_GE(room.within_1, 0.99);
  EXPECT_LT(room.worst, 1.6);
}

/// The two files differ in their noise alone: the same arrivals, within it.
TEST(KleemanWorld, TheClockIsAllThatDiffers) {
  const Scenario ten = scenario("scenario.yaml"), clock = scenario("clock.yaml");
  EXPECT_EQ(ten.site.noise.tof_sigma_s, 1.0e-5);
  EXPECT_EQ(clock.site.noise.tof_sigma_s, 2.5e-6);
  const World a = simulate(ten, 1).value(), b = simulate(clock, 1).value();
  ASSERT_EQ(a.heldout.arrivals.size(), b.heldout.arrivals.size());
  for (std::size_t i = 0; i < a.heldout.arrivals.size(); ++i) {
    EXPECT_EQ(a.heldout.arrivals[i].receiver, b.heldout.arrivals[i].receiver) << i;
    EXPECT_NEAR(a.heldout.arrivals[i].tof_s, b.heldout.arrivals[i].tof_s, 5 * 7.5e-6) << i;
  }
}

}  // namespace
}  // namespace octant::io
