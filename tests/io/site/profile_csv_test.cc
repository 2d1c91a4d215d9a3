// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/profile_csv.h"

#include "io/site/site_yaml.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace profile_csv_test {

using test::expect_error;
using test::TemporaryFolder;

Result<SpeedProfile> read(const std::string& table) {
  const TemporaryFolder folder;
  return read_profile(folder.write("svp.csv", table));
}

constexpr const char* kSite = R"(octant_site: 1
motion: spatial
medium: {model: constant, sigma_mps: 3, profile: svp.csv}
timing: {delay_per: none}
noise: {tof_sigma_s: 5.0e-05}
beacons:
  - {id: M1, position_m: [1000, 990, -2740], sigma_m: 5}
vehicles:
  - id: ship
    receivers:
      - {id: transducer, position_m: [0, 0, -3], sigma_m: 0}
)";

TEST(ProfileCsv, DepthsAreHeightsWithTheOtherSign) {
  const auto profile = read("depth_m,speed_mps\n0,1528\n50,1525\n800,1482\n");
  ASSERT_TRUE(profile) << profile.error().message();
  ASSERT_EQ(profile->levels().size(), 3u);
  EXPECT_EQ(profile->levels().front().height_m, -800);
  EXPECT_EQ(profile->levels().front().speed_mps, 1482);
  EXPECT_EQ(profile->levels().back().height_m, 0);
}

TEST(ProfileCsv, TemperatureAndSalinityGiveTheSpeedOfSeaWater) {
  const auto profile = read("height_m,temperature_degC,salinity\n-1000,25,35\n-10,20,36\n");
  ASSERT_TRUE(profile) << profile.error().message();
  EXPECT_NEAR(profile->levels().front().speed_mps, 1550.744, 5e-4);  // Mackenzie's check value
}

TEST(ProfileCsv, FaultsAreNamedWithTheirLine) {
  expect_error(read("depth_m,temperature_degC\n0,20\n"), 1, "salinity");
  expect_error(read("depth_m,speed_mps\n0,1528\n50,-1525\n"), 3, "above zero");
  expect_error(read("depth_m,speed_mps\n0,1528\n50,1525\n20,1526\n"), 4, "depths that increase");
  expect_error(read("depth_m,speed_mps\n"), 0, "one row or more");
}

TEST(SiteProfile, IsReadFromTheFolderOfTheSiteFile) {
  const TemporaryFolder folder;
  folder.write("svp.csv", "depth_m,speed_mps\n0,1500\n3000,1500\n");
  const auto site = read_site(folder.write("site.yaml", kSite));
  ASSERT_TRUE(site) << site.error().message();
  ASSERT_NE(site->medium.profile, nullptr);
  EXPECT_NEAR(site->medium.speed_mps, 1500, 1e-9) << "the mean of the profile where no speed is stated";
}

TEST(SiteProfile, TheWriterWritesWhatTheReaderReads) {
  const TemporaryFolder folder;
  folder.write("svp.csv", "depth_m,speed_mps\n0,1528.125\n50,1525\n3000,1517\n");
  const auto site = read_site(folder.write("site.yaml", kSite));
  ASSERT_TRUE(site) << site.error().message();
  const auto again = read_site(folder.write("again.yaml", site_to_yaml(*site)));
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_NE(again->medium.profile, nullptr);
  ASSERT_EQ(again->medium.profile->levels().size(), 3u);
  EXPECT_EQ(again->medium.profile->levels().back().speed_mps, 1528.125);
  EXPECT_EQ(again->medium.speed_mps, site->medium.speed_mps);
}

TEST(SiteProfile, MissingFilesAndModelsOfTheAirAreRefused) {
  const TemporaryFolder folder;
  expect_error(read_site(folder.write("site.yaml", kSite)), 0, "svp.csv", "svp.csv");
  std::string air = kSite;
  air.replace(air.find("constant"), 8, "linear_temperature");
  folder.write("svp.csv", "depth_m,speed_mps\n0,1500\n");
  expect_error(read_site(folder.write("site.yaml", air)), 3, "profile");
}

}  // namespace profile_csv_test
}  // namespace octant::io
