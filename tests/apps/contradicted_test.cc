// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A site file that the data contradict, with the program as a process.
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace contradicted_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class Contradicted : public HallFolder {
 protected:
  void SetUp() override {
    make(60);
    std::string site = slurp(hall("site.yaml"));
    const std::string stated = "position_m: [19.95, 8.15, 2.48]";  // control point B3
    const std::size_t at = site.find(stated);
    ASSERT_NE(at, std::string::npos);
    spit(hall("site.yaml"), site.replace(at, stated.size(), "position_m: [19.75, 8.15, 2.48]"));
  }
};

TEST_F(Contradicted, ExitsSixNamesTheCulpritAndExportsNothing) {
  const Outcome told = calibrate({"--json", "--report", out("r.md")});
  EXPECT_EQ(told.exit, 6);
  const auto json = told.json();
  EXPECT_EQ(json["status"], "contradicted");
  EXPECT_EQ(json["verdict"]["grade"], "Contradicted");
  ASSERT_EQ(json["verdict"]["contradictions"].size(), 1U);
  const auto& c = json["verdict"]["contradictions"][0];
  EXPECT_EQ(c["kind"], "control_point");
  EXPECT_EQ(c["subject"], "B3");
  EXPECT_GT(c["sigmas"].get<double>(), 5.0);
  EXPECT_FALSE(json["beacons"].empty()) << "the object is whole";
  EXPECT_THAT(json["error"]["advice"].get<std::string>(), HasSubstr("--accept"));
  EXPECT_THAT(outputs(), ElementsAre("r.md"));
  EXPECT_THAT(slurp(out("r.md")), HasSubstr("Contradicted"));
}

TEST_F(Contradicted, AcceptExportsItMarkedAndLocalizersSaySo) {
  EXPECT_EQ(calibrate({"--accept"}).exit, 6);
  EXPECT_THAT(outputs(), ElementsAre("d.json"));
  EXPECT_THAT(slurp(out("d.json")), HasSubstr("\"Contradicted\""));
  const Outcome located = octant({"localize", out("d.json"), hall("heldout"), "-o", out("f.tum")});
  EXPECT_EQ(located.exit, 0);
  EXPECT_THAT(located.err, HasSubstr("contradict"));
  EXPECT_THAT(octant({"verify", out("d.json"), hall("heldout")}).err, HasSubstr("B3"));
}

TEST_F(Contradicted, AComparisonWithAnEarlierDeploymentHangsOnIt) {
  ASSERT_EQ(calibrate({"--accept"}).exit, 6);
  const Outcome told = octant({"calibrate", hall("site.yaml"), hall("run"), "-o", out("e.json"), "--since",
                               out("d.json"), "--progress", "none"});
  EXPECT_THAT(told.out, HasSubstr("this comparison hangs on what is contradicted;"));
}

TEST_F(Contradicted, CheckDoesNotSayThatAllIsWell) {
  const Outcome looked = octant({"check", hall("site.yaml"), hall("run"), "--progress", "none"});
  EXPECT_TRUE(looked.out.starts_with("verdict          the data contradict what was stated")) << looked.out;
  EXPECT_THAT(looked.err, HasSubstr("B3"));
}

/// The hall with its thermometer in Fahrenheit.
class WrongThermometer : public HallFolder {
 protected:
  void SetUp() override {
    make(60);
    spit(hall("run/run.yaml"), slurp(hall("run/run.yaml")) + "temperature_degC: 69.8\n");
    spit(hall("heldout/run.yaml"), slurp(hall("heldout/run.yaml")) + "temperature_degC: 21\n");
  }
};

TEST_F(WrongThermometer, VerifySaysThatThereIsNoFixAndNotThatThereIsNoReference) {
  const Outcome told = calibrate({"--accept"});
  ASSERT_EQ(told.exit, 6) << told.err;
  EXPECT_THAT(told.err, HasSubstr("Fahrenheit"));
  EXPECT_THAT(told.err, Not(HasSubstr(".;"))) << "a sentence that goes on";
  const Outcome held = octant({"verify", out("d.json"), hall("heldout")});
  EXPECT_EQ(held.exit, 6);
  EXPECT_THAT(held.err, HasSubstr("there is no fix to compare with the reference"));
  EXPECT_THAT(held.err, Not(HasSubstr("no fix has a reference")));
  EXPECT_THAT(held.err, HasSubstr("far outside the calibrated 69.8 degC"));
  std::istringstream lines(held.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

TEST_F(Contradicted, ABatchWritesItWithAcceptAlone) {
  spit(hall("sites.yaml"), "octant_batch: 1\nsites:\n- {site: site.yaml, runs: [run], output: batch.json}\n");
  EXPECT_EQ(octant({"batch", hall("sites.yaml")}).exit, 6);
  EXPECT_FALSE(std::filesystem::exists(hall("batch.json")));
  EXPECT_EQ(octant({"batch", hall("sites.yaml"), "--accept"}).exit, 6);
  EXPECT_THAT(slurp(hall("batch.json")), HasSubstr("\"Contradicted\""));
}

}  // namespace contradicted_test
}  // namespace octant::test
