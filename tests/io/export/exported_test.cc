// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/export/exported.h"

#include <nlohmann/json.hpp>

#include "io/bag/bag_log.h"
#include "io/run/run_folder.h"
#include "io/run/tum.h"
#include "tests/io/io_support.h"

namespace octant::io::test {
namespace exported_test {

NameTable some_names() {
  NameTable names;
  names.beacons = {"B0", "Süd 1", "B,2"};
  names.vehicles = {"robot"};
  names.receivers = {{"r0", VehicleId(0)}, {"r1", VehicleId(0)}};
  return names;
}

/// A run with times as robots log them.
MeasurementLog some_run() {
  MeasurementLog log;
  log.path = "run";
  log.vehicle = VehicleId(0);
  log.temperature_degC = 19.25;
  for (int k = 0; k < 300; ++k) {
    Arrival a;
    a.time_s = 1700000000.25 + 0.07 * k;
    a.tof_s = 0.01 + 1e-5 * k / 3;
    a.beacon = BeaconId(static_cast<std::size_t>(k % 3));
    a.receiver = ReceiverId(static_cast<std::size_t>(k % 2));
    a.vehicle = VehicleId(0);
    if (k % 5 == 0) a.amplitude_v = 0.05 + 0.1 * k;
    if (k % 7 == 0) a.temperature_degC = 20.0 + k / 300.0;
    log.arrivals.push_back(a);
    log.odometry.push_back(
        {a.time_s, k == 0 ? 0.0 : 0.03, 0.001, k == 0 ? 0.0 : 0.02 * std::sin(k), VehicleId(0)});
    const Eigen::Quaterniond q = Eigen::Quaterniond(1.0, 0.1, -0.2, 0.3 * k).normalized();
    log.poses.push_back({a.time_s, {{0.1 * k, -0.2, 0.3}, q}});
    log.truth.push_back({a.time_s + 0.01, {{0.1 * k, -0.2, 0.4}, q}});
  }
  return log;
}

TEST(Exported, ARunGoesThroughMcapAndBack) {
  const TemporaryFolder box;
  const NameTable names = some_names();
  const MeasurementLog log = some_run();
  ExportedContent content;
  content.runs.push_back({log, names});
  const auto mcap = to_mcap(content);
  ASSERT_TRUE(mcap) << mcap.error().message();
  const std::string path = box.write("run.mcap", *mcap);
  const auto mapping = topics_by_type(path);
  ASSERT_TRUE(mapping) << mapping.error().message();
  auto imported = read_bag_log(path, *mapping);
  ASSERT_TRUE(imported) << imported.error().message();
  const auto files = run_files(*imported, "back", {});
  ASSERT_TRUE(files);
  for (const FileContent& file : *files) box.write(file.path, file.content);
  const auto back = read_run(box.path("back"), names, {}, {.read_truth = true});
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_TRUE(back->warnings.empty());
  ASSERT_EQ(back->arrivals.size(), log.arrivals.size());
  const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  for (std::size_t i = 0; i < log.arrivals.size(); ++i) {
    const Arrival &a = log.arrivals[i], &b = back->arrivals[i];
    EXPECT_TRUE(a.time_s == b.time_s && a.tof_s == b.tof_s && a.beacon == b.beacon &&
                a.receiver == b.receiver && same(a.amplitude_v, b.amplitude_v) &&
                same(a.temperature_degC, b.temperature_degC))
        << i;
  }
  EXPECT_EQ(back->temperature_degC, log.temperature_degC);
  ASSERT_EQ(back->odometry.size(), log.odometry.size());
  for (std::size_t i = 1; i < log.odometry.size(); ++i) {
    // Accumulated and differentiated again, in poses of some metres.
    EXPECT_NEAR(back->odometry[i].dx_m, log.odometry[i].dx_m, 1e-14);
    EXPECT_NEAR(back->odometry[i].dy_m, log.odometry[i].dy_m, 1e-14);
    EXPECT_NEAR(back->odometry[i].dheading_rad, log.odometry[i].dheading_rad, 1e-14);
  }
  for (const auto& [a, b] : {std::pair(&log.poses, &back->poses), std::pair(&log.truth, &back->truth)}) {
    ASSERT_EQ(a->size(), b->size());
    for (std::size_t i = 0; i < a->size(); ++i) {
      // Stamps are whole nanoseconds; doubles of this size are 240 ns apart.
      EXPECT_EQ((*a)[i].time_s, (*b)[i].time_s);
      EXPECT_EQ((*a)[i].T_map_vehicle.translation_m, (*b)[i].T_map_vehicle.translation_m);
      EXPECT_EQ((*a)[i].T_map_vehicle.rotation.coeffs(), (*b)[i].T_map_vehicle.rotation.coeffs());
    }
  }
}

std::vector<Fix> some_fixes() {
  std::vector<Fix> fixes(3);
  for (std::size_t i = 0; i < 3; ++i) {
    Fix& fix = fixes[i];
    fix.time_s = 10.5 + static_cast<double>(i);
    fix.vehicle = VehicleId(0);
    fix.status = i == 1 ? FixStatus::kNoConsensus : FixStatus::kOk;
    fix.arrivals_used = 5;
    fix.arrivals_rejected = 1;
    if (!fix.ok()) continue;
    fix.T_map_vehicle = Pose::planar(1.0 + static_cast<double>(i), -2.0, 0.5);
    fix.covariance = Eigen::Vector3d(4e-6, 9e-6, 1e-4).asDiagonal();
    fix.protection_level_m = 0.0625;
  }
  return fixes;
}

TEST(Exported, FixesReadBackFromTheirTable) {
  const TemporaryFolder box;
  const auto fixes = some_fixes();
  const auto back = read_fixes(box.write("fixes.csv", fixes_to_csv(fixes, some_names())));
  ASSERT_TRUE(back) << back.error().message();
  ASSERT_EQ(back->fixes.size(), 3U);
  EXPECT_EQ(back->names.vehicles, std::vector<std::string>{"robot"});
  for (std::size_t i = 0; i < 3; ++i) {
    const Fix &a = fixes[i], &b = back->fixes[i];
    EXPECT_EQ(a.time_s, b.time_s);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.arrivals_used, b.arrivals_used);
    if (!a.ok()) continue;
    EXPECT_EQ(a.T_map_vehicle.translation_m, b.T_map_vehicle.translation_m);
    EXPECT_EQ(a.protection_level_m, b.protection_level_m);
    EXPECT_NEAR(a.covariance(1, 1), b.covariance(1, 1), 1e-18);
  }
  const auto tum = read_fixes(box.write("fixes.tum", fixes_to_tum(fixes)));
  ASSERT_TRUE(tum);
  EXPECT_EQ(tum->fixes.size(), 2U);
  std::string odd = fixes_to_csv(fixes, some_names());
  odd.replace(odd.find("no_consensus"), 12, "no_clue");
  expect_error(read_fixes(box.write("odd.csv", odd)), 3, "no_clue");
}

TEST(Exported, McapHasTheFixesAsPosesAndAsRows) {
  const TemporaryFolder box;
  ExportedContent content;
  content.beacons = {{"B0", {1, 2, 3}, 0.01}};
  content.tracks.push_back({some_fixes(), some_names()});
  const auto mcap = to_mcap(content);
  ASSERT_TRUE(mcap);
  const auto mapping = topics_from_words("truth=/octant/fix");
  ASSERT_TRUE(mapping);
  const auto log = read_bag_log(box.write("fixes.mcap", *mcap), *mapping);
  ASSERT_TRUE(log) << log.error().message();
  ASSERT_EQ(log->truth.size(), 2U);
  EXPECT_EQ(log->truth[1].time_s, 12.5);
  EXPECT_EQ(log->truth[1].T_map_vehicle.translation_m.x(), 3.0);
  EXPECT_THAT(*mcap, testing::HasSubstr(R"("status":"no_consensus","arrivals_used":5)"));
  EXPECT_THAT(*mcap, testing::HasSubstr(R"("protection_level_m":0.0625)"));
  content.tracks[0].fixes[0].time_s = -1.0;
  expect_error(to_mcap(content), 0, "which MCAP counts in nanoseconds");
}

/// foxglove.SceneEntity wants lists, of one too.
TEST(Exported, McapHasTheBeaconsAsAScene) {
  ExportedContent content;
  content.beacons = {{.id = "Süd 1", .position_m = {1.5, -2, 2.25}, .sigma_m = 0.01}};
  const auto mcap = to_mcap(content);
  ASSERT_TRUE(mcap);
  const std::string tail = "\"Süd 1\"}]}]}";
  const std::size_t end = mcap->find(tail), begin = mcap->rfind(R"({"deletions":)", end);
  ASSERT_TRUE(begin != std::string::npos && end != std::string::npos);
  const auto scene = nlohmann::json::parse(mcap->substr(begin, end + tail.size() - begin), nullptr, false);
  ASSERT_FALSE(scene.is_discarded());
  const auto& entity = scene.at("entities").at(0);
  for (const char* list : {"spheres", "texts"}) {
    ASSERT_TRUE(entity.at(list).is_array()) << list;
    EXPECT_EQ(entity.at(list).at(0).at("pose").at("position").at("z"), 2.25);
  }
  EXPECT_EQ(entity.at("texts").at(0).at("text"), "Süd 1");
}

TEST(Exported, GeoJsonIsLongitudeFirst) {
  ExportedContent content;
  content.site = "hall";
  content.beacons = {{"B0", {100, 0, 3}, 0.01}};
  content.tracks.push_back({some_fixes(), some_names()});
  const auto json = nlohmann::json::parse(to_geojson(content, {45.0, 9.0, 120.0, 1.5707963267948966}));
  EXPECT_EQ(json["type"], "FeatureCollection");
  ASSERT_EQ(json["features"].size(), 4U) << "a beacon, two fixes, their track";
  const auto& beacon = json["features"][0];
  EXPECT_EQ(beacon["properties"]["id"], "B0");
  // A degree of longitude at 45 degrees north is 78846.8 m on WGS 84, more so high above it.
  EXPECT_NEAR(beacon["geometry"]["coordinates"][0].get<double>(),
              9.0 + 100 / (78846.8 * (1 + 123 / 6.388838e6)), 1e-8);
  EXPECT_NEAR(beacon["geometry"]["coordinates"][1].get<double>(), 45.0, 1e-8);
  EXPECT_NEAR(beacon["geometry"]["coordinates"][2].get<double>(), 123.0, 1e-3);
  EXPECT_EQ(json["features"][1]["properties"]["protection_level_m"], 0.0625);
  EXPECT_EQ(json["features"][3]["geometry"]["type"], "LineString");
}

}  // namespace exported_test
}  // namespace octant::io::test
