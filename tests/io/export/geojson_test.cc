// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "io/export/exported.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace geojson_test {

using nlohmann::json;

const EarthOrigin kHall{48.2, 11.6, 520.0, 0.7};

Fix fix_at(double time_s, double x_m, double y_m, VehicleId vehicle, FixStatus status = FixStatus::kOk) {
  Fix fix;
  fix.time_s = time_s, fix.vehicle = vehicle, fix.status = status;
  fix.T_map_vehicle = Pose::planar(x_m, y_m, 0.25);
  return fix;
}

json features_of(const ExportedContent& content, const EarthOrigin& origin = kHall) {
  const json all = json::parse(to_geojson(content, origin));
  EXPECT_EQ(all["type"], "FeatureCollection");
  return all["features"];
}

json of_kind(const json& features, const std::string& kind) {
  json some = json::array();
  for (const json& f : features)
    if (f["properties"]["kind"] == kind) some.push_back(f);
  return some;
}

/// Earth-centred coordinates by the ellipsoid's own formula (WGS 84: a = 6378137 m, f = 1 / 298.257223563).
Eigen::Vector3d earth_centred(const json& coordinates) {
  const double degree = std::numbers::pi / 180, f = 1 / 298.257223563, e2 = f * (2 - f);
  const double longitude = coordinates[0].get<double>() * degree,
               latitude = coordinates[1].get<double>() * degree, height = coordinates[2].get<double>();
  const double n = 6378137.0 / std::sqrt(1 - e2 * std::sin(latitude) * std::sin(latitude));
  return {(n + height) * std::cos(latitude) * std::cos(longitude),
          (n + height) * std::cos(latitude) * std::sin(longitude),
          (n * (1 - e2) + height) * std::sin(latitude)};
}

/// The map is a plane: its distances are those in space.
TEST(GeoJson, DistancesBetweenBeaconsStay) {
  ExportedContent content;
  for (int i = 0; i < 12; ++i)
    content.beacons.push_back({"B", {300 * std::sin(1.3 * i), 400 * std::cos(2.1 * i), 0.5 * i}});
  const json features = features_of(content);
  for (std::size_t a = 0; a < 12; ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const double there = (earth_centred(features[a]["geometry"]["coordinates"]) -
                            earth_centred(features[b]["geometry"]["coordinates"]))
                               .norm();
      // Rounded to 1e-9 degrees and 0.1 mm.
      EXPECT_NEAR(there, (content.beacons[a].position_m - content.beacons[b].position_m).norm(), 4e-4);
    }
}

TEST(GeoJson, NorthIsWhereTheOriginHasIt) {
  ExportedContent content;
  content.beacons = {{"O", {0, 0, 0}}, {"N", {100 * std::cos(0.7), 100 * std::sin(0.7), 0}}};
  const json features = features_of(content);
  const json &o = features[0]["geometry"]["coordinates"], &n = features[1]["geometry"]["coordinates"];
  EXPECT_EQ(o, json({11.6, 48.2, 520.0}));
  EXPECT_NEAR(n[0].get<double>(), 11.6, 1e-8) << "due north";
  EXPECT_GT(n[1].get<double>(), 48.2);
}

TEST(GeoJson, FixesThatAreNoneAreLeftOut) {
  ExportedContent content;
  NameTable names;
  names.vehicles = {"robot"};
  content.tracks = {{{fix_at(1, 0, 0, VehicleId(0)), fix_at(2, 1, 0, VehicleId(0), FixStatus::kAmbiguous),
                      fix_at(3, 2, 0, VehicleId(0))},
                     names}};
  const json features = features_of(content), fixes = of_kind(features, "fix"),
             tracks = of_kind(features, "track");
  ASSERT_EQ(fixes.size(), 2U);
  EXPECT_EQ(fixes[1]["properties"]["time_s"], 3.0);
  EXPECT_EQ(fixes[1]["properties"]["heading_rad"], 0.25);
  EXPECT_FALSE(fixes[1]["properties"].contains("sigma_x_m")) << "nothing is known of it";
  ASSERT_EQ(tracks.size(), 1U);
  EXPECT_EQ(tracks[0]["geometry"]["coordinates"].size(), 2U);
}

TEST(GeoJson, EachVehicleHasATrackOfItsOwn) {
  ExportedContent content;
  NameTable names;
  names.vehicles = {"a", "b"};
  ExportedFixes track{{}, names};
  for (int i = 0; i < 3; ++i) {
    track.fixes.push_back(fix_at(i, i, 0, VehicleId(0)));
    track.fixes.push_back(fix_at(i, i, 5, VehicleId(1)));
    track.fixes.push_back(fix_at(i, i, 9, VehicleId()));
  }
  track.fixes.push_back(fix_at(9, 9, 9, VehicleId(7)));  // of a vehicle without a name
  content.tracks = {track};
  const json tracks = of_kind(features_of(content), "track");
  ASSERT_EQ(tracks.size(), 3U);
  EXPECT_EQ(tracks[0]["properties"]["vehicle"], "a");
  EXPECT_EQ(tracks[1]["properties"]["vehicle"], "b");
  EXPECT_FALSE(tracks[2]["properties"].contains("vehicle"));
  EXPECT_EQ(tracks[2]["geometry"]["coordinates"].size(), 4U);
}

TEST(GeoJson, OnePointIsNoLine) {
  ExportedContent content;
  content.tracks = {{{fix_at(1, 0, 0, VehicleId())}, {}}};
  ExportedRun run;
  run.log.truth = {{1, Pose::planar(1, 2, 0)}};
  run.log.poses = {{1, Pose::planar(1, 2, 0)}, {2, Pose::planar(2, 2, 0)}};
  content.runs = {run};
  const json features = features_of(content);
  EXPECT_EQ(of_kind(features, "track").size(), 0U) << "RFC 7946: a line has two positions or more";
  EXPECT_EQ(of_kind(features, "truth").size(), 0U);
  EXPECT_EQ(of_kind(features, "poses").size(), 1U);
  EXPECT_EQ(of_kind(features, "fix").size(), 1U);
}

TEST(GeoJson, NamesAreTextWhateverTheyAre) {
  ExportedContent content;
  content.site = "a\"b\\c\n";
  content.beacons = {{"\xFF", {0, 0, 0}, 0.01}};
  const json all = json::parse(to_geojson(content, kHall));
  EXPECT_EQ(all["octant"]["site"], "a\"b\\c\n");
  EXPECT_EQ(all["features"][0]["properties"]["id"], "\xEF\xBF\xBD") << "what is no UTF-8 is replaced";
  EXPECT_EQ(all["features"][0]["properties"]["sigma_m"], 0.01);
  EXPECT_EQ(all["octant"]["origin"]["north_rad"], 0.7);
}

}  // namespace geojson_test
}  // namespace octant::io
