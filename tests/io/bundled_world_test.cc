// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The committed files of datasets/hall are what simulate() makes of its scenario with seed 1.
#include <string>

#include <gtest/gtest.h>

#include "io/deployment/deployment_json.h"
#include "io/run/run_folder.h"
#include "io/site/scenario_yaml.h"
#include "io/site/site_yaml.h"
#include "tests/support/worlds.h"

namespace octant::io {
namespace bundled_world_test {

using octant::test::must;

const std::string kHall = std::string(OCTANT_SOURCE_DIR) + "/datasets/hall";

class BundledWorld : public testing::Test {
 protected:
  World world = must(simulate(must(read_scenario(kHall + "/scenario.yaml")), 1));
};

TEST_F(BundledWorld, SiteFile) {
  const Site site = must(read_site(kHall + "/site.yaml"));
  EXPECT_TRUE(site.warnings.empty()) << site.warnings[0];
  ASSERT_EQ(site.beacons.size(), 8u);
  for (std::size_t b = 0; b < 8; ++b) {
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(*site.beacons[b].position_m[i], *world.site.beacons[b].position_m[i], 1e-9);
    EXPECT_EQ(site.beacons[b].is_control_point(), b % 3 == 0);
  }
}

TEST_F(BundledWorld, Recordings) {
  for (const auto& [folder, simulated] :
       {std::pair("/run", &world.run), std::pair("/heldout", &world.heldout)}) {
    const MeasurementLog log =
        must(read_run(kHall + folder, names_of(world.site), world.site.timing, {.read_truth = true}));
    EXPECT_TRUE(log.warnings.empty() && log.rejected.empty());
    ASSERT_EQ(log.arrivals.size(), simulated->arrivals.size());
    ASSERT_EQ(log.truth.size(), simulated->truth.size());
    EXPECT_EQ(log.truth_accuracy.position_sigma_m, 0.0);
    for (std::size_t i = 0; i < log.arrivals.size(); ++i) {
      const Arrival &read = log.arrivals[i], &made = simulated->arrivals[i];
      EXPECT_EQ(read.line, made.line);
      EXPECT_EQ(read.beacon, made.beacon);
      EXPECT_EQ(read.receiver, made.receiver);
      EXPECT_EQ(read.epoch, made.epoch);
      EXPECT_NEAR(read.tof_s, made.tof_s, 1.1e-8);  // another mathematics library may round to the next count
      EXPECT_NEAR(read.time_s, made.time_s, 1.1e-6);
    }
  }
}

TEST_F(BundledWorld, Truth) {
  const Deployment truth = must(read_deployment(kHall + "/deployment.true.json"));
  EXPECT_NEAR(truth.speed_mps(21.0), world.truth.speed_mps(21.0), 1e-9);
  ASSERT_EQ(truth.beacons.size(), 8u);
  for (std::size_t b = 0; b < 8; ++b) {
    EXPECT_EQ(truth.beacons[b].position_m, world.truth.beacons[b].position_m);
    EXPECT_NEAR(truth.beacons[b].delay_s, world.truth.beacons[b].delay_s, 1e-15);
  }
}

}  // namespace bundled_world_test
}  // namespace octant::io
