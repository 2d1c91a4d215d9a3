// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/scenario_yaml.h"

#include <fstream>
#include <ostream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/schema/schema.h"
#include "tests/support/worlds.h"

namespace octant::io {
namespace scenario_yaml_test {

using octant::test::must;
using testing::HasSubstr;

/// Twelve lines; tests append theirs from line 13 on.
constexpr const char* kMinimal = R"(octant_scenario: 1
site:
  name: small
  motion: planar
  medium: {model: constant, speed_mps: 343.0, sigma_mps: 1.0}
  timing: {delay_per: none}
  noise: {tof_sigma_s: 1.0e-5}
  beacons:
    - {id: B0, position_m: [0.0, 0.0, 2.5], sigma_m: 0.0}
    - {id: B1, position_m: [10.0, 0.0, 2.5], sigma_m: 0.3}
  vehicles:
    - {id: robot, receivers: {layout: octagon, side_m: 0.05, height_m: 0.3, sigma_m: 0.001}}
)";

Result<Scenario> with(const std::string& more) { return scenario_from_yaml(kMinimal + more, "w.yaml"); }

TEST(ScenarioYaml, BundledWorldIsTheFile) {
  std::ifstream file(std::string(OCTANT_SOURCE_DIR) + "/datasets/hall/scenario.yaml");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(bundled_scenario(), text.str());
  const Scenario s = must(scenario_from_yaml(bundled_scenario(), "hall"));
  EXPECT_TRUE(s.warnings.empty()) << s.warnings[0];
  EXPECT_EQ(s.site.beacons.size(), 8u);
  EXPECT_EQ(s.path.epochs, 150);
  EXPECT_EQ(s.heldout_path.epochs, 40);
  EXPECT_TRUE(simulate(s, 1));
}

TEST(ScenarioYaml, LeftOutKeysKeepTheirDefaults) {
  const Scenario s = must(with(""));
  const Scenario plain;
  EXPECT_EQ(s.hall_m, plain.hall_m);
  EXPECT_EQ(s.range_m, plain.range_m);
  EXPECT_EQ(s.path.kind, PathKind::kStops);
  EXPECT_EQ(s.heldout_path.epochs, 40);  // a third
  EXPECT_FALSE(s.true_delay_s || s.true_speed_offset_mps || s.true_temperature_offset_degC);
  EXPECT_EQ(s.odometry_accuracy.distance_sigma_m_per_sqrt_m, 0.01);
}

TEST(ScenarioYaml, EveryKeyIsRead) {
  const Scenario s = must(with(R"(hall_m: [30, 15]
range_m: 9
hearing_half_angle_rad: 1.0
path: {kind: drive, duration_s: 60, speed_mps: 0.5, turn_rate_rad_per_s: 0.4, odometry_period_s: 0.1, slot_s: 0.07, waypoints_m: [[1, 2], [3, 4]]}
heldout_path: {kind: waypoints, epochs: 7, epoch_period_s: 9, rounds: 2}
echo_fraction: 0.1
echo_delay_s: [1e-3, 2e-3]
early_fraction: 0.01
quantum_s: 5e-8
true_speed_offset_mps: 0.4
true_temperature_offset_degC: 1.5
true_delay_s: [1e-5, 2e-5]
cycle_offset_s: [-0.01, 0.01]
unknown_beacons: true
log_poses: true
poses: {position_sigma_m: 0.002, heading: unknown, max_gap_s: 2}
odometry: {distance_sigma_m_per_sqrt_m: 0.03, heading_sigma_rad_per_sqrt_m: 0.04, heading_sigma_per_rad: 0.05, floor_m: 0, floor_rad: 0.001}
)"));
  EXPECT_EQ(s.hall_m, (std::array{30.0, 15.0}));
  EXPECT_EQ(s.range_m, 9);
  EXPECT_EQ(s.hearing_half_angle_rad, 1.0);
  EXPECT_EQ(s.path.kind, PathKind::kDrive);
  EXPECT_EQ(s.path.duration_s, 60);
  EXPECT_EQ(s.path.speed_mps, 0.5);
  EXPECT_EQ(s.path.turn_rate_rad_per_s, 0.4);
  EXPECT_EQ(s.path.odometry_period_s, 0.1);
  EXPECT_EQ(s.path.slot_s, 0.07);
  ASSERT_EQ(s.path.waypoints_m.size(), 2u);
  EXPECT_EQ(s.path.waypoints_m[1], Eigen::Vector2d(3, 4));
  EXPECT_EQ(s.heldout_path.kind, PathKind::kWaypoints);
  EXPECT_EQ(s.heldout_path.epochs, 7);
  EXPECT_EQ(s.heldout_path.epoch_period_s, 9);
  EXPECT_EQ(s.heldout_path.rounds, 2);
  EXPECT_EQ(s.heldout_path.waypoints_m.size(), 2u);  // the path's
  EXPECT_EQ(s.echo_fraction, 0.1);
  EXPECT_EQ(s.echo_delay_s, (std::array{1e-3, 2e-3}));
  EXPECT_EQ(s.early_fraction, 0.01);
  EXPECT_EQ(s.quantum_s, 5e-8);
  EXPECT_EQ(s.true_speed_offset_mps, 0.4);
  EXPECT_EQ(s.true_temperature_offset_degC, 1.5);
  EXPECT_EQ(s.true_delay_s, (std::array{1e-5, 2e-5}));
  EXPECT_EQ(s.cycle_offset_s, (std::array{-0.01, 0.01}));
  EXPECT_TRUE(s.unknown_beacons);
  EXPECT_TRUE(s.log_poses);
  EXPECT_EQ(s.pose_accuracy.position_sigma_m, 0.002);
  EXPECT_FALSE(s.pose_accuracy.heading_known);
  EXPECT_EQ(s.pose_accuracy.max_gap_s, 2);
  EXPECT_EQ(s.odometry_accuracy.heading_sigma_per_rad, 0.05);
  EXPECT_EQ(s.odometry_accuracy.floor_m, 0);
  EXPECT_TRUE(s.warnings.empty()) << s.warnings[0];
}

struct Bad {
  const char* name;
  std::string text;   ///< after kMinimal
  const char* where;  ///< start of the message
  const char* named;  ///< and what it names
};

/// As ctest names it.
void PrintTo(const Bad& bad, std::ostream* out) { *out << bad.name; }

class ScenarioYamlBad : public testing::TestWithParam<Bad> {};

TEST_P(ScenarioYamlBad, IsRefusedWithItsPlace) {
  const auto scenario = with(GetParam().text);
  ASSERT_FALSE(scenario);
  EXPECT_EQ(scenario.error().code, Errc::kBadInput);
  EXPECT_THAT(scenario.error().message(), testing::StartsWith(GetParam().where));
  EXPECT_THAT(scenario.error().message(), HasSubstr(GetParam().named));
}

INSTANTIATE_TEST_SUITE_P(
    All, ScenarioYamlBad,
    testing::Values(Bad{"text_for_number", "range_m: far\n", "w.yaml:13:10", "range_m"},
                    Bad{"negative", "quantum_s: -1\n", "w.yaml:13:", "quantum_s"},
                    Bad{"fraction", "echo_fraction: 1.5\n", "w.yaml:13:", "echo_fraction"},
                    Bad{"exchanged", "true_delay_s: [2e-4, 1e-4]\n", "w.yaml:13:", "true_delay_s"},
                    Bad{"three_of_two", "hall_m: [1, 2, 3]\n", "w.yaml:13:", "hall_m"},
                    Bad{"kind", "path: {kind: walk}\n", "w.yaml:13:14", "stops"},
                    Bad{"epochs", "path: {epochs: 1.5}\n", "w.yaml:13:", "path.epochs"},
                    Bad{"flat_stations", "path: {kind: stations, stations: [1, 2, 3]}\n",
                        "w.yaml:13:", "stations"},
                    Bad{"flat_waypoints", "path: {waypoints_m: [1, 2]}\n", "w.yaml:13:", "waypoints_m"},
                    Bad{"not_a_block", "path: 3\n", "w.yaml:13:", "path"},
                    Bad{"contradiction", "log_amplitude: true\n", "w.yaml", "attenuation"},
                    Bad{"not_yaml", "range_m: [1, 2\n", "w.yaml:1", ""}),
    [](const auto& param_info) { return std::string(param_info.param.name); });

TEST(ScenarioYaml, HeadAndSiteAreNeeded) {
  const auto no_version = scenario_from_yaml("range_m: 3\n", "w.yaml");
  ASSERT_FALSE(no_version);
  EXPECT_THAT(no_version.error().message(), HasSubstr("octant_scenario"));
  const auto other_version = scenario_from_yaml("octant_scenario: 99\n", "w.yaml");
  ASSERT_FALSE(other_version);
  EXPECT_THAT(other_version.error().message(), testing::AllOf(HasSubstr("w.yaml:1"), HasSubstr("99")));
  const auto no_site = scenario_from_yaml("octant_scenario: 1\n", "w.yaml");
  ASSERT_FALSE(no_site);
  EXPECT_THAT(no_site.error().message(), HasSubstr("site"));
}

TEST(ScenarioYaml, BeaconWithoutPlaceIsNamedWithItsLine) {
  std::string text = kMinimal;
  text.replace(text.find("position_m: [10.0, 0.0, 2.5], "), 30, "");
  text.replace(text.find("id: B1, sigma_m: 0.3"), 20, "id: B1");
  const auto scenario = scenario_from_yaml(text, "w.yaml");
  ASSERT_FALSE(scenario);
  EXPECT_THAT(scenario.error().message(), testing::AllOf(testing::StartsWith("w.yaml:10"), HasSubstr("B1")));
}

TEST(ScenarioYaml, UnknownKeysAreWarnings) {
  const Scenario s = must(with("rnage_m: 3\npath: {epoch: 3}\n"));
  ASSERT_EQ(s.warnings.size(), 2u);
  EXPECT_THAT(s.warnings, testing::Contains(HasSubstr("rnage_m")));
  EXPECT_THAT(s.warnings, testing::Contains(HasSubstr("epoch")));
}

TEST(ScenarioYaml, SchemaIsJsonAndKnowsTheBundledWorldsKeys) {
  const auto json = nlohmann::json::parse(schema("scenario"));
  for (const char* key : {"octant_scenario", "site", "hall_m", "range_m", "hearing_half_angle_rad", "path",
                          "heldout_path", "true_temperature_offset_degC", "true_delay_s", "quantum_s"}) {
    EXPECT_TRUE(json["properties"].contains(key)) << key;
  }
}

}  // namespace scenario_yaml_test
}  // namespace octant::io
