// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant survey as a process.
#include <filesystem>
#include <regex>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace survey_test {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kAisles = std::string(OCTANT_SOURCE_DIR) + "/datasets/aisles/site.yaml";
const std::string kHall = std::string(OCTANT_SOURCE_DIR) + "/datasets/hall/";

constexpr double kSmallMb = with_sanitizer_mb(60), kLargeMb = with_sanitizer_mb(200);

std::string aisles(const std::string& what, const std::string& by) {
  std::string text = slurp(kAisles);
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST(SurveyCommand, KeysOfTheContract) {
  const Outcome survey = octant({"survey", kAisles, "--json", "--cell", "0.5"});
  EXPECT_EQ(survey.exit, 0) << survey.err;
  const auto object = survey.json();
  EXPECT_EQ(object["status"], "ok");
  EXPECT_GT(object["cells"], 1000);
  for (const char* key : {"min", "median", "p95", "max"}) EXPECT_TRUE(object["hdop"][key].is_number()) << key;
  EXPECT_GT(object["covered_fraction"], 0.5);
  EXPECT_LE(object["covered_fraction"], object["fix_fraction"]);
  EXPECT_EQ(object["beacons"], 18);
  EXPECT_EQ(object["failures"].size(), 18u);
  EXPECT_EQ(object["routes"].size(), 3u);
  EXPECT_FALSE(object.contains("maps"));
  const auto bins =
      octant({"survey", kAisles, "--json", "--cell", "0.5", "--bins", "20"}).json()["maps"]["sigma_m"];
  EXPECT_EQ(bins["rows"].size(), 12u);
  EXPECT_EQ(bins["rows"][0].size(), 20u);
}

/// JSON is YAML, and a script writes it.
TEST(SurveyCommand, ASiteFileMayBeJson) {
  const TemporaryFolder folder;
  spit(
      folder / "site.yaml",
      R"({"octant_site": 1, "motion": "planar", "medium": {"model": "constant", "speed_mps": 343}, "noise": {"tof_sigma_s": 1e-5},
  "beacons": [{"id": "A", "position_m": [0, 0, 2], "sigma_m": 0}, {"id": "B", "position_m": [8, 0, 2], "sigma_m": 0},
              {"id": "C", "position_m": [4, 6, 2], "sigma_m": 0}],
  "vehicles": [{"id": "robot", "receivers": [{"id": "r0", "position_m": [0, 0, 0.3], "sigma_m": 0.001}]}]})");
  const Outcome survey = octant({"survey", folder / "site.yaml", "--json"});
  EXPECT_EQ(survey.exit, 0) << survey.err;
  EXPECT_EQ(survey.json()["beacons"], 3);
}

TEST(SurveyCommand, VerdictFirstInTenLinesTheRestWithV) {
  const TemporaryFolder folder;
  spit(folder / "site.yaml", aisles("cell_m: 0.25", "cell_m: 1"));
  const Outcome brief = octant({"survey", folder / "site.yaml"}),
                all = octant({"survey", folder / "site.yaml", "-v"});
  EXPECT_TRUE(brief.out.starts_with("verdict          Not good enough: ")) << brief.out;
  EXPECT_THAT(brief.out, HasSubstr("\nnext "));
  EXPECT_THAT(brief.out, HasSubstr("\ndilution         HDOP median "));
  std::size_t lines = 0;
  std::istringstream in(brief.out);
  for (std::string line; std::getline(in, line); ++lines) EXPECT_LE(line.size(), 80U) << line;
  EXPECT_LE(lines, 16U) << brief.out;
  EXPECT_TRUE(all.out.starts_with(brief.out)) << "the same, and more";
  EXPECT_THAT(all.out, HasSubstr("heading_dop_rad_per_m"));
  const auto json = octant({"survey", folder / "site.yaml", "--json"}).json();
  EXPECT_EQ(json["verdict"]["grade"], "Not good enough");
  EXPECT_FALSE(json["verdict"]["next"].empty());
}

TEST(SurveyCommand, EachColumnIsExplained) {
  const TemporaryFolder folder;
  spit(folder / "site.yaml", aisles("cell_m: 0.25", "cell_m: 1"));
  ASSERT_EQ(octant({"survey", folder / "site.yaml", "--maps", folder / "maps", "-q"}).exit, 0);
  const auto files = nlohmann::json::parse(octant({"schema", "survey"}).out)["x-files"];
  const auto routes = nlohmann::json::parse(octant({"schema", "routes.csv"}).out);
  EXPECT_EQ(routes["x-files"], (nlohmann::json{{"routes.csv", files["routes.csv"]}})) << "that file alone";
  EXPECT_FALSE(routes.contains("properties"));
  for (const char* file : {"cells.csv", "routes.csv"}) {
    const std::string text = slurp(folder / (std::string("maps/") + file));
    std::istringstream heads(text.substr(0, text.find('\n')));
    std::size_t columns = 0;
    for (std::string name; std::getline(heads, name, ','); ++columns)
      EXPECT_TRUE(files[file]["columns"].contains(name)) << file << ": " << name;
    EXPECT_GT(columns, 10U);
  }
}

// Only the recording determines the range of reception: the calibration stores it.
TEST(SurveyCommand, ADeploymentKeepsHowFarItHeard) {
  const TemporaryFolder folder;
  spit(folder / "scenario.yaml", slurp(std::string(OCTANT_SOURCE_DIR) + "/datasets/hall/scenario.yaml"));
  ASSERT_EQ(octant({"simulate", folder / "scenario.yaml", "-o", folder / "hall", "-q"}).exit, 0);
  ASSERT_THAT(slurp(folder / "hall/site.yaml"), Not(HasSubstr("attenuation"))) << "which would tell";
  // Beacons farther than nine metres were not received.
  std::istringstream rows(slurp(folder / "hall/run/tof.csv"));
  std::string near, row;
  for (bool head = true; std::getline(rows, row); head = false) {
    const std::size_t first = row.find(','), second = row.find(',', first + 1);
    if (head || std::stod(row.substr(second + 1)) < 9.0 / 345.5) near += row + "\n";
  }
  spit(folder / "hall/run/tof.csv", near);
  ASSERT_EQ(
      octant({"calibrate", folder / "hall/site.yaml", folder / "hall/run", "-o", folder / "d.json", "-q"})
          .exit,
      0);
  const double kept = nlohmann::json::parse(slurp(folder / "d.json"))["validity"]["reach_m"];
  EXPECT_NEAR(kept, 9.0, 0.3);
  const Outcome text = octant({"survey", folder / "d.json"});
  EXPECT_THAT(text.out, HasSubstr("\nreach            "));
  EXPECT_THAT(text.out, Not(HasSubstr("everywhere")));
  EXPECT_NEAR(octant({"survey", folder / "d.json", "--json", "--failures", "0"}).json()["reach_m"], kept,
              1e-9);
  EXPECT_EQ(octant({"plan", folder / "d.json", "--schedule", "--json"}).exit, 0) << "it needs a reach";
}

TEST(SurveyCommand, SaysWhoFiresWhen) {
  const TemporaryFolder folder;
  spit(folder / "site.yaml", aisles("cell_m: 0.25", "cell_m: 0.5"));
  const Outcome text =
      octant({"survey", folder / "site.yaml", "--failures", "0", "-v", "-o", folder / "r.md"});
  ASSERT_EQ(text.exit, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("fires at"));
  EXPECT_THAT(text.out, HasSubstr("\ncycle            "));
  EXPECT_THAT(slurp(folder / "r.md"), HasSubstr("## Firing schedule"));
  auto planned = octant({"plan", folder / "site.yaml", "--schedule", "--json"}).json();
  auto told = octant({"survey", folder / "site.yaml", "--json", "--failures", "0"}).json()["schedule"];
  std::size_t beacons = 0;
  for (const auto& group : told["groups"]) beacons += group["beacons"].size();
  EXPECT_EQ(beacons, 18U);
  for (const auto& [key, value] : told.items())
    EXPECT_EQ(value, planned[key]) << key;  // the same as when asked for
  // The range of a pulse is unknown: no schedule, and no error.
  spit(folder / "site.yaml",
       aisles("  acoustics: {frequency_hz: 40000, amplitude_1m_v: 8.0, threshold_v: 0.02}\n", ""));
  const auto silent = octant({"survey", folder / "site.yaml", "--json", "--cell", "0.5", "--failures", "0"});
  EXPECT_EQ(silent.exit, 0) << silent.err;
  EXPECT_TRUE(silent.json().at("schedule").is_null());
}

TEST(SurveyCommand, WritesPageTableAndEveryMap) {
  const TemporaryFolder folder;
  const Outcome survey = octant({"survey", kAisles, "--cell", "0.5", "-o", folder / "r.html", "--csv",
                                 folder / "c.csv", "--maps", folder / "maps"});
  EXPECT_EQ(survey.exit, 0) << survey.err;
  EXPECT_THAT(std::regex_replace(survey.out, std::regex("\\s+"), " "),
              HasSubstr("of the floor is within the tolerance of 10 mm"));
  EXPECT_THAT(slurp(folder / "r.html"), HasSubstr("default-src 'none'"));
  EXPECT_THAT(slurp(folder / "c.csv"), HasSubstr("x_m,y_m,sigma_m,"));
  for (const char* file : {"sigma_m.svg", "sigma_m.png", "sigma_m.pgm", "sigma_m.yaml", "hdop.png",
                           "loss_two_m.svg", "cells.csv", "routes.csv"})
    EXPECT_TRUE(std::filesystem::exists(folder / (std::string("maps/") + file))) << file;
  EXPECT_EQ(slurp(folder / "maps/hdop.png").substr(1, 3), "PNG");
  // A map of its own that the next survey reads as a scene.
  spit(folder / "scene.yaml",
       "octant_scene: 1\nimport: [{ros_map: maps/mirror.yaml, top_m: 0.1}]\ncell_m: 0.5\n");
  const Outcome again = octant({"survey", kAisles, "--scene", folder / "scene.yaml", "--json"});
  EXPECT_EQ(again.exit, 0) << again.err;
}

TEST(SurveyCommand, ADeploymentBringsTheCalibrationsPart) {
  const Outcome survey = octant({"survey", kHall + "deployment.true.json", "--json", "--failures", "0"});
  EXPECT_EQ(survey.exit, 0) << survey.err;
  EXPECT_EQ(survey.json()["calibrated"], false);  // the truth is exact
  const TemporaryFolder folder;
  ASSERT_EQ(octant({"calibrate", kHall + "site.yaml", kHall + "run", "-o", folder / "d.json", "-q"}).exit, 0);
  const auto object = octant({"survey", folder / "d.json", "--json", "--failures", "0"}).json();
  EXPECT_EQ(object["calibrated"], true);
  EXPECT_GT(object["calibration_m"]["median"], 0.0);
  EXPECT_GE(object["total_m"]["median"], object["sigma_m"]["median"]);
  EXPECT_FALSE(object.contains("loss_one_m"));
}

TEST(SurveyCommand, BadScenesAreExit3AndNamed) {
  const TemporaryFolder folder;
  double largest_mb = 0.0;
  const auto error_of = [&](const std::string& text, const std::vector<std::string>& more = {}) {
    spit(folder / "site.yaml", text);
    std::vector<std::string> words = {"survey", folder / "site.yaml", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome bad = octant(words);
    EXPECT_EQ(bad.exit, 3) << bad.out << bad.err;
    largest_mb = bad.largest_mb;
    const auto object = bad.json();
    EXPECT_TRUE(object.is_object());
    return object.is_object() ? object["error"]["message"].get<std::string>() : std::string();
  };
  EXPECT_THAT(error_of(aisles("[30, 0], [30, 18], [0, 18]]", "[30, 18], [30, 0], [0, 18]]")),
              HasSubstr("the floor crosses itself"));
  EXPECT_THAT(error_of(aisles("[3, 3.4], [27, 3.4], [27, 5.6]", "[3, 3.4], [27, 5.6], [27, 3.4]")),
              HasSubstr("obstacle 'rack1' crosses itself"));
  EXPECT_THAT(error_of(aisles("position_m: [3.0, 0.5, 4.8]", "position_m: [5.0, 4.5, 2.0]")),
              HasSubstr("beacon 'C0'"));
  EXPECT_THAT(error_of(aisles("position_m: [3.0, 0.5, 4.8]", "position_m: [3.0, -4.5, 2.0]")),
              HasSubstr("outside the floor"));
  EXPECT_THAT(error_of(aisles("cell_m: 0.25", "cell_m: 0")), HasSubstr("cell_m"));
  EXPECT_THAT(error_of(slurp(kAisles), {"--cell", "0"}), HasSubstr("cell_m"));
  EXPECT_THAT(error_of(aisles("cell_m: 0.25", "cell_m: 0.0007")), HasSubstr("1.1e+09 cells"));
  EXPECT_LT(largest_mb, kSmallMb) << "refused before memory is taken";
  EXPECT_THAT(error_of(slurp(kAisles), {"--vehicle", "nobody"}), HasSubstr("nobody"));
  EXPECT_THAT(error_of(slurp(kAisles), {"--scene", folder / "nowhere.yaml"}), HasSubstr("nowhere.yaml"));
}

/// 100 x 100 m in cells of 0.1 m, forty directed beacons, sixty walls.
std::string million_cells() {
  std::string site = R"(octant_site: 1
motion: planar
medium: {model: cramer1993, temperature_degC: 20}
timing: {clock: synchronised, delay_per: none}
noise: {tof_sigma_s: 1.0e-5}
vehicles: [{receivers: [{id: r0, position_m: [0, 0, 0.3]}]}]
tolerance: {fix_m: 0.02}
)";
  std::string beacons = "beacons:\n", axes = "  beacons:\n", walls = "  walls:\n";
  for (int i = 0; i < 40; ++i) {
    const double x = 5 + 10 * (i % 10), y = 10 + 25 * (i / 10);
    beacons += fmt::format("  - {{id: B{}, position_m: [{}, {}, 4], sigma_m: 0.0}}\n", i, x, y);
    axes += fmt::format("    - {{id: B{}, axis: [{}, {}, -0.4]}}\n", i, i % 3 - 1, i % 2);
  }
  for (int i = 0; i < 60; ++i) {
    const double x = 3 + 37 * i % 90, y = 2 + 53 * i % 95;
    walls += fmt::format("    - {{points_m: [[{}, {}], [{}, {}]], top_m: {}}}\n", x, y, x + 6, y + i % 5,
                         1 + i % 4);
  }
  return site + beacons +
         "scene:\n  floor_m: [[0, 0], [100, 0], [100, 100], [0, 100]]\n  cell_m: 0.1\n"
         "  patterns: [{id: p, kind: cosine_power, exponent: 1.5, half_angle_rad: 1.5}]\n  beacon_pattern: "
         "p\n"
         "  acoustics: {frequency_hz: 40000, amplitude_1m_v: 300, threshold_v: 0.01}\n" +
         axes + walls;
}

TEST(SurveyCommand, AMillionCellsTakeLittleMemory) {
  const TemporaryFolder folder;
  spit(folder / "site.yaml", million_cells());
  const Outcome survey =
      octant({"survey", folder / "site.yaml", "--threads", "2", "--failures", "1", "--json"});
  ASSERT_EQ(survey.exit, 0) << survey.err;
  EXPECT_EQ(survey.json()["cells"], 1'000'000);
  EXPECT_GT(survey.json()["fix_fraction"], 0.5);
  EXPECT_LT(survey.largest_mb, kLargeMb);
}

}  // namespace survey_test
}  // namespace octant::test
