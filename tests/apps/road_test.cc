// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The road from a recording to a position, walked with the program as a process.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace road_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Road : public HallFolder {};

TEST_F(Road, SimulateMakesAWorldAndReplacesOnlyWorlds) {
  for (const char* name : {"site.yaml", "run/tof.csv", "run/run.yaml", "heldout/tof.csv", "heldout/truth.tum",
                           "deployment.true.json"}) {
    EXPECT_TRUE(std::filesystem::exists(hall(name))) << name;
  }
  const std::string before = slurp(hall("run/tof.csv"));
  EXPECT_EQ(octant({"simulate", box / "scenario.yaml", "-o", box / "hall"}).exit, 0);
  EXPECT_EQ(slurp(hall("run/tof.csv")), before) << "the same seed gives the same world";
  EXPECT_EQ(octant({"simulate", box / "scenario.yaml", "-o", box / "hall", "--seed", "2"}).exit, 0);
  EXPECT_NE(slurp(hall("run/tof.csv")), before);

  spit(hall("run/thesis.txt"), "years of work");
  const Outcome refused = octant({"simulate", box / "scenario.yaml", "-o", box / "hall", "--json"});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.json()["error"]["message"].get<std::string>(), HasSubstr("thesis.txt"));
  EXPECT_EQ(slurp(hall("run/thesis.txt")), "years of work");
  EXPECT_EQ(octant({"simulate", box / "scenario.yaml", "-o", box / "scenario.yaml"}).exit, 3);
  EXPECT_THAT(box.names(), ElementsAre("hall", "out", "scenario.yaml")) << "nothing temporary stays";
}

TEST_F(Road, SimulateIntoTheFolderWhereOneStands) {
  std::filesystem::create_directory(box / "here");
  EXPECT_EQ(octant({"simulate", box / "scenario.yaml", "-o", "."}, {.folder = box / "here"}).exit, 0);
  EXPECT_TRUE(std::filesystem::exists(box / "here/site.yaml"));
  EXPECT_THAT(box.names(), ElementsAre("hall", "here", "out", "scenario.yaml"));
}

TEST_F(Road, CalibrateSaysWhatTheContractNames) {
  const Outcome done = calibrate({"--json"});
  ASSERT_EQ(done.exit, 0) << done.err;
  const auto object = done.json();
  ASSERT_TRUE(object.is_object()) << done.out;
  for (const char* key : {"status",          "converged", "iterations", "seconds",
                          "arrivals",        "rejected",  "unknowns",   "redundancy",
                          "variance_factor", "chi2_p",    "rms_s",      "speed_mps",
                          "speed_sigma_mps", "beacons",   "receivers",  "attenuation",
                          "undetermined",    "warnings",  "weak",       "datum",
                          "left_out"}) {
    EXPECT_TRUE(object.contains(key)) << key;
  }
  EXPECT_EQ(object["status"], "ok");
  EXPECT_EQ(object["converged"], true);
  ASSERT_EQ(object["beacons"].size(), 8u);
  EXPECT_EQ(object["beacons"][0]["id"], "B0");
  EXPECT_EQ(object["beacons"][0]["status"], "control_point");
  EXPECT_EQ(object["beacons"][1]["position_m"].size(), 3u);
  EXPECT_EQ(object["beacons"][1]["sigma_m"].size(), 3u);
  for (const char* kind : {"arrivals", "bearings", "poses"}) {
    ASSERT_TRUE(object["left_out"].contains(kind)) << kind;
    EXPECT_TRUE(object["left_out"][kind].contains("total") && object["left_out"][kind].contains("by_reason"))
        << kind;
  }
  EXPECT_EQ(object["left_out"]["arrivals"]["total"], object["rejected"]);
  EXPECT_EQ(object["receivers"].size(), 8u);
  EXPECT_EQ(object["receivers"][0]["vehicle"], "robot");
  EXPECT_THAT(outputs(), ElementsAre("d.json"));
}

TEST_F(Road, CalibrateForPeople) {
  const Outcome done = octant({"calibrate", hall("site.yaml"), hall("run"), "-o", box / "out/d.json",
                               "--report", box / "out/r.html"});
  ASSERT_EQ(done.exit, 0) << done.err;
  // The verdict first, some lines that fit a terminal.
  EXPECT_TRUE(done.out.starts_with("verdict          Good: ")) << done.out;
  EXPECT_LE(std::count(done.out.begin(), done.out.end(), '\n'), 20) << done.out;
  std::istringstream in(done.out.substr(0, done.out.find("\ndeployment ")));
  for (std::string line; std::getline(in, line);) EXPECT_LE(line.size(), 80U) << line;
  for (const char* word : {"moved from site", "speed", "variance factor", "next ", "d.json", "r.html"})
    EXPECT_THAT(done.out, HasSubstr(word));
  const Outcome verbose =
      octant({"calibrate", hall("site.yaml"), hall("run"), "-o", box / "out/d.json", "-v"});
  for (const char* word : {"B7", "control point", "datum", "redundancy"})
    EXPECT_THAT(verbose.out, HasSubstr(word));
  EXPECT_THAT(done.err, HasSubstr(" % "));  // plain progress lines where there is no terminal
  EXPECT_THAT(done.err, Not(HasSubstr("\r")));
  EXPECT_THAT(slurp(box / "out/r.html"), HasSubstr("<svg"));
  EXPECT_THAT(octant({"calibrate", hall("site.yaml"), hall("run"), "-o", box / "out/d.json", "-q"}).err,
              Not(HasSubstr(" % ")));
}

TEST_F(Road, CalibrateToStandardOutput) {
  const Outcome done = octant({"calibrate", hall("site.yaml"), hall("run"), "-o", "-", "-q"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(nlohmann::json::parse(done.out, nullptr, false)["type"], "octant_deployment");
  EXPECT_THAT(done.err, HasSubstr("variance factor"));
}

TEST_F(Road, CreatedHonoursSourceDateEpoch) {
  const Outcome done = octant({"calibrate", hall("site.yaml"), hall("run"), "-o", "-", "-q"},
                              {.environment = {"SOURCE_DATE_EPOCH=86400"}});
  const auto object = nlohmann::json::parse(done.out, nullptr, false);
  EXPECT_EQ(object["created"], "1970-01-02T00:00:00Z");
  EXPECT_THAT(object["program"]["command"].get<std::string>(), HasSubstr("calibrate"));
  EXPECT_GE(object["inputs"].size(), 2u);
}

TEST_F(Road, NobodyButVerifyOpensTheTruth) {
  // A folder instead of the file, which cannot be opened.
  for (const char* run : {"run", "heldout"}) {
    std::filesystem::remove(hall(std::string(run) + "/truth.tum"));
    std::filesystem::create_directories(hall(std::string(run) + "/truth.tum"));
  }
  EXPECT_EQ(calibrate().exit, 0);
  EXPECT_EQ(octant({"localize", box / "out/d.json", hall("heldout"), "-o", box / "out/f.tum"}).exit, 0);
  EXPECT_EQ(octant({"verify", box / "out/d.json", hall("heldout")}).exit, 3);
}

TEST_F(Road, LocalizeAndVerify) {
  const std::string deployment = hall("deployment.true.json");
  const Outcome fixes = octant({"localize", deployment, hall("heldout"), "-o", box / "out/f.tum", "--csv",
                                box / "out/f.csv", "--json"});
  ASSERT_EQ(fixes.exit, 0) << fixes.err;
  const auto found = fixes.json();
  for (const char* key :
       {"status", "fixes", "no_fix", "seconds", "arrivals", "rejected", "method", "no_fix_reasons"})
    EXPECT_TRUE(found.contains(key)) << key;
  EXPECT_GT(found["fixes"].get<int>(), 30);
  EXPECT_EQ(found["method"], "least_squares");
  const std::string tum = slurp(box / "out/f.tum"), csv = slurp(box / "out/f.csv");
  EXPECT_EQ(std::count(tum.begin(), tum.end(), '\n') - std::count(tum.begin(), tum.end(), '#'),
            found["fixes"].get<int>());
  EXPECT_THAT(csv, HasSubstr("protection_level_m"));
  EXPECT_EQ(octant({"localize", deployment, hall("heldout"), "-o", "-", "-q"}).out, tum);

  const Outcome checked = octant({"verify", deployment, hall("heldout"), "--json"});
  ASSERT_EQ(checked.exit, 0) << checked.err;
  const auto verdict = checked.json();
  for (const char* key : {"status", "matched", "position_rmse_m", "position_p95_m", "heading_rmse_rad",
                          "max_error_m", "nees_mean", "gates", "mean_error_m", "ce50_m", "ce95_m", "ve95_m",
                          "se95_m", "availability", "coverage", "latency_s", "runs", "calibration_runs"}) {
    EXPECT_TRUE(verdict.contains(key)) << key;
  }
  EXPECT_LT(verdict["position_rmse_m"].get<double>(), 0.01);
  EXPECT_EQ(verdict["gates"][0]["name"], "fix_m");
  EXPECT_EQ(verdict["gates"][0]["pass"], true);
  EXPECT_EQ(verdict["calibration_runs"].size(), 0U);
}

/// Each row is received 0.05 s after its time, so a fix in the middle of its epoch is complete later than
/// that.
TEST_F(Road, VerifyReportsTheLatencyOfLoggedReceptions) {
  std::istringstream rows(slurp(hall("heldout/tof.csv")));
  std::string row, text;
  std::getline(rows, row);
  text = row + ",received_s\n";
  while (std::getline(rows, row)) text += fmt::format("{},{}\n", row, std::stod(row) + 0.05);
  const auto without = octant({"verify", hall("deployment.true.json"), hall("heldout"), "--json"}).json();
  EXPECT_TRUE(without["latency_s"].is_null() && without["latency_p95_s"].is_null());
  spit(hall("heldout/tof.csv"), text);
  const auto with = octant({"verify", hall("deployment.true.json"), hall("heldout"), "--json"}).json();
  EXPECT_GE(with["latency_s"].get<double>(), 0.05 - 1e-6);
  EXPECT_LT(with["latency_s"].get<double>(), 2.0);
  EXPECT_GE(with["latency_p95_s"], with["latency_s"]);
  EXPECT_GE(with["latency_max_s"], with["latency_p95_s"]);
  EXPECT_EQ(with["position_rmse_m"], without["position_rmse_m"]);
  EXPECT_THAT(octant({"verify", hall("deployment.true.json"), hall("heldout")}).out,
              HasSubstr("latency          mean "));
}

TEST_F(Road, VerifyWarnsOfARunOfTheCalibration) {
  ASSERT_EQ(calibrate().exit, 0);
  const Outcome checked = octant({"verify", out("d.json"), hall("run"), "--json"});
  EXPECT_EQ(checked.json()["calibration_runs"].size(), 1U);
  EXPECT_THAT(checked.out, HasSubstr("took part in the calibration"));
}

TEST_F(Road, VerifySaysThatSigmasDoNotHold) {
  ASSERT_EQ(calibrate().exit, 0);
  EXPECT_THAT(octant({"verify", out("d.json"), hall("heldout")}).err, Not(HasSubstr("do not hold")));
  // The reference's headings are those of a frame that is turned by 45 degrees on the vehicle.
  std::istringstream truth(slurp(hall("heldout/truth.tum")));
  std::string turned;
  for (std::string line; std::getline(truth, line);) {
    if (line.starts_with('#')) continue;
    double t = 0, x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 1;
    std::istringstream(line) >> t >> x >> y >> z >> qx >> qy >> qz >> qw;
    const double half = std::atan2(qz, qw) + M_PI / 8;
    turned += fmt::format("{} {} {} {} 0 0 {} {}\n", t, x, y, z, std::sin(half), std::cos(half));
  }
  spit(hall("heldout/truth.tum"), turned);
  const Outcome told = octant({"verify", out("d.json"), hall("heldout"), "--json"});
  EXPECT_EQ(told.exit, 0) << "the gate is of positions";
  ASSERT_EQ(told.json()["warnings"].size(), 1u) << told.json()["warnings"];
  EXPECT_THAT(told.json()["warnings"][0].get<std::string>(),
              AllOf(HasSubstr("do not hold: NEES"), HasSubstr("(45 degrees)")));
}

TEST_F(Road, VerifyRefusesARunWithoutTruth) {
  std::filesystem::remove(hall("heldout/truth.tum"));
  const Outcome refused = octant({"verify", hall("deployment.true.json"), hall("heldout"), "--json"});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.json()["error"]["file"].get<std::string>(), HasSubstr("truth.tum"));
}

TEST_F(Road, ABrokenGateIsExit6) {
  make(hall_scenario_text("fix_m: 0.05", "fix_m: 0.0001"));
  const Outcome broken = octant({"verify", hall("deployment.true.json"), hall("heldout"), "--json"});
  EXPECT_EQ(broken.exit, 6) << broken.err;
  const auto object = broken.json();
  EXPECT_EQ(object["status"], "gate_failed");
  EXPECT_EQ(object["error"]["exit"], 6);
  EXPECT_EQ(object["gates"][0]["pass"], false);
  EXPECT_TRUE(object["position_rmse_m"].is_number());
}

TEST_F(Road, NoFixAtAllIsSaidAndIsNoFailure) {
  // One arrival in each epoch determines no pose.
  spit(hall("heldout/tof.csv"), "time_s,epoch,beacon,receiver,tof_s\n1,1,B1,r0,0.01\n6,2,B2,r0,0.01\n");
  const Outcome none =
      octant({"localize", hall("deployment.true.json"), hall("heldout"), "-o", box / "out/f.tum", "--json"});
  EXPECT_EQ(none.exit, 0) << none.err;
  EXPECT_EQ(none.json()["status"], "no_fix");
  EXPECT_EQ(none.json()["fixes"], 0);
  EXPECT_THAT(none.err, HasSubstr("warning:"));
}

TEST_F(Road, BadInputNamesFileAndLine) {
  const std::string tof = slurp(hall("run/tof.csv"));
  std::string bad = tof;
  const std::size_t at = bad.find("B1", bad.find('\n'));
  ASSERT_NE(at, std::string::npos);
  bad.replace(at, 2, "B99");
  const auto line = 1 + std::count(bad.begin(), bad.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  spit(hall("run/tof.csv"), bad);
  const Outcome refused = calibrate({"--json"});
  EXPECT_EQ(refused.exit, 3);
  const auto error = refused.json()["error"];
  EXPECT_EQ(error["code"], "bad_input");
  EXPECT_THAT(error["file"].get<std::string>(), HasSubstr("tof.csv"));
  EXPECT_EQ(error["line"], line);
  EXPECT_THAT(refused.err, HasSubstr("tof.csv:" + std::to_string(line)));
  EXPECT_THAT(refused.err, HasSubstr("B99"));
  EXPECT_THAT(outputs(), IsEmpty());
  EXPECT_EQ(octant({"calibrate", box / "nowhere.yaml", hall("run"), "-o", box / "out/d.json"}).exit, 3);
  EXPECT_EQ(octant({"localize", hall("site.yaml"), hall("heldout"), "-o", box / "out/f.tum"}).exit, 3);
  EXPECT_THAT(outputs(), IsEmpty());
}

TEST_F(Road, AnOutputThatCannotBeWrittenIsSaidBeforeTheWork) {
  const Outcome refused =
      octant({"calibrate", hall("site.yaml"), hall("run"), "-o", box / "missing/d.json", "--json"});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_EQ(refused.json()["error"]["code"], "output");
  EXPECT_EQ(octant({"calibrate", hall("site.yaml"), hall("run"), "-o", box / "out"}).exit, 3);
  EXPECT_EQ(octant({"localize", hall("deployment.true.json"), hall("heldout"), "-o", "/dev/full"}).exit, 3);
}

TEST_F(Road, UndeterminedExportsNothing) {
  // Two epochs cannot carry five unknown beacons.
  make(hall_scenario_text("epochs: 150", "epochs: 2"));
  const Outcome refused = calibrate({"--json"});
  EXPECT_EQ(refused.exit, 5) << refused.err;
  const auto object = refused.json();
  EXPECT_EQ(object["status"], "undetermined");
  EXPECT_EQ(object["error"]["exit"], 5);
  EXPECT_FALSE(object["undetermined"].empty());
  EXPECT_TRUE(object["speed_mps"].is_null());
  EXPECT_THAT(outputs(), IsEmpty());
}

TEST_F(Road, InterruptedLeavesNothingBehind) {
  make(hall_scenario_text("epochs: 150", "epochs: 3000"));
  for (const int signal : {SIGINT, SIGTERM}) {
    const Outcome stopped = octant({"calibrate", hall("site.yaml"), hall("run"), "-o", box / "out/d.json",
                                    "--json", "--progress", "json"},
                                   {.interrupt_signal = signal});
    EXPECT_EQ(stopped.exit, 130) << stopped.err;
    EXPECT_EQ(stopped.json()["status"], "interrupted") << stopped.out;
    EXPECT_THAT(outputs(), IsEmpty());
  }
}

TEST_F(Road, ProgressAsJsonLines) {
  const Outcome done = octant({"calibrate", hall("site.yaml"), hall("run"), "-o", box / "out/d.json",
                               "--json", "--progress", "json"});
  ASSERT_EQ(done.exit, 0) << done.err;
  const std::string first = done.err.substr(0, done.err.find('\n'));
  EXPECT_TRUE(nlohmann::json::parse(first, nullptr, false).contains("stage")) << first;
  // Each stage of the adjustment ends with its last step and the remaining cost.
  int most = 0;
  std::istringstream lines(done.err);
  for (std::string line; std::getline(lines, line);) {
    const auto step = nlohmann::json::parse(line, nullptr, false);
    if (!step.is_object() || !step.contains("cost")) continue;
    most = std::max(most, step["iteration"].get<int>());
    if (step["iteration"] > 0) EXPECT_GT(step["cost"].get<double>(), 0.0) << line;
    EXPECT_LT(line.size(), 200U) << "as many digits as anybody needs";
  }
  EXPECT_GT(most, 1);
  EXPECT_TRUE(done.json().is_object());
}

TEST(Demo, KeepsItsPromise) {
  const TemporaryFolder box;
  const Outcome demo = octant({"demo"}, {.folder = box.path().string()});
  ASSERT_EQ(demo.exit, 0) << demo.out << demo.err;
  EXPECT_THAT(demo.out, HasSubstr("largest beacon error"));
  EXPECT_THAT(demo.out, HasSubstr("octant-demo/deployment.json\n"));
  EXPECT_TRUE(std::filesystem::exists(box / "octant-demo/report.html"));
  const Outcome again = octant({"demo", "--json", "-o", box / "octant-demo"});
  ASSERT_EQ(again.exit, 0) << again.err;
  const auto object = again.json();
  for (const auto& gate : object["gates"]) {
    EXPECT_EQ(gate["limit"], 0.01);
    EXPECT_LT(gate["value"].get<double>(), 0.01);
  }
  for (const auto& path : object["outputs"])
    EXPECT_TRUE(std::filesystem::exists(path.get<std::string>())) << path;
}

}  // namespace road_test
}  // namespace octant::test
