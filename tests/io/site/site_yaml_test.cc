// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/site_yaml.h"

#include "models/physics/receiver_array.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace site_yaml_test {

using test::expect_error;
using test::TemporaryFolder;

Result<Site> read(const std::string& text) {
  const TemporaryFolder folder;
  return read_site(folder.write("site.yaml", text));
}

constexpr const char* kContractExample = R"(octant_site: 1
name: monash-lab
motion: planar
medium:
  model: cramer1993
  temperature_degC: 21.0
  relative_humidity: 0.50
  pressure_pa: 101325
  sigma_mps: 3.0
  offset_per: run
timing:
  clock: cycle_offset
  ranging: two_way
  turnaround_s: 0.01
  delay_per: [beacon, receiver]
  delay_s: 1e-9
  delay_sigma_s: 2.0e-4
noise:
  tof_sigma_s: 1.0e-5
  pair_sigma_s: 3.0e-10
attenuation:
  amplitude_1m_v: {value: 12.5, sigma: 3.0}
  absorption_np_per_m: {value: 0.15, sigma: 0.1}
  threshold_v: 0.2
  rise_time_s: {value: 4.5e-4, sigma: 3.0e-4}
beacons:
  - {id: B0, position_m: [0.0, 0.0, 2.5], sigma_m: 0.0}
  - {id: B1, position_m: [10.0, 0.1, 2.5], sigma_m: 0.3}
  - {id: B2, position_m: [null, ~, 2.5], sigma_m: [null, null, 0.01]}
  - {id: B3}
  - {id: 4, position_m: [1, 2, 3]}
vehicles:
  - id: robot
    receivers: {layout: octagon, side_m: 0.050, height_m: 0.30, sigma_m: 0.002}
  - id: cart
    receivers:
      - {id: r0, position_m: [0.1, 0.0, 0.3], sigma_m: [0.001, 0.002, 0.003], axis: [2, 0, 0]}
control:
  distances:
    - {from: B0, to: B1, distance_m: 10.012, sigma_m: 0.003}
tolerance: {beacon_m: 0.03, fix_m: 0.05}
)";

void expect_example(const Site& s) {
  EXPECT_THAT(s.warnings, testing::IsEmpty());
  EXPECT_EQ(s.name, "monash-lab");
  EXPECT_EQ(s.medium.model, MediumModel::kCramer1993);
  EXPECT_EQ(s.medium.temperature_degC, 21.0);
  EXPECT_TRUE(s.speed_offset_per_run);
  EXPECT_EQ(s.timing.clock, Clock::kCycleOffset);
  EXPECT_EQ(s.timing.ranging, Ranging::kTwoWay);
  EXPECT_TRUE(s.timing.delay_per.beacon && s.timing.delay_per.receiver && !s.timing.delay_per.site);
  EXPECT_EQ(s.timing.delay_s, 1e-9);
  EXPECT_EQ(s.noise.pair_sigma_s, 3.0e-10);
  EXPECT_EQ(s.attenuation.value().rise_time_s.sigma, 3.0e-4);
  ASSERT_EQ(s.beacons.size(), 5u);
  EXPECT_TRUE(s.beacons[0].is_control_point());
  EXPECT_EQ(s.beacons[1].sigma_m[2], 0.3);
  EXPECT_EQ(s.beacons[1].line, 28);
  EXPECT_FALSE(s.beacons[2].position_m[0] || s.beacons[2].sigma_m[0]);
  EXPECT_EQ(s.beacons[2].sigma_m[2], 0.01);
  EXPECT_FALSE(s.beacons[3].position_m[2].has_value());
  EXPECT_EQ(s.beacons[4].name, "4");
  EXPECT_FALSE(s.beacons[4].sigma_m[0].has_value()) << "no sigma beside a position: no prior";
  ASSERT_EQ(s.receivers.size(), 9u);
  EXPECT_EQ(s.receivers[7].name, "r7");
  EXPECT_NEAR(s.receivers[0].position_m.x(), 0.0653, 5e-5) << "65.3 mm for 50 mm";
  EXPECT_EQ(s.receivers[2].position_m, octagon(0.05, 0.3)[2].position_m);
  EXPECT_EQ(s.receivers[2].axis, octagon(0.05, 0.3)[2].axis);
  EXPECT_EQ(s.vehicles[1].first_receiver, 8u);
  EXPECT_EQ(s.receivers[8].axis, Eigen::Vector3d(1, 0, 0)) << "of unit length";
  EXPECT_EQ(s.receivers[8].vehicle, VehicleId(1));
  EXPECT_EQ(s.distances.at(0).to, BeaconId(1));
  EXPECT_EQ(s.tolerance.fix_m, 0.05);
}

TEST(SiteYaml, ReadsTheContractsExample) {
  const auto site = read(kContractExample);
  ASSERT_TRUE(site) << site.error().message();
  expect_example(*site);
}

TEST(SiteYaml, AcceptsMarkAndCrLf) {
  std::string text = "\xEF\xBB\xBF";
  for (const char c : std::string(kContractExample)) text += c == '\n' ? "\r\n" : std::string(1, c);
  const auto site = read(text);
  ASSERT_TRUE(site) << site.error().message();
  expect_example(*site);
}

const std::string kHead = "octant_site: 1\nmotion: planar\n";
const std::string kTail = "beacons: []\nvehicles:\n  - id: robot\n";

TEST(SiteYaml, BlocksMayBeLeftOutWhereThereAreNoArrivals) {
  const Site site = read(kHead + kTail).value();
  EXPECT_FALSE(site.medium_given || site.timing_given || site.tof_sigma_given);
  EXPECT_THAT(site.warnings, testing::IsEmpty());
  EXPECT_TRUE(read(kContractExample)->medium_given);
}

TEST(SiteYaml, WarnsOfUnknownKeysWithWhatTheyMayMean) {
  const Site site = read(kHead + "noise:\n  tof_sigma: 1.0e-5\n" + kTail + "colour: red\n").value();
  ASSERT_EQ(site.warnings.size(), 2u);
  EXPECT_THAT(site.warnings[0],
              testing::HasSubstr(
                  "site.yaml:4: unknown key 'noise.tof_sigma' is ignored; did you mean 'tof_sigma_s'?"));
  EXPECT_THAT(site.warnings[1], testing::HasSubstr("site.yaml:8: unknown key 'colour'"));
}

TEST(SiteYaml, WarnsOfWhatItAssumes) {
  const Site site =
      read(kHead + "medium: {model: cramer1993}\ntiming: {delay_per: beacon}\n" + kTail).value();
  EXPECT_THAT(site.warnings,
              testing::ElementsAre(testing::HasSubstr("temperature_degC"),
                                   testing::HasSubstr("relative_humidity"), testing::HasSubstr("pressure_pa"),
                                   testing::HasSubstr("sigma_mps"), testing::HasSubstr("delay_sigma_s")));
}

TEST(SiteYaml, BeaconsMayHaveDelayPriorsOfTheirOwn) {
  const std::string timing = "timing: {delay_per: beacon, delay_s: 1e-4, delay_sigma_s: 2e-5}\n";
  const std::string beacons =
      "beacons:\n  - {id: B0, delay_s: 3e-4}\n  - {id: B1, delay_s: 2e-4, delay_sigma_s: 0}\n  - {id: "
      "B2}\nvehicles:\n  - id: robot\n";
  const Site site = read(kHead + timing + beacons).value();
  EXPECT_THAT(site.warnings, testing::IsEmpty());
  EXPECT_EQ(beacon_delay_prior(site, 0).value, 3e-4);
  EXPECT_EQ(beacon_delay_prior(site, 0).sigma, 2e-5) << "timing's, as it states none";
  EXPECT_EQ(beacon_delay_prior(site, 1).sigma, 0.0);
  EXPECT_EQ(beacon_delay_prior(site, 2).value, 1e-4);
  EXPECT_EQ(largest_delay_sigma_s(site), 2e-5);
  expect_error(read(kHead + "timing: {delay_per: receiver, delay_sigma_s: 2e-5}\n" + beacons), 5,
               "timing.delay_per has no 'beacon'", "site.yaml");
  expect_error(read(kHead + timing + "beacons:\n  - {id: B0, delay_sigma_s: -1}\nvehicles:\n  - id: robot\n"),
               5, "beacons[0].delay_sigma_s", "site.yaml");
}

TEST(SiteYaml, WhereAllBeaconsStateTheirDelaysNothingIsAssumed) {
  const std::string timing = "timing: {delay_per: beacon}\n";
  const std::string tail = "vehicles:\n  - id: robot\n";
  EXPECT_THAT(
      read(kHead + timing + "beacons:\n  - {id: B0, delay_s: 1e-4, delay_sigma_s: 1e-6}\n" + tail)->warnings,
      testing::IsEmpty());
  EXPECT_THAT(read(kHead + timing + "beacons:\n  - {id: B0, delay_s: 1e-4}\n" + tail)->warnings,
              testing::ElementsAre(testing::HasSubstr("delay_sigma_s")));
}

TEST(SiteYaml, ReadsRails) {
  const Site straight = read(kHead + kTail + "    rail: {from_m: [0, 1.5], to_m: [40, 1.5]}\n").value();
  EXPECT_THAT(straight.warnings, testing::IsEmpty());
  ASSERT_TRUE(straight.vehicles[0].rail);
  EXPECT_EQ(straight.vehicles[0].rail->shape, Rail::Shape::kStraight);
  EXPECT_EQ(straight.vehicles[0].rail->from_m, Eigen::Vector2d(0, 1.5));
  EXPECT_EQ(straight.vehicles[0].rail->to_m, Eigen::Vector2d(40, 1.5));
  const Site arc = read(kHead + kTail + "    rail: {centre_m: [6, 5], radius_m: 4}\n").value();
  EXPECT_EQ(arc.vehicles[0].rail->shape, Rail::Shape::kArc);
  EXPECT_EQ(arc.vehicles[0].rail->centre_m, Eigen::Vector2d(6, 5));
  EXPECT_EQ(arc.vehicles[0].rail->radius_m, 4.0);
  EXPECT_FALSE(read(kHead + kTail).value().vehicles[0].rail);
  EXPECT_FALSE(read(kHead + kTail + "    rail:\n").value().vehicles[0].rail);
}

struct BadSite {
  std::string text;
  int line;
  std::string words;
};

void expect_errors(const std::vector<BadSite>& cases) {
  for (const BadSite& bad : cases) {
    SCOPED_TRACE(bad.text.substr(0, 300));
    expect_error(read(bad.text), bad.line, bad.words, "site.yaml");
  }
}

TEST(SiteYaml, SaysWhatIsWrongAndWhere) {
  const std::string medium = kHead + "medium:\n  sigma_mps: 1\n";  // the next line is 5
  const std::vector<BadSite> cases = {
      {"", 0, "empty"},
      {"- 1\n", 1, "a mapping"},
      {"motion: planar\n", 1, "'octant_site' is missing"},
      {"octant_site: 99\n", 1, "version '99'"},
      {"# c\nocatnt: 1\noctant_site: [1]\n", 3, "version a list"},
      {"octant_site: 1\n" + kTail, 1, "'motion' is missing"},
      {"octant_site: 1\nmotion: plannar\n" + kTail, 2, "did you mean 'planar'?"},
      {kHead + "motion: spatial\n" + kTail, 3, "'motion' is given twice"},
      {medium + "  model: cramer\n" + kTail, 5, "did you mean 'cramer1993'?"},
      {medium + "  model: constant\n" + kTail, 4, "'medium.speed_mps' is missing"},
      {medium + kTail, 4, "'medium.model' is missing"},
      {medium + "  model: constant\n  speed_mps: 0\n" + kTail, 6, "a positive number"},
      {medium + "  model: constant\n  speed_mps: .inf\n" + kTail, 6, "finite"},
      {medium + "  model: constant\n  speed_mps: \"343\"\n" + kTail, 6, "leave the quotes out"},
      {medium + "  model: constant\n  speed_mps: true\n" + kTail, 6, "'true'; expected a positive number"},
      {medium + "  model: constant\n  speed_mps:\n" + kTail, 6, "has no value"},
      {medium + "  model: constant\n  speed_mps: 343,0\n" + kTail, 6, "'343,0'"},
      {medium + "  model: linear_temperature\n  temperature_degC: 293.15\n" + kTail, 6, "293 K"},
      {medium + "  model: cramer1993\n  relative_humidity: 50\n" + kTail, 6, "50 % is 0.5"},
      {medium + "  model: cramer1993\n  pressure_pa: 1013\n" + kTail, 6, "pascals"},
      {kHead + "medium: {model: constant, speed_mps: 343, sigma_mps: -1}\n" + kTail, 3, "zero or a positive"},
      {kHead + "motion:\n" + kTail, 3, "given twice"},
      {"octant_site: 1\nmotion:\n" + kTail, 2, "'motion' has no value"},
      {kHead + "tolerance:\n  fix_m:\n" + kTail, 4, "'tolerance.fix_m' has no value"},
      {kHead + "timing:\n  delay_per:\n" + kTail, 4, "timing.delay_per"},
      {kHead + "timing: {delay_per: [beacon, none]}\n" + kTail, 3, "'none' beside others"},
      {kHead + "timing: {clock: synchronized}\n" + kTail, 3, "did you mean 'synchronised'?"},
      {kHead + "noise: {tof_sigma_s: .nan}\n" + kTail, 3, "finite"},
      {kHead + "noise: {tof_sigma_s: 0}\n" + kTail, 3, "positive"},
      {kHead + "attenuation: {threshold_v: 0.1}\n" + kTail, 3, "amplitude_1m_v' is missing"},
  };
  expect_errors(cases);
}

TEST(SiteYaml, SaysWhatIsWrongWithBeaconsVehiclesAndText) {
  const std::string beacon = kHead + "vehicles: [{id: robot}]\nbeacons:\n";
  const std::vector<BadSite> cases = {
      {kHead + "vehicles: [{id: robot}]\n", 1, "'beacons' is missing"},
      {kHead + "beacons: []\n", 1, "'vehicles' is missing"},
      {beacon + "  - {id: B1}\n  - id: B1\n", 6, "'B1' is used twice (first in line 5)"},
      {beacon + "  - {position_m: [0, 0, 0]}\n", 5, "'beacons[0].id' is missing"},
      {beacon + "  - {id: \"\"}\n", 5, "beacons[0].id is ''"},
      {beacon + "  - {id: B1, position_m: [0, 0]}\n", 5, "2 items; expected a list of 3"},
      {beacon + "  - {id: B1, position_m: [0, 0, up]}\n", 5, "beacons[0].position_m[2] is 'up'"},
      {beacon + "  - {id: B1, position_m: 3}\n", 5, "a list of 3"},
      {beacon + "  - {id: B1, position_m: [0, 0, 0], sigma_m: -0.1}\n", 5, "zero or a positive"},
      {beacon + "  - {id: B1}\ncontrol:\n  distances:\n    - {from: B1, to: B2, distance_m: 1, sigma_m: 0}\n",
       8, "'B2' is not in the site"},
      {beacon + "  - {id: B1}\ncontrol: {distances: [{from: B1, to: B1, distance_m: 1, sigma_m: 0}]}\n", 6,
       "two different"},
      {kHead + "beacons: []\nvehicles:\n  - {id: a}\n  - {id: a}\n", 6, "vehicle id 'a' is used twice"},
      {kHead + "beacons: []\nvehicles:\n  - {id: robot}\n  - {receivers: []}\n", 6,
       "vehicle id 'robot' is used twice"},
      {kHead +
           "beacons: []\nvehicles:\n  - id: a\n    receivers: {layout: hexagon, side_m: 1, height_m: 0}\n",
       6, "one of octagon"},
      {kHead + "beacons: []\nvehicles:\n  - id: a\n    receivers:\n      - {id: r}\n", 7,
       "position_m' is missing"},
      {kHead + "beacons: []\nvehicles:\n  - id: a\n    receivers:\n      - {id: r, position_m: [0, 0, 0], "
               "axis: [0, 0, 0]}\n",
       7, "no length"},
      {kHead + kTail + "    rail: {from_m: [0, 0]}\n", 6, "'vehicles[0].rail.to_m' is missing"},
      {kHead + kTail + "    rail: {}\n", 6, "'vehicles[0].rail.from_m' is missing"},
      {kHead + kTail + "    rail: 3\n", 6, "a mapping"},
      {kHead + kTail + "    rail: {from_m: [0, 0], to_m: [1, 2, 3]}\n", 6, "3 items; expected a list of 2"},
      {kHead + kTail + "    rail: {from_m: [0, 1], to_m: [0, 1]}\n", 6, "is where the rail begins"},
      {kHead + kTail + "    rail: {from_m: [0, 1], radius_m: 1}\n", 6, "both straight and an arc"},
      {kHead + kTail + "    rail: {centre_m: [0, 1]}\n", 6, "'vehicles[0].rail.radius_m' is missing"},
      {kHead + kTail + "    rail:\n      centre_m: [0, 1]\n      radius_m: -2\n", 8, "a positive number"},
      {kHead + "beacons: [\n", 4, "not YAML"},
      {kHead + "beacons: []\n\tvehicles: 3\n", 4, "not YAML: a tab in the indentation; expected blanks"},
      {kHead + "beacons:\n  - {id: B0, positon_m: [1, 2, 3]}\nvehicles:\n  - id: robot\n", 4,
       "unknown key 'beacons[0].positon_m'; expected position_m"},
      {kHead + kTail + "---\na: 1\n", 7, "second document"},
      {kHead + "name: \xFF\n", 3, "0xFF"},
      {kHead + "name: " + std::string(100'000, '[') + "\n", 3, "levels deep"},
  };
  expect_errors(cases);
}

TEST(SiteYaml, ReceiversMayBeDirectional) {
  const std::string attenuation =
      "attenuation: {amplitude_1m_v: 12.5, absorption_np_per_m: 0, threshold_v: 0.2, rise_time_s: 4.5e-4, ";
  const std::string octagon =
      "beacons: []\nvehicles:\n  - id: robot\n    receivers: {layout: octagon, side_m: 0.05, height_m: "
      "0.3}\n";
  const auto site = read(kHead + attenuation +
                         "half_power_angle_rad: {value: 0.4, sigma: 0.1}, saturation_v: 4.7}\n" + octagon);
  ASSERT_TRUE(site) << site.error().message();
  EXPECT_EQ(site->attenuation->half_power_angle_rad.value, 0.4);
  EXPECT_EQ(site->attenuation->half_power_angle_rad.sigma, 0.1);
  EXPECT_EQ(site->attenuation->mean().half_power_angle_rad, 0.4);
  EXPECT_EQ(site->attenuation->mean().saturation_v, 4.7);
  EXPECT_FALSE(read(kContractExample)->attenuation->mean().directional());
  expect_error(read(kHead + attenuation + "half_power_angle_rad: 22.5}\n" + octagon), 3,
               "an angle off the axis from 0.02 to 2.8 rad");
  expect_error(read(kHead + attenuation + "saturation_v: 0.1}\n" + octagon), 3, "more than threshold_v");
  expect_error(read(kHead + attenuation +
                    "half_power_angle_rad: 0.4}\nbeacons: []\nvehicles:\n  - id: robot\n    receivers: [{id: "
                    "r0, position_m: [0, 0, 0]}]\n"),
               3, "no receiver has an axis");
}

TEST(SiteYaml, AliasesThatMultiplyAreTooMany) {
  std::string text = kHead + "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 9; ++k) text.append(k > 0 ? ", *a" : "*a").append(std::to_string(i - 1));
    text += "]\n";
  }
  expect_error(read(text + kTail), 9, "more than 1000000 values");
  // Used once or twice, they have their normal meaning.
  expect_error(read(kHead + "a: &a [x]\nvehicles: *a\nbeacons: *a\n"), 3, "'x'; expected a mapping");
}

}  // namespace site_yaml_test
}  // namespace octant::io
