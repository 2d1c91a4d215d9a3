// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant plan as a process: stops, beacons, schedules; exit codes, one JSON object, outputs whole or not at
// all.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace plan_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Plan : public ::testing::Test {
 protected:
  /// The bundled hall with a floor, mounts and a range.
  void SetUp() override {
    const std::string fewer = std::regex_replace(
        hall_scenario_text(), std::regex("epochs: [0-9]+, epoch_period_s"), "epochs: 30, epoch_period_s");
    spit(box / "scenario.yaml", fewer);
    ASSERT_EQ(octant({"simulate", box / "scenario.yaml", "-o", box / "hall"}).exit, 0);
    site = box / "site.yaml";
    spit(site, "# mine\n" + slurp(box / "hall/site.yaml") + R"(
scene:
  floor_m: [[0, 0], [20, 0], [20, 12], [0, 12]]
  cell_m: 0.5
  mounts:
    - {id: walls, kind: wall, points_m: [[0, 0], [20, 0], [20, 12], [0, 12], [0, 0]], height_m: [2.0, 3.0]}
  acoustics: {range_m: 18.0}
)");
  }
  [[nodiscard]] Outcome plan(std::vector<std::string> more) const {
    std::vector<std::string> words = {"plan", site, "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    return octant(words);
  }
  TemporaryFolder box;
  std::string site;
};

TEST_F(Plan, StopsAsTextJsonAndCsv) {
  const Outcome text = plan({"--stations", "3", "--grid", "3", "--csv", box / "stops.csv"});
  EXPECT_EQ(text.exit, 0) << text.err;
  for (const char* word : {"3 stops, the best first", "heading", "8 of 8", "random stops"})
    EXPECT_THAT(text.out, HasSubstr(word));
  std::istringstream lines(text.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  EXPECT_THAT(slurp(box / "stops.csv"), HasSubstr("order,x_m,y_m,heading_rad"));
  const auto object = plan({"--stations", "3", "--grid", "3", "--json"}).json();
  EXPECT_EQ(object["status"], "ok");
  ASSERT_EQ(object["stations"].size(), 3U);
  // The checklist has them in the same order.
  const std::string csv = slurp(box / "stops.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& stop = object["stations"][i];
    EXPECT_THAT(csv, HasSubstr(fmt::format("\n{},{:.3f},{:.3f},{:.4f},", i + 1, stop["x_m"].get<double>(),
                                           stop["y_m"].get<double>(), stop["heading_rad"].get<double>())));
  }
  double sigma = object["before"]["mean_sigma_m"];
  for (const auto& stop : object["stations"]) {
    EXPECT_LT(stop["mean_sigma_m"].get<double>(), sigma);
    sigma = stop["mean_sigma_m"];
    EXPECT_GT(stop["x_m"].get<double>(), 0.49);
    EXPECT_LT(stop["y_m"].get<double>(), 11.51);
  }
  EXPECT_DOUBLE_EQ(sigma, object["after"]["mean_sigma_m"].get<double>());
  EXPECT_LT(sigma, object["random_mean_sigma_m"].get<double>());
  EXPECT_EQ(object["beacons"].size(), 8U);
}

TEST_F(Plan, StopsWhereAllBeaconsAreHeldImproveNone) {
  spit(site, std::regex_replace(slurp(site), std::regex("(position_m: \\[[^\\]]*\\], sigma_m: )[0-9.e-]+"),
                                "$010"));
  spit(site, std::regex_replace(slurp(site), std::regex("floor_m: .*"),
                                "floor_m: [[-2, -2], [22, -2], [22, 14], [-2, 14]]"));
  const Outcome held = plan({"--stations", "3", "--grid", "3"});
  EXPECT_EQ(held.exit, 3);
  EXPECT_THAT(held.err, HasSubstr("all 8 beacons are control points (sigma_m: 0)"));
}

TEST_F(Plan, StopsAfterARecordingAndAfterADeployment) {
  const auto after_run = plan({box / "hall/run", "--stations", "2", "--grid", "3", "--json"});
  ASSERT_EQ(after_run.exit, 0) << after_run.out;
  ASSERT_EQ(octant({"calibrate", site, box / "hall/run", "-o", box / "d.json", "-q"}).exit, 0);
  const auto after_deployment = octant({"plan", box / "d.json", "--stations", "2", "--grid", "3", "--range",
                                        "12", "--json", "--progress", "none"});
  ASSERT_EQ(after_deployment.exit, 0) << after_deployment.out;
  const double a = after_run.json()["before"]["mean_sigma_m"],
               b = after_deployment.json()["before"]["mean_sigma_m"];
  EXPECT_NEAR(a, b, 1e-6 * a) << "both know what the calibration knew";
  EXPECT_LT(after_run.json()["after"]["mean_sigma_m"].get<double>(), a);
  EXPECT_EQ(octant({"plan", box / "d.json", box / "hall/run", "--stations", "2", "--json"}).exit, 2);
}

TEST_F(Plan, BeaconsThatARecordingFindsAreNotSaidToBeLeftOut) {
  std::string text = slurp(site);
  const std::size_t at = text.find("id: B5"), end = text.find('}', at);
  ASSERT_NE(end, std::string::npos);
  text.replace(at, end - at, "id: B5");
  spit(box / "cold.yaml", text);
  const Outcome planned = octant(
      {"plan", box / "cold.yaml", box / "hall/run", "--stations", "1", "--grid", "3", "--progress", "none"});
  ASSERT_EQ(planned.exit, 0) << planned.err;
  EXPECT_THAT(planned.err, Not(HasSubstr("left out")));
  EXPECT_THAT(octant({"plan", box / "cold.yaml", "--stations", "1", "--grid", "3", "--progress", "none"}).err,
              HasSubstr("beacon 'B5' has no known place and is left out"));
}

TEST_F(Plan, BeaconsIntoANewSiteThatCanBeSurveyed) {
  const std::vector<std::string> cheap = {"--evaluations", "40", "--algorithm", "none", "--restarts", "0"};
  auto words = cheap;
  words.insert(words.end(),
               {"--beacons", "4", "-o", box / "new.yaml", "--report", box / "proof.html", "--json"});
  const Outcome made = plan(words);
  ASSERT_EQ(made.exit, 0) << made.out << made.err;
  const auto object = made.json();
  EXPECT_EQ(object["beacons"].size(), 4U);
  EXPECT_EQ(object["proof"].size(), 1U);
  EXPECT_LE(object["figures"]["objective_m"].get<double>(),
            object["proof"][0]["greedy"]["objective_m"].get<double>());
  EXPECT_THAT(slurp(box / "proof.html"), HasSubstr("</html>"));
  const std::string text = slurp(box / "new.yaml");
  EXPECT_THAT(text, HasSubstr("id: B3"));
  EXPECT_EQ(text.find("id: B4"), std::string::npos);
  EXPECT_EQ(octant({"survey", box / "new.yaml", "--json", "--failures", "0"}).exit, 0);
  auto keep = cheap;
  keep.insert(keep.end(), {"--beacons", "9", "--keep", "-o", "-"});
  const Outcome kept = plan(keep);
  EXPECT_EQ(kept.exit, 0) << kept.err;
  EXPECT_THAT(kept.out, HasSubstr("id: B7"));
  EXPECT_THAT(kept.out, HasSubstr("id: B8"));
  EXPECT_THAT(kept.err, HasSubstr("9 beacons"));
}

TEST_F(Plan, AToleranceOutOfReachIsExit6) {
  const Outcome never = plan({"--tolerance", "1e-6", "--most", "4", "--evaluations", "20", "--algorithm",
                              "none", "--restarts", "0", "--json"});
  EXPECT_EQ(never.exit, 6) << never.out;
  const auto object = never.json();
  EXPECT_EQ(object["status"], "gate_failed");
  EXPECT_FALSE(object["reached"].get<bool>());
  EXPECT_EQ(object["beacons"].size(), 4U);
}

TEST_F(Plan, ScheduleOfTheHall) {
  const Outcome text = plan({"--schedule", "--wall-reflection", "0.7"});
  EXPECT_EQ(text.exit, 0) << text.err;
  for (const char* word : {"Kleeman's eq. 1", "cycle", "fires at", "Eyring"})
    EXPECT_THAT(text.out, HasSubstr(word));
  const auto object = plan({"--schedule", "--json"}).json();
  std::size_t beacons = 0;
  for (const auto& group : object["groups"]) beacons += group["beacons"].size();
  EXPECT_EQ(beacons, 8U);
  EXPECT_DOUBLE_EQ(object["cycle_s"].get<double>(),
                   object["slot_s"].get<double>() * static_cast<double>(object["groups"].size()));
  EXPECT_EQ(octant({"plan", box / "hall/site.yaml", "--schedule", "--json"}).exit, 3)
      << "nothing says how far a pulse is heard";
}

TEST_F(Plan, WrongWordsAndBadInput) {
  EXPECT_EQ(plan({}).exit, 2);
  EXPECT_EQ(plan({"--stations", "2", "--schedule"}).exit, 2);
  EXPECT_EQ(plan({"--beacons", "3", "--csv", box / "x.csv"}).exit, 2);
  EXPECT_EQ(plan({"--stations", "2", "-o", box / "x.yaml"}).exit, 2);
  EXPECT_EQ(plan({"--stations", "2", "--csv", "-", "--json"}).exit, 2);
  EXPECT_EQ(plan({"--beacons", "3", "--algorithm", "newton"}).exit, 2);
  const Outcome no_mounts = octant({"plan", box / "hall/site.yaml", "--beacons", "3", "--json"});
  EXPECT_EQ(no_mounts.exit, 3);
  EXPECT_THAT(no_mounts.json()["error"]["found"].get<std::string>(), HasSubstr("no floor"));
  EXPECT_EQ(plan({"--stations", "2", "--clearance", "7"}).exit, 3);
  EXPECT_EQ(plan({"--beacons", "3", "-o", box / "nowhere/new.yaml", "--json"}).exit, 3);
  EXPECT_EQ(octant({"plan", box / "missing.yaml", "--schedule", "--json"}).exit, 3);
  EXPECT_THAT(box.names(), ElementsAre("hall", "scenario.yaml", "site.yaml"))
      << "nothing is written on failure";
}

TEST_F(Plan, HelpSaysWhatIsPlanned) {
  const Outcome help = octant({"plan", "--help"});
  EXPECT_EQ(help.exit, 0);
  for (const char* word : {"--beacons", "--stations", "--schedule", "--keep", "Where to stop next",
                           "octant plan hall/site.yaml --stations 5"})
    EXPECT_THAT(help.out, HasSubstr(word));
}

}  // namespace plan_test
}  // namespace octant::test
