// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Scenarios that contradict themselves.
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "models/simulator/synthetic.h"
#include "tests/support/worlds.h"

namespace octant {
namespace synthetic_check_test {

using test::hall_scenario;

struct Contradiction {
  const char* name;
  void (*make)(Scenario&);
  const char* named;
};

/// As ctest names it.
void PrintTo(const Contradiction& one, std::ostream* out) { *out << one.name; }

class SyntheticContradiction : public testing::TestWithParam<Contradiction> {};

TEST_P(SyntheticContradiction, IsRefusedByName) {
  Scenario s = hall_scenario();
  GetParam().make(s);
  const auto world = simulate(s, 1);
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().code, Errc::kBadInput);
  EXPECT_NE(world.error().message().find(GetParam().named), std::string::npos) << world.error().message();
}

INSTANTIATE_TEST_SUITE_P(
    All, SyntheticContradiction,
    testing::Values(
        Contradiction{"no_vehicle", [](Scenario& s) { s.site.vehicles.clear(); }, "vehicle"},
        Contradiction{"no_place", [](Scenario& s) { s.site.beacons[2].position_m[1].reset(); }, "B2"},
        Contradiction{"amplitude", [](Scenario& s) { s.log_amplitude = true; }, "attenuation"},
        Contradiction{"constant_warms",
                      [](Scenario& s) { s.warming_degC = 3, s.site.medium.model = MediumModel::kConstant; },
                      "warming_degC"},
        Contradiction{"echoes", [](Scenario& s) { s.echo_fraction = 1.5; }, "echo_fraction"},
        Contradiction{"echo_delay",
                      [](Scenario& s) {
                        s.echo_delay_s = {2e-3, 1e-3};
                      },
                      "echo_delay_s"},
        Contradiction{"no_hall", [](Scenario& s) { s.hall_m[0] = 0; }, "hall_m"},
        Contradiction{"no_epochs", [](Scenario& s) { s.path.epochs = 0; }, "path"},
        Contradiction{"crowded", [](Scenario& s) { s.path.epoch_period_s = 0.3; }, "epoch_period_s"},
        Contradiction{"no_waypoints", [](Scenario& s) { s.heldout_path.kind = PathKind::kWaypoints; },
                      "heldout_path"},
        Contradiction{"no_stations", [](Scenario& s) { s.path.kind = PathKind::kStations; }, "stations"},
        Contradiction{"same_waypoints",
                      [](Scenario& s) {
                        s.path.waypoints_m = {{1, 1}, {1, 1}};
                      },
                      "waypoints_m"},
        Contradiction{
            "drive_in_cycles",
            [](Scenario& s) { s.path.kind = PathKind::kDrive, s.site.timing.clock = Clock::kCycleOffset; },
            "epochs"},
        Contradiction{"standing_drive",
                      [](Scenario& s) { s.path.kind = PathKind::kDrive, s.path.speed_mps = 0; },
                      "speed_mps"}),
    [](const auto& param_info) { return std::string(param_info.param.name); });

}  // namespace synthetic_check_test
}  // namespace octant
