// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// No command writes an output over an input or another output; and messages that were once unclear.
#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace outputs_test {

using ::testing::HasSubstr;
using ::testing::Not;

class Outputs : public HallFolder {
 protected:
  /// The command ends with exit 2, and a file is unchanged.
  void expect_kept(const std::vector<std::string>& words, const std::string& file) {
    const std::string before = slurp(file);
    const Outcome outcome = octant(words);
    EXPECT_EQ(outcome.exit, 2) << words.front() << " over " << file << ": " << outcome.err;
    EXPECT_EQ(slurp(file), before);
  }
};

TEST_F(Outputs, NoneIsWrittenOverAnInput) {
  ASSERT_EQ(calibrate().exit, 0);
  const std::string site = hall("site.yaml"), run = hall("run"), heldout = hall("heldout"), d = out("d.json");
  expect_kept({"calibrate", site, run, "-o", site}, site);
  expect_kept({"calibrate", site, run, "-o", run + "/tof.csv"}, run + "/tof.csv");
  expect_kept({"calibrate", site, run, "-o", run + "/../run/./tof.csv"}, run + "/tof.csv");
  expect_kept(
      {"calibrate", site, run, "-o", out("e.json"), "--report", out("e.html"), "--since", d, "--report", d},
      d);
  expect_kept({"localize", d, heldout, "-o", d}, d);
  expect_kept({"localize", d, heldout, "-o", out("f.tum"), "--csv", heldout + "/run.yaml"},
              heldout + "/run.yaml");
  expect_kept({"verify", d, heldout, "--report", d}, d);
  expect_kept({"report", d, "-o", d}, d);
  expect_kept({"survey", site, "-o", site}, site);
  expect_kept({"plan", site, "--stations", "1", "--csv", site}, site);
  expect_kept({"convert", run + "/tof.csv", "--site", site, "--format", "counters", "-o", run},
              run + "/tof.csv");
  expect_kept({"simulate", hall("scenario.yaml"), "-o", box / "hall"}, hall("scenario.yaml"));
  // A name that a run gives meaning to is the run's, whether it lies there or not.
  EXPECT_EQ(octant({"localize", d, run, "-o", run + "/bearings.csv"}).exit, 2);
  EXPECT_FALSE(std::filesystem::exists(run + "/bearings.csv"));
}

TEST_F(Outputs, LinksAreFollowed) {
  const std::string site = hall("site.yaml");
  std::filesystem::create_symlink(site, out("soft.json"));
  std::filesystem::create_hard_link(site, out("hard.json"));
  expect_kept({"calibrate", site, hall("run"), "-o", out("soft.json")}, site);
  expect_kept({"calibrate", site, hall("run"), "-o", out("hard.json")}, site);
}

TEST_F(Outputs, NoneIsWrittenOverAnother) {
  const Outcome twice = octant({"calibrate", hall("site.yaml"), hall("run"), "-o", out("a.html"), "--report",
                                out("a.html"), "--json"});
  EXPECT_EQ(twice.exit, 2);
  EXPECT_EQ(twice.json()["error"]["code"], "usage");
  EXPECT_FALSE(std::filesystem::exists(out("a.html")));
  std::filesystem::create_symlink(out("b.json"), out("to_b.md"));  // which leads nowhere yet
  EXPECT_EQ(
      octant({"calibrate", hall("site.yaml"), hall("run"), "-o", out("b.json"), "--report", out("to_b.md")})
          .exit,
      2);
  EXPECT_EQ(calibrate({"--report", out("c.html")}).exit, 0) << "two files of their own";
}

TEST_F(Outputs, ChangesAreSaidWithoutAReport) {
  ASSERT_EQ(calibrate().exit, 0);
  std::filesystem::rename(out("d.json"), out("old.json"));
  const Outcome text = calibrate({"--since", out("old.json")});
  ASSERT_EQ(text.exit, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("0 of 8 beacons moved"));
  const Outcome json = calibrate({"--since", out("old.json"), "--json"});
  ASSERT_TRUE(json.json().contains("changes")) << json.out;
  EXPECT_TRUE(json.json()["changes"].empty());
  EXPECT_FALSE(calibrate({"--json"}).json().contains("changes"));
}

TEST_F(Outputs, NoFixIsNotALackOfReference) {
  ASSERT_EQ(calibrate().exit, 0);
  // A fifth too slow: no arrivals agree.
  spit(hall("heldout/run.yaml"), "octant_run: 1\ntemperature_degC: -90\n");
  const Outcome verify = octant({"verify", out("d.json"), hall("heldout"), "--json"});
  ASSERT_EQ(verify.json()["fixes"], 0);
  EXPECT_EQ(verify.exit, 6);
  EXPECT_THAT(verify.json()["error"]["message"].get<std::string>(), HasSubstr("there is no fix"));
  EXPECT_THAT(verify.out, Not(HasSubstr("has a reference")));
}

TEST_F(Outputs, PointsByHandAreAReference) {
  ASSERT_EQ(calibrate().exit, 0);
  const Outcome by_track = octant({"verify", out("d.json"), hall("heldout"), "--json"});
  ASSERT_EQ(by_track.exit, 0) << by_track.err;
  std::filesystem::remove(hall("heldout/truth.tum"));
  EXPECT_EQ(octant({"verify", out("d.json"), hall("heldout")}).exit, 3);
  // A point for every epoch, far away; those of epochs that are not there are only warned of.
  std::string points = "epoch,x_m,y_m,sigma_m\n";
  for (int epoch = 0; epoch < 1000; ++epoch) points += std::to_string(epoch) + ",-100,0,0.01\n";
  spit(hall("heldout/truth.csv"), points);
  const Outcome by_point = octant({"verify", out("d.json"), hall("heldout"), "--json"});
  EXPECT_EQ(by_point.json()["matched"], by_track.json()["matched"]) << by_point.out;
  EXPECT_GT(by_point.json()["position_rmse_m"].get<double>(), 50.0);
}

TEST_F(Outputs, FilesOfAnotherKindAreRecognised) {
  ASSERT_EQ(calibrate().exit, 0);
  const Outcome site = octant({"localize", hall("site.yaml"), hall("heldout"), "-o", out("f.tum")});
  EXPECT_EQ(site.exit, 3);
  EXPECT_THAT(site.err, HasSubstr("a site file"));
  const Outcome deployment = octant({"calibrate", out("d.json"), hall("run"), "-o", out("e.json")});
  EXPECT_EQ(deployment.exit, 3);
  EXPECT_THAT(deployment.err, HasSubstr("a deployment file"));
}

TEST(Words, ARecordingThatIsNamedTwiceIsTold) {
  const std::string hall = std::string(OCTANT_SOURCE_DIR) + "/datasets/hall/", run = hall + "run";
  for (const std::string again : {run, hall + "heldout/../run"}) {
    const auto warnings = octant({"check", hall + "site.yaml", run, again, "--json"}).json()["warnings"];
    EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const auto& warning) {
      return warning.template get<std::string>().find("is named twice") != std::string::npos;
    })) << warnings;
  }
}

TEST(Words, AnUnknownMethodIsNamedWithThoseThereAre) {
  const Outcome unknown = octant({"localize", "d.json", "run", "-o", "f", "--method", "foo"});
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_THAT(unknown.err, HasSubstr("'foo'"));
  EXPECT_THAT(unknown.err, HasSubstr("least_squares"));
  EXPECT_THAT(unknown.err, Not(HasSubstr("->")));
}

TEST(Words, HelpIsACommandToo) {
  EXPECT_EQ(octant({"help"}).exit, 0);
  const Outcome help = octant({"help", "calibrate"});
  EXPECT_EQ(help.exit, 0);
  EXPECT_EQ(help.out, octant({"calibrate", "--help"}).out);
}

TEST(Words, TheSchemaOfARunListsTheColumnsOfAllItsFiles) {
  const std::string schema = octant({"schema", "run"}).out;
  for (const char* column : {"dx_m", "dheading_rad", "bearing_rad", "angle_increment_rad", "distance_m",
                             "level_dbm", "heading_sigma_rad"})
    EXPECT_THAT(schema, HasSubstr(column));
}

}  // namespace outputs_test
}  // namespace octant::test
