// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A site file that the data contradict, with the program as a process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

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

TEST_F(Contradicted, ABatchWritesItWithAcceptAlone) {
  spit(hall("sites.yaml"), "octant_batch: 1\nsites:\n- {site: site.yaml, runs: [run], output: batch.json}\n");
  EXPECT_EQ(octant({"batch", hall("sites.yaml")}).exit, 6);
  EXPECT_FALSE(std::filesystem::exists(hall("batch.json")));
  EXPECT_EQ(octant({"batch", hall("sites.yaml"), "--accept"}).exit, 6);
  EXPECT_THAT(slurp(hall("batch.json")), HasSubstr("\"Contradicted\""));
}

}  // namespace
}  // namespace octant::test
