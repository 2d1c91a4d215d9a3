// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The reader reads site files of the writer.
#include "io/site/site_yaml.h"

#include "models/physics/receiver_array.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace site_writer_test {

using test::expect_error;
using test::TemporaryFolder;

Result<Site> read_written(const std::string& text) {
  const TemporaryFolder folder;
  return read_site(folder.write("site.yaml", text));
}

SiteBeacon some_beacon(std::size_t i, bool has_delay) {
  SiteBeacon b{.name = test::some_name(i), .position_m = {}, .sigma_m = {}};
  for (int k = 0; k < 3; ++k) {
    b.position_m[k] = test::maybe(test::some_number());
    b.sigma_m[k] = test::maybe(test::some_positive());
  }
  if (has_delay) {
    b.delay_s = test::maybe(test::some_number());
    b.delay_sigma_s = test::maybe(test::some_fraction());
  }
  return b;
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
  for (std::size_t i = 0; i < *rc::gen::inRange<std::size_t>(2, 5); ++i)
    s.beacons.push_back(some_beacon(i, s.timing.delay_per.beacon));
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
  s.drift = {test::maybe(test::some_positive()), test::maybe(test::some_positive()),
             test::maybe(test::some_positive()), test::maybe(test::some_positive())};
  return s;
}

void assert_same(const Site& a, const Site& b) {
  RC_ASSERT(a.drift == b.drift);
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
    const auto back = read_written(text);
    if (!back) RC_FAIL(back.error().message() + "\n" + text);
    RC_ASSERT(back->warnings.empty() || !site.timing.delay_per.none());
    assert_same(site, *back);
  }));
}

TEST(SiteYaml, WritesNoSpeedThatNothingTakes) {
  Site site;
  site.medium.model = MediumModel::kCramer1993;
  EXPECT_EQ(site_to_yaml(site).find("  speed_mps:"), std::string::npos);
  site.medium.speed_mps = 345.0;  // stated, and kept
  EXPECT_NE(site_to_yaml(site).find("  speed_mps: 345\n"), std::string::npos);
  site.medium = {.model = MediumModel::kConstant};
  EXPECT_NE(site_to_yaml(site).find("  speed_mps: 343\n"), std::string::npos);
}

TEST(SiteYaml, SaysWhatIsWrongWithItsValidity) {
  const std::string head = "octant_site: 1\nmotion: planar\n",
                    tail = "beacons: []\nvehicles:\n  - id: robot\n";
  expect_error(read_written(head + "validity: {months: 0}\n" + tail), 3, "positive");
  expect_error(read_written(head + "validity: {beacon_drift_m_per_month: 0.001}\n" + tail), 3,
               "a drift without a limit");
}

}  // namespace site_writer_test
}  // namespace octant::io
