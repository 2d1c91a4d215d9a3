// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The worlds of datasets/head_tail and datasets/greenhouse give the figures that their READMEs state.
#include <cmath>

#include "io/site/scenario_yaml.h"
#include "models/localizers/head_tail/head_tail.h"
#include "models/localizers/rail/one_beacon.h"
#include "models/localizers/rail/rail.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace ranging_worlds_test {

World world(const std::string& file) {
  const auto scenario = read_scenario(std::string(OCTANT_SOURCE_DIR) + "/datasets/" + file);
  EXPECT_TRUE(scenario) << scenario.error().message();
  EXPECT_THAT(scenario->warnings, testing::IsEmpty());
  return simulate(*scenario, 1).value();
}

struct Tally {
  int fixes = 0, none = 0;
  double rmse_m = 0.0, worst_m = 0.0;
};

Tally run(Localizer& localizer, const MeasurementLog& log) {
  Tally out;
  Fix fix;
  const std::span<const Arrival> all = log.arrivals;
  std::size_t truth = 0;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].epoch == all[begin].epoch) ++end;
    localizer.locate({.arrivals = all.subspan(begin, end - begin), .bearings = {}}, fix);
    if (!fix.ok()) {
      ++out.none;
      continue;
    }
    while (truth + 1 < log.truth.size() && log.truth[truth + 1].time_s <= fix.time_s) ++truth;
    const double error_m =
        (fix.T_map_vehicle.translation_m - log.truth[truth].T_map_vehicle.translation_m).norm();
    ++out.fixes;
    out.rmse_m += error_m * error_m;
    out.worst_m = std::max(out.worst_m, error_m);
  }
  out.rmse_m = std::sqrt(out.rmse_m / out.fixes);
  return out;
}

TEST(RangingWorlds, HeadAndTail) {
  const World w = world("head_tail/scenario.yaml");
  ASSERT_TRUE(head_tail_fits(w.truth));
  HeadTail localizer(w.truth);
  const Tally result = run(localizer, w.heldout);
  EXPECT_EQ(result.fixes, 40);
  EXPECT_LT(result.rmse_m, 0.00135);  // 1.3 mm
  EXPECT_LT(result.worst_m, 0.00275);
}

TEST(RangingWorlds, GreenhouseFigure7) {
  const World w = world("greenhouse/scenario.yaml");
  ASSERT_TRUE(rail_fits(w.truth));
  ASSERT_TRUE(one_beacon_fits(w.truth));
  RailLocalizer rail(w.truth);
  const Tally straight = run(rail, w.heldout);
  EXPECT_GE(straight.fixes, 198);
  EXPECT_LT(straight.rmse_m, 0.0052);
  EXPECT_LT(straight.worst_m, 0.0175) << "no gross fault";
  OneBeacon one(w.truth);
  const Tally single = run(one, w.heldout);
  EXPECT_GE(single.fixes, 195);
  EXPECT_LT(single.rmse_m, 0.0305);
  Deployment uncompensated = w.truth;
  uncompensated.attenuation.reset();
  RailLocalizer without(uncompensated);
  EXPECT_GT(run(without, w.heldout).rmse_m, 5 * straight.rmse_m) << "time-walk left in";
}

TEST(RangingWorlds, GreenhouseArc) {
  const World w = world("greenhouse/arc.yaml");
  const Rail& rail = w.truth.vehicles[0].rail.value();
  for (const TimedPose& at : w.heldout.truth) {
    const Eigen::Vector2d off = at.T_map_vehicle.translation_m.head<2>() - rail.centre_m;
    // Waypoints are written to nine decimals.
    EXPECT_NEAR(off.norm(), rail.radius_m, 1e-8);
    EXPECT_NEAR(wrap_angle(at.T_map_vehicle.heading_rad() - std::atan2(off.y(), off.x())), M_PI / 2, 1e-7);
  }
  RailLocalizer exact(w.truth);
  const Tally a = run(exact, w.heldout);
  EXPECT_EQ(a.fixes, 90);
  EXPECT_LT(a.rmse_m, 0.00475);
}

}  // namespace ranging_worlds_test
}  // namespace octant::io
