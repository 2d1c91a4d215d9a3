// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/site_yaml.h"

#include "models/physics/receiver_array.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace {

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

TEST(SiteYaml, SaysWhatIsWrongAndWhere) {
  const std::string medium = kHead + "medium:\n  sigma_mps: 1\n";  // the next line is 5
  const std::string beacon = kHead + "vehicles: [{id: robot}]\nbeacons:\n";
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
      {kHead + "validity: {months: 0}\n" + kTail, 3, "positive"},
      {kHead + "validity: {beacon_drift_m_per_month: 0.001}\n" + kTail, 3, "a drift without a limit"},
      {kHead + "timing:\n  delay_per:\n" + kTail, 4, "timing.delay_per"},
      {kHead + "timing: {delay_per: [beacon, none]}\n" + kTail, 3, "'none' beside others"},
      {kHead + "timing: {clock: synchronized}\n" + kTail, 3, "did you mean 'synchronised'?"},
      {kHead + "noise: {tof_sigma_s: .nan}\n" + kTail, 3, "finite"},
      {kHead + "noise: {tof_sigma_s: 0}\n" + kTail, 3, "positive"},
      {kHead + "attenuation: {threshold_v: 0.1}\n" + kTail, 3, "amplitude_1m_v' is missing"},
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
  for (const BadSite& bad : cases) {
    SCOPED_TRACE(bad.text.substr(0, 300));
    expect_error(read(bad.text), bad.line, bad.words, "site.yaml");
  }
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
  // Once or twice they are what they stand for.
  expect_error(read(kHead + "a: &a [x]\nvehicles: *a\nbeacons: *a\n"), 3, "'x'; expected a mapping");
}

Site some_site() {
  Site s;
  s.name = test::some_name(0);
  s.motion = *rc::gen::element(Motion::kPlanar, Motion::kSpatial);
  s.medium = {
      *rc::gen::element(MediumModel::kConstant, MediumModel::kLinearTemperature, MediumModel::kCramer1993),
      test::some_positive(), 40 * test::some_fraction(), test::some_fraction(),
      1e5 * (1 + test::some_fraction())};
  s.speed_sigma_mps = test::some_positive();
  s.speed_offset_per_run = *rc::gen::arbitrary<bool>();
  s.timing.clock = *rc::gen::element(Clock::kSynchronised, Clock::kCycleOffset);
  s.timing.ranging = *rc::gen::element(Ranging::kOneWay, Ranging::kTwoWay);
  s.timing.turnaround_s = test::some_fraction();
  s.timing.delay_per = {*rc::gen::arbitrary<bool>(), *rc::gen::arbitrary<bool>(),
                        *rc::gen::arbitrary<bool>()};
  s.timing.delay_s = test::some_number();
  s.timing.delay_sigma_s = test::some_positive();
  s.noise = {test::some_positive(), test::some_positive(), test::maybe(test::some_positive()),
             test::some_positive(), test::some_positive()};
  if (*rc::gen::arbitrary<bool>()) {
    s.attenuation = {{test::some_positive(), test::some_positive()},
                     {test::some_positive(), 0},
                     {test::some_positive(), 1},
                     test::some_positive()};
    s.attenuation->saturation_v =
        test::maybe(s.attenuation->threshold_v + test::some_positive()).value_or(INFINITY);
  }
  for (std::size_t i = 0; i < *rc::gen::inRange<std::size_t>(2, 5); ++i) {
    SiteBeacon b{.name = test::some_name(i), .position_m = {}, .sigma_m = {}};
    for (int k = 0; k < 3; ++k) {
      b.position_m[k] = test::maybe(test::some_number());
      b.sigma_m[k] = test::maybe(test::some_positive());
    }
    if (s.timing.delay_per.beacon) {
      b.delay_s = test::maybe(test::some_number());
      b.delay_sigma_s = test::maybe(test::some_fraction());
    }
    s.beacons.push_back(b);
  }
  for (std::size_t v = 0; v < *rc::gen::inRange<std::size_t>(1, 3); ++v) {
    s.vehicles.push_back({test::some_name(v), s.receivers.size(), *rc::gen::inRange<std::size_t>(0, 3)});
    s.vehicles.back().rail = test::some_rail();
    for (std::size_t i = 0; i < s.vehicles.back().receiver_count; ++i) {
      SiteReceiver r{.name = test::some_name(i), .vehicle = VehicleId(v), .axis = std::nullopt};
      r.position_m = {test::some_number(), test::some_number(), test::some_number()};
      r.sigma_m = {test::some_positive(), 0, test::some_positive()};
      if (*rc::gen::arbitrary<bool>())
        r.axis = Eigen::Vector3d(test::some_number(), 1, test::some_number()).normalized();
      s.receivers.push_back(r);
    }
  }
  const bool looking = std::any_of(s.receivers.begin(), s.receivers.end(),
                                   [](const SiteReceiver& r) { return r.axis.has_value(); });
  if (s.attenuation && looking)
    s.attenuation->half_power_angle_rad = {0.1 + 2 * test::some_fraction(), test::some_fraction()};
  if (*rc::gen::arbitrary<bool>())
    s.distances.push_back({BeaconId(0), BeaconId(1), test::some_positive(), test::some_positive()});
  s.tolerance = {test::maybe(test::some_positive()), test::maybe(test::some_positive())};
  s.validity.months = test::maybe(test::some_positive());
  if (s.tolerance.beacon_m) s.validity.beacon_drift_m_per_month = test::maybe(test::some_positive());
  return s;
}

void assert_same(const Site& a, const Site& b) {
  RC_ASSERT(a.name == b.name && a.motion == b.motion);
  RC_ASSERT(a.medium.model == b.medium.model && a.medium.speed_mps == b.medium.speed_mps);
  RC_ASSERT(a.medium.temperature_degC == b.medium.temperature_degC &&
            a.medium.relative_humidity == b.medium.relative_humidity);
  RC_ASSERT(a.medium.pressure_pa == b.medium.pressure_pa && a.speed_sigma_mps == b.speed_sigma_mps);
  RC_ASSERT(a.speed_offset_per_run == b.speed_offset_per_run);
  RC_ASSERT(a.timing.clock == b.timing.clock && a.timing.ranging == b.timing.ranging &&
            a.timing.turnaround_s == b.timing.turnaround_s);
  RC_ASSERT(a.timing.delay_per.beacon == b.timing.delay_per.beacon &&
            a.timing.delay_per.receiver == b.timing.delay_per.receiver);
  RC_ASSERT(a.timing.delay_per.site == b.timing.delay_per.site && a.timing.delay_s == b.timing.delay_s);
  RC_ASSERT(a.timing.delay_sigma_s == b.timing.delay_sigma_s);
  RC_ASSERT(a.noise.tof_sigma_s == b.noise.tof_sigma_s && a.noise.pair_sigma_s == b.noise.pair_sigma_s);
  RC_ASSERT(a.noise.amplitude_relative_sigma == b.noise.amplitude_relative_sigma);
  RC_ASSERT(a.noise.bearing_sigma_rad == b.noise.bearing_sigma_rad &&
            a.noise.range_sigma_m == b.noise.range_sigma_m);
  RC_ASSERT(a.attenuation.has_value() == b.attenuation.has_value());
  if (a.attenuation) {
    const auto same = [](const Prior& x, const Prior& y) { return x.value == y.value && x.sigma == y.sigma; };
    RC_ASSERT(same(a.attenuation->amplitude_1m_v, b.attenuation->amplitude_1m_v));
    RC_ASSERT(same(a.attenuation->absorption_np_per_m, b.attenuation->absorption_np_per_m));
    RC_ASSERT(same(a.attenuation->rise_time_s, b.attenuation->rise_time_s) &&
              a.attenuation->threshold_v == b.attenuation->threshold_v);
    RC_ASSERT(same(a.attenuation->half_power_angle_rad, b.attenuation->half_power_angle_rad) &&
              a.attenuation->saturation_v == b.attenuation->saturation_v);
  }
  RC_ASSERT(a.beacons.size() == b.beacons.size() && a.vehicles.size() == b.vehicles.size() &&
            a.receivers.size() == b.receivers.size());
  for (std::size_t i = 0; i < a.beacons.size(); ++i) {
    RC_ASSERT(a.beacons[i].name == b.beacons[i].name && a.beacons[i].position_m == b.beacons[i].position_m);
    RC_ASSERT(a.beacons[i].sigma_m == b.beacons[i].sigma_m);
    RC_ASSERT(a.beacons[i].delay_s == b.beacons[i].delay_s &&
              a.beacons[i].delay_sigma_s == b.beacons[i].delay_sigma_s);
  }
  for (std::size_t i = 0; i < a.vehicles.size(); ++i) {
    RC_ASSERT(a.vehicles[i].name == b.vehicles[i].name &&
              a.vehicles[i].receiver_count == b.vehicles[i].receiver_count);
    RC_ASSERT(test::same_rail(a.vehicles[i].rail, b.vehicles[i].rail));
  }
  for (std::size_t i = 0; i < a.receivers.size(); ++i) {
    RC_ASSERT(a.receivers[i].name == b.receivers[i].name && a.receivers[i].vehicle == b.receivers[i].vehicle);
    RC_ASSERT(a.receivers[i].position_m == b.receivers[i].position_m &&
              a.receivers[i].sigma_m == b.receivers[i].sigma_m);
    RC_ASSERT(a.receivers[i].axis == b.receivers[i].axis);
  }
  RC_ASSERT(a.distances.size() == b.distances.size());
  for (std::size_t i = 0; i < a.distances.size(); ++i) {
    RC_ASSERT(a.distances[i].from == b.distances[i].from && a.distances[i].to == b.distances[i].to);
    RC_ASSERT(a.distances[i].distance_m == b.distances[i].distance_m &&
              a.distances[i].sigma_m == b.distances[i].sigma_m);
  }
  RC_ASSERT(a.tolerance.beacon_m == b.tolerance.beacon_m && a.tolerance.fix_m == b.tolerance.fix_m);
  RC_ASSERT(a.validity == b.validity);
}

TEST(SiteYaml, ReadsBackWhatItWrote) {
  EXPECT_TRUE(rc::check("read(write(x)) == x", [] {
    const Site site = some_site();
    const std::string text = site_to_yaml(site);
    const auto back = read(text);
    if (!back) RC_FAIL(back.error().message() + "\n" + text);
    RC_ASSERT(back->warnings.empty() || !site.timing.delay_per.none());
    assert_same(site, *back);
  }));
}

}  // namespace
}  // namespace octant::io
