// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/site_beacons.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/yaml/yaml_reader.h"

namespace octant::io {
namespace site_beacons_test {

constexpr const char* kSite = R"(# a hall
octant_site: 1
name: "no"
motion: planar
medium: {model: constant, speed_mps: 343.0}
timing: {clock: synchronised, delay_per: none}
noise: {tof_sigma_s: 1.0e-5}
beacons:
  - {id: "007", position_m: [0.0, 0.0, 2.5], sigma_m: 0.0}
  - {id: B1, position_m: [10.0, 0.1, null], sigma_m: [0.3, 0.3, null]}
vehicles:
  - id: robot
    receivers: [{id: r0, position_m: [0.0, 0.0, 0.3]}]
control:
  distances:
    - {from: "007", to: B1, distance_m: 10.0, sigma_m: 0.01}
scene:
  floor_m: [[0, 0], [10, 0], [10, 5], [0, 5]]
  beacons:
    - {id: "007", axis: [1, 0, 0]}
)";

Result<Site> site_of(const std::string& text) {
  const auto node = parse_yaml(text, "new.yaml");
  if (!node) return fail(node.error());
  return site_from_yaml(*node, "new.yaml");
}

const std::vector<SiteBeaconEntry> kNew = {{"N0", {1.23456, 2.0, 3.0}, 0.1, Eigen::Vector3d(0, 0, -1)},
                                           {"N1", {-4.0, 0.0, 2.0}, 0.05, {}}};

TEST(SiteBeacons, KeepsWhatIsThereAndAddsTheNewOnes) {
  const auto out = with_beacons(kSite, "site.yaml", kNew, true);
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_TRUE(out->warnings.empty());
  const auto site = site_of(out->text);
  ASSERT_TRUE(site) << site.error().message() << out->text;
  ASSERT_EQ(site->beacons.size(), 4U);
  EXPECT_EQ(site->name, "no");
  EXPECT_EQ(site->beacons[0].name, "007");
  EXPECT_TRUE(site->beacons[0].is_control_point());
  EXPECT_FALSE(site->beacons[1].position_m[2]);
  EXPECT_EQ(*site->beacons[2].position_m[0], 1.2346) << "to a tenth of a millimetre";
  EXPECT_EQ(*site->beacons[3].sigma_m[2], 0.05);
  EXPECT_EQ(site->distances.size(), 1U);
  const auto node = parse_yaml(out->text, "new.yaml");
  EXPECT_EQ((*node)["scene"]["beacons"].size(), 2U);
}

TEST(SiteBeacons, ReplacesThemAndWhatHungOnThem) {
  const auto out = with_beacons(kSite, "site.yaml", kNew, false);
  ASSERT_TRUE(out) << out.error().message();
  ASSERT_EQ(out->warnings.size(), 1U);
  const auto site = site_of(out->text);
  ASSERT_TRUE(site) << site.error().message();
  ASSERT_EQ(site->beacons.size(), 2U);
  EXPECT_TRUE(site->distances.empty());
  const auto node = parse_yaml(out->text, "new.yaml");
  ASSERT_EQ((*node)["scene"]["beacons"].size(), 1U) << "axes of those that have one";
  EXPECT_EQ((*node)["scene"]["beacons"][0]["id"].scalar(), "N0");
}

TEST(SiteBeacons, RefusesWhatIsNoSite) {
  EXPECT_FALSE(with_beacons("octant_site: 7\n", "site.yaml", kNew, true));
  EXPECT_FALSE(with_beacons("a: [", "site.yaml", kNew, true));
  // A name that is used already: the new text would not be a valid site.
  EXPECT_FALSE(with_beacons(kSite, "site.yaml", {{"B1", {0, 0, 0}, 0.1, {}}}, true));
}

}  // namespace site_beacons_test
}  // namespace octant::io
