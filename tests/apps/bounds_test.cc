// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Absurdly large, deep or numerous content is refused early and in little memory.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace bounds_test {

using ::testing::HasSubstr;

constexpr std::uintmax_t kHuge = 10'000'000'000;  // bytes, which take no place on the disk
constexpr double kMost_mb = with_sanitizer_mb(100);

class Bounds : public HallFolder {
 protected:
  /// A sparse file that begins with a text and continues with zeros for ten gigabytes.
  static void huge(const std::string& path, const std::string& head) {
    spit(path, head);
    std::filesystem::resize_file(path, kHuge);
  }
  static void expect_refused(const std::vector<std::string>& words, const std::string& said) {
    const Outcome outcome = octant(words);
    EXPECT_EQ(outcome.exit, 3) << words.front() << ": " << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(said)) << words.front();
    EXPECT_LT(outcome.largest_mb, kMost_mb) << words.front() << ": " << outcome.err;
  }
  [[nodiscard]] std::vector<std::string> check() const { return {"check", hall("site.yaml"), hall("run")}; }
};

TEST_F(Bounds, ThreeBytesThatAYamlLibraryNeverEndedOn) {
  spit(out("site.yaml"), ",\n,");
  expect_refused({"check", out("site.yaml"), hall("run")}, "site.yaml:1:1: not YAML");
  spit(hall("run/run.yaml"), " , h@a");
  expect_refused(check(), "run.yaml:1:2: not YAML");
}

TEST_F(Bounds, YamlThatMultipliesIsTooMany) {
  std::string bomb = "octant_site: 1\na0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 9; ++k) bomb += (k > 0 ? ", *a" : "*a") + std::to_string(i - 1);
    bomb += "]\n";
  }
  std::string beacons = "octant_site: 1\nmotion: planar\nbeacons: [", deep = "octant_site: 1\nname: ";
  for (int i = 0; i < 1'300'000; ++i) beacons += "{id: B},";
  for (int i = 0; i < 1'000'000; ++i) deep += "- ";
  std::string directives, text = "octant_site: 1\nname: \"";
  for (int i = 0; i < 1'000'000; ++i) directives += "%TAG !a! b\n";
  const std::vector<std::pair<std::string, std::string>> all = {
      {bomb, "more than 1000000 values"},
      {"octant_site: 1\nname: &a [*a]\n", "within it"},
      {beacons, "more than 1000000 values"},
      {"octant_site: 1\nname: " + std::string(1'000'000, '['), "levels deep"},
      {"octant_site: 1\nname: " + std::string(1'000'000, '{'), "levels deep"},
      {deep, "not YAML"},
      {"octant_site: 1\nname:\n  " + deep.substr(21), "levels deep"},
      {directives, "directives"},
      {text + std::string(15'000'000, 'x'), "not YAML"},
      {text + std::string(17'000'000, 'x'), "at most 16 MB"}};
  for (const auto& [content, said] : all) {
    spit(out("site.yaml"), content);
    expect_refused({"check", out("site.yaml"), hall("run")}, said);
  }
}

TEST_F(Bounds, SitesScenesListsAndScenariosOfTenGigabytes) {
  for (const std::string head : {"octant_site: 1\n", "{\"type\": \"octant_deployment\",\n", "", "# "}) {
    huge(out("huge.yaml"), head);
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"check", out("huge.yaml"), hall("run")},
          {"calibrate", out("huge.yaml"), hall("run"), "-o", out("d.json")},
          {"survey", out("huge.yaml")},
          {"survey", hall("site.yaml"), "--scene", out("huge.yaml")},
          {"plan", out("huge.yaml"), "--stations", "2"},
          {"simulate", out("huge.yaml"), "-o", out("world")},
          {"batch", out("huge.yaml")}})
      expect_refused(words, "huge.yaml");
  }
}

TEST_F(Bounds, RecordingsInOneLineOfTenGigabytes) {
  const std::string line(2'000'000, '7');
  ASSERT_EQ(calibrate().exit, 0);
  const std::vector<std::pair<std::string, std::string>> all = {
      {"tof.csv", ""},
      {"tof.csv", "time_s,beacon,tof_s,epoch,receiver\n"},
      {"tof.csv", "time_s,beacon,tof_s,epoch,receiver\n\"" + line},
      {"bearings.csv", "time_s,reflector,bearing_rad\n"},
      {"odometry.csv", ""},
      {"odometry.csv", "time_s,dx_m,dy_m,dheading_rad\n0,0,0,0\n"},
      {"scans.csv", "time_s,angle_min_rad,angle_increment_rad,range0_m\n"},
      {"points.csv", "epoch,x_m,y_m\n"},
      {"poses.tum", "# "}};
  for (const auto& [name, head] : all) {
    const std::string before = std::filesystem::exists(hall("run/" + name)) ? slurp(hall("run/" + name)) : "";
    huge(hall("run/" + name), head + line);
    expect_refused(check(), name);
    expect_refused({"calibrate", hall("site.yaml"), hall("run"), "-o", out("e.json"), "--progress", "none"},
                   name);
    before.empty() ? (void)std::filesystem::remove(hall("run/" + name)) : spit(hall("run/" + name), before);
  }
  huge(hall("run/tof.csv"), "");
  expect_refused(check(), "tof.csv");
  huge(hall("run/run.yaml"), "octant_run: 1\n");
  expect_refused(check(), "run.yaml");
  huge(out("carmen.log"), "FLASER " + line);
  expect_refused({"convert", out("carmen.log"), "-o", out("run")}, "carmen.log");
  huge(out("counters.csv"), "time_s,beacon,counts\n" + line);
  expect_refused({"convert", out("counters.csv"), "--site", hall("site.yaml"), "-o", out("run")},
                 "counters.csv");
}

TEST_F(Bounds, DeploymentsThatNobodyWrote) {
  const std::vector<std::pair<std::string, std::string>> all = {
      {std::string(1'000'000, '['), ""},
      {"{\"a\": " + std::string(1'000'000, '['), "levels deep"},
      {"{\"a\": [" +
           [] {
             std::string objects;
             for (int i = 0; i < 5'000'000; ++i) objects += "{},";
             return objects;
           }(),
       "texts, lists and objects"},
      {"{\"a\": \"" + std::string(40'000'000, 'x'), "a text of more than 32 MB"}};
  for (const auto& [content, said] : all) {
    spit(out("d.json"), content);
    expect_refused({"localize", out("d.json"), hall("heldout"), "-o", out("f.tum")}, said);
  }
  for (const std::string head : {"{\"a\": ", "[", "", "{\"a\": \""}) {
    huge(out("d.json"), head);
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"localize", out("d.json"), hall("heldout"), "-o", out("f.tum")},
          {"verify", out("d.json"), hall("heldout")},
          {"monitor", out("d.json"), hall("heldout")},
          {"report", out("d.json"), "-o", out("r.html")},
          {"survey", out("d.json")}})
      expect_refused(words, "d.json");
  }
}

TEST_F(Bounds, PlansOfAbsurdSizes) {
  const auto survey_with = [&](const std::string& import) {
    spit(out("scene.yaml"),
         "octant_scene: 1\nfloor_m: [[0, 0], [9, 0], [9, 5]]\nimport:\n  - {" + import + "}\n");
    return std::vector<std::string>{"survey", hall("site.yaml"), "--scene", out("scene.yaml")};
  };
  const std::string dxf = "dxf: plan.dxf, layers: [W]";
  huge(out("plan.dxf"), "  0\nSECTION\n");
  expect_refused(survey_with(dxf), "plan.dxf");
  spit(out("plan.dxf"), "  0\nSECTION\n  2\n" + std::string(2'000'000, 'A') + "\n");
  expect_refused(survey_with(dxf), "plan.dxf");
  const std::string map = "ros_map: map.yaml";
  spit(out("map.yaml"), "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n");
  for (const std::string head : {"P5 1000000 1000000 255\n", "P5 4294967296 4294967296 255\n", "P2 9 9 255\n",
                                 "P5 18446744073709551615 2 255\n", "P5 -1 3 255\n", "#"}) {
    huge(out("map.pgm"), head);
    expect_refused(survey_with(map), "map.pgm");
  }
}

}  // namespace bounds_test
}  // namespace octant::test
