// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/report/report_sections.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace report_next_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// A calibration without findings.
ReportInput quiet() {
  ReportInput input = full_report();
  input.changes.reset();
  input.weak.clear();
  input.plan.deployment.tolerance.beacon_m = 0.01;
  return input;
}

Contradiction contradiction(const std::string& remedy) {
  Contradiction c;
  c.subject = "B1";
  c.remedy = remedy;
  return c;
}

TEST(ReportNext, WithNothingToDoItSaysSo) {
  EXPECT_THAT(next_steps(quiet()), ElementsAre(HasSubstr("Nothing needs to be measured")));
}

TEST(ReportNext, ContradictionsComeBeforeAllElse) {
  ReportInput input = quiet();
  input.weak = {{"the scale", "tape a distance", 0.5, true}};
  input.plan.deployment.contradictions = {contradiction("measure B1 again"),
                                          contradiction("measure B1 again"), contradiction("")};
  EXPECT_THAT(next_steps(input), ElementsAre("Measure B1 again.", HasSubstr("Then calibrate again")));
  // Without a remedy they take no other step's place.
  input.plan.deployment.contradictions = {contradiction("")};
  EXPECT_THAT(next_steps(input), ElementsAre("To determine the scale: tape a distance."));
}

TEST(ReportNext, OneRemedyForSeveralIsOneStep) {
  ReportInput input = quiet();
  input.weak = {{"the offset", "warm up", 0.0, false},
                {"the scale", "tape a distance", 0.0, true},
                {"the height", "tape a distance", 0.0, true},
                {"the scale", "tape a distance", 0.0, true},
                {"the rest", "", 0.0, true}};
  EXPECT_THAT(next_steps(input), ElementsAre("To determine the scale, the height: tape a distance.",
                                             "To determine the offset: warm up."));
}

TEST(ReportNext, OfManyNamesSomeAreTold) {
  ReportInput input = quiet();
  for (int i = 0; i < 9; ++i)
    input.plan.deployment.beacons.push_back(
        test_beacon("X" + std::to_string(i), i, 0, 0.1, BeaconStatus::kUndetermined));
  EXPECT_THAT(next_steps(input).front(),
              HasSubstr("Hear X0, X1, X2, X3, X4, X5 and 3 more from more places"));
  EXPECT_THAT(next_steps(input).front(), HasSubstr("localizers leave them out"));
  input.weak = {{"beacon X0", "hear it", 0.0, false, true}};
  EXPECT_THAT(next_steps(input), Not(Contains(HasSubstr("from more places")))) << "its note has told already";
}

TEST(ReportNext, BeaconsBeyondTheToleranceAreNamed) {
  ReportInput input = quiet();
  input.plan.deployment.tolerance.beacon_m = 0.003;  // 2.45 x 2 mm is beyond, 2.45 x 1 mm within
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("Record more stations around B1: beyond")));
}

TEST(ReportNext, StatedNoiseThatIsNoneIsSaid) {
  ReportInput input = quiet();
  for (const double factor : {2.1, 0.4}) {
    input.plan.deployment.statistics.variance_factor = factor;
    EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("State the noise as it is")));
  }
  for (const double factor : {0.6, 1.9}) {
    input.plan.deployment.statistics.variance_factor = factor;
    EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("Nothing needs to be measured"))) << factor;
  }
  input.plan.deployment.statistics.variance_factor = 9.0;
  input.plan.deployment.statistics.redundancy = 5;
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("Nothing needs"))) << "too few to tell";
}

TEST(ReportNext, AVerificationThatIsMissingOrFailedIsAsked) {
  ReportInput input = quiet();
  input.evaluation.reset();
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("octant verify")));
  input.evaluation = Evaluation{};
  input.evaluation->gates = {{"matched", 1, 0, false}};
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("whose truth.tum covers the fixes")));
  input.evaluation->matched = 5;
  input.evaluation->gates = {{"fix_m", 0.01, 0.02, false}};
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("Fixes are outside their tolerance")));
  input.evaluation->gates = {{"fix_m", 0.03, 0.02, true}};
  input.evaluation->nees_mean = 4.0;
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("errors are 4 times as large squared")));
  input.evaluation->nees_mean = 2.9;
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("Nothing needs")));
}

TEST(ReportNext, WithoutAToleranceNothingIsJudged) {
  ReportInput input = quiet();
  input.plan.deployment.tolerance = {};
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("State in the site file what the site must reach")));
  input.plan.deployment.tolerance.fix_m = 0.05;
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("Nothing needs")));
}

TEST(ReportNext, WhatDidNotConvergeIsCheckedFirst) {
  ReportInput input = quiet();
  input.outcome = Outcome::kNotConverged;
  input.evaluation.reset();
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("Check units, beacon ids")))
      << "nothing to verify yet";
}

TEST(ReportNext, ArrivalsLeftOutAreAWordFromAQuarterOn) {
  ReportInput input = quiet();
  input.left_out = {{"late (echo)", 250, LeftOutCause::kLate}};
  input.plan.deployment.statistics.arrivals = 750;
  input.plan.deployment.statistics.rejected = 250;
  EXPECT_THAT(next_steps(input), ElementsAre(HasSubstr("Nothing needs")));
  input.plan.deployment.statistics.rejected = 251;
  EXPECT_THAT(next_steps(input),
              ElementsAre(HasSubstr("251 of 1001 arrivals were left out, 250 of them late")));
}

TEST(ReportNext, IsANumberedList) {
  const auto section = next_section(quiet());
  ASSERT_TRUE(section);
  EXPECT_TRUE(std::get<ReportList>(section->blocks.at(0)).numbered);
}

}  // namespace report_next_test
}  // namespace octant::survey
