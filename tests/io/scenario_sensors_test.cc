// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Bearings, scans and walls of a scenario file, and the bundled worlds that have them.
#include <string>

#include <gtest/gtest.h>

#include "io/site/scenario_yaml.h"
#include "models/simulator/synthetic.h"
#include "tests/support/worlds.h"

namespace octant::io {
namespace scenario_sensors_test {

using octant::test::must;

TEST(ScenarioSensors, EveryKeyIsRead) {
  const std::string text = R"(octant_scenario: 1
site:
  octant_site: 1
  name: s
  motion: planar
  noise: {bearing_sigma_rad: 0.003, range_sigma_m: 0.015}
  beacons: [{id: L1, position_m: [1, 2, 0], sigma_m: 0}]
  vehicles: [{id: v, receivers: [{id: l, position_m: [0, 0, 0], sigma_m: 0}]}]
bearings: {range_m: 25.0, unlabelled_fraction: 0.25, period_s: 0.2}
scans: {period_s: 0.1, angle_min_rad: -2.0, angle_increment_rad: 0.01, beams: 401, range_max_m: 12.0}
walls_m: [[0, 0, 5, 0], [5, 0, 5, 3]]
)";
  const Scenario s = must(scenario_from_yaml(text, "s.yaml"));
  EXPECT_TRUE(s.warnings.empty()) << s.warnings.front();
  ASSERT_TRUE(s.bearings && s.scans);
  EXPECT_EQ(s.bearings->range_m, 25.0);
  EXPECT_EQ(s.bearings->unlabelled_fraction, 0.25);
  EXPECT_EQ(s.bearings->period_s, 0.2);
  EXPECT_EQ(s.scans->period_s, 0.1);
  EXPECT_EQ(s.scans->angle_min_rad, -2.0);
  EXPECT_EQ(s.scans->angle_increment_rad, 0.01);
  EXPECT_EQ(s.scans->beams, 401);
  EXPECT_EQ(s.scans->range_max_m, 12.0);
  ASSERT_EQ(s.walls_m.size(), 2u);
  EXPECT_EQ(s.walls_m[1], (std::array<double, 4>{5, 0, 5, 3}));
  EXPECT_EQ(s.site.noise.bearing_sigma_rad, 0.003);
  EXPECT_FALSE(scenario_from_yaml(text + "nonsense: [", "s.yaml"));
  EXPECT_FALSE(scenario_from_yaml(text.substr(0, text.find("walls_m")) + "walls_m: [[0, 0, 5]]\n", "s.yaml"));
  EXPECT_FALSE(scenario_from_yaml(text.substr(0, text.find("walls_m")), "s.yaml"));  // scans without walls
}

TEST(ScenarioSensors, BundledWorldsAreSimulated) {
  for (const std::string name : {"binaural", "reflectors", "driveway"}) {
    const Scenario s =
        must(read_scenario(std::string(OCTANT_SOURCE_DIR) + "/datasets/" + name + "/scenario.yaml"));
    const World world = must(simulate(s, 1));
    EXPECT_EQ(world.heldout.arrivals.empty(), name != "binaural") << name;
    EXPECT_EQ(world.heldout.bearings.empty(), name != "reflectors") << name;
    EXPECT_EQ(world.heldout.scans.empty(), name != "driveway") << name;
  }
}

}  // namespace scenario_sensors_test
}  // namespace octant::io
