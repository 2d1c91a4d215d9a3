// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/report_json.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/worlds.h"
#include "tests/survey/report_input.h"

namespace octant::app {
namespace report_json_test {

using octant::test::must;
using survey::full_report;
using survey::ReportInput;
using ::testing::HasSubstr;

/// All that can be in a report: a full one with the rest filled too.
ReportInput fullest_report() {
  ReportInput input = full_report();
  Deployment& d = input.plan.deployment;
  d.vehicles = {{.name = "robot", .first_receiver = 0, .receiver_count = 1}};
  d.receivers.push_back({.name = "r0", .vehicle = VehicleId(0), .position_m = {0, 0, 0.3}, .axis = {}});
  input.words.clear();  // made again from the glossary by whoever reads it
  input.message = "of the solver";
  input.outcome = survey::Outcome::kNotConverged;
  input.moved = {{"B1", {0.1, std::nullopt, -0.2}, 0.002, 0.05, 0.22}};
  input.weak[0].blocking = input.weak[0].lone_beacon = true;
  input.left_out[0].cause = survey::LeftOutCause::kNoPose;
  input.plan.maps[1].tolerance = 5.0;
  input.evaluation->heading_rmse_rad = 0.01;
  input.evaluation->nees_mean = 1.1;
  input.changes->found = {
      {.kind = ChangeKind::kSpeed, .subject = "medium", .size = 0.1, .sigma = 0.01, .p = 1e-6}};
  input.changes->doubted_control_points = {"B0"};
  input.plan.tracks[0].thinned_from = 77;
  return input;
}

/// Content of a report in both of its forms.
std::string shown(const ReportInput& input) {
  return report_html(input, {.interactive = false}) + report_markdown(input);
}

TEST(ReportJson, ReadsBackWhatItWrote) {
  const ReportInput input = fullest_report();
  const std::string text = report_to_json(input);
  EXPECT_TRUE(is_saved_report(text));
  const ReportInput back = must(report_from_json(text, "r.json"));
  EXPECT_EQ(shown(back), shown(input));
  EXPECT_EQ(report_to_json(back), text) << "to the last digit";
}

TEST(ReportJson, WhatIsNotKnownStaysSo) {
  ReportInput input = fullest_report();
  input.evaluation.reset(), input.changes.reset(), input.standardised.reset(), input.no_loss.reset();
  for (auto& note : input.beacons) note.rms_s.reset(), note.mdb_s.reset();
  input.losses[0].map.reset();
  const ReportInput back = must(report_from_json(report_to_json(input), "r.json"));
  EXPECT_FALSE(back.evaluation || back.changes || back.standardised || back.no_loss);
  EXPECT_FALSE(back.beacons[0].rms_s || back.beacons[0].mdb_s || back.losses[0].map);
  EXPECT_EQ(shown(back), shown(input));
}

TEST(ReportJson, CellsWithoutAValueComeBackAsNone) {
  const ReportInput input = fullest_report();
  const ReportInput back = must(report_from_json(report_to_json(input), "r.json"));
  ASSERT_EQ(back.plan.maps[0].values.size(), 4U);
  EXPECT_TRUE(std::isnan(back.plan.maps[0].values[3]));
  EXPECT_EQ(back.plan.maps[0].values[2], 3.0);
}

TEST(ReportJson, EarlierReportsLackWhatCameLater) {
  auto json = nlohmann::json::parse(report_to_json(fullest_report()));
  for (const char* key : {"moved", "stops", "misses"}) json.erase(key);
  for (auto& map : json["maps"]) map.erase("tolerance");
  for (auto& note : json["left_out"]) note.erase("cause");
  const ReportInput back = must(report_from_json(json.dump(), "r.json"));
  EXPECT_TRUE(back.moved.empty() && back.stops.empty() && back.misses.empty());
  EXPECT_EQ(back.left_out.at(0).cause, survey::LeftOutCause::kOther);
}

TEST(ReportJson, WhatIsNoReportIsNamed) {
  const std::string text = report_to_json(fullest_report());
  const auto error = [](const std::string& altered) {
    const auto report = report_from_json(altered, "r.json");
    return report ? std::string() : report.error().message();
  };
  for (std::size_t size = 0; size < text.size() - 2; size += 97)
    EXPECT_THAT(error(text.substr(0, size)), HasSubstr("r.json: this is no saved report")) << size;
  auto json = nlohmann::json::parse(text);
  json["version"] = 2;
  EXPECT_THAT(error(json.dump()), HasSubstr("version 2; expected 1"));
  json["version"] = 1;
  json["beacons"] = "none";
  EXPECT_THAT(error(json.dump()), HasSubstr("no saved report"));
  json = nlohmann::json::parse(text);
  json["deployment"]["beacons"][0]["position_m"] = {1, 2};
  EXPECT_THAT(error(json.dump()), HasSubstr("the file was altered")) << "the deployment's own reader looks";
}

TEST(ReportJson, OnlyAReportCallsItselfOne) {
  for (const char* other :
       {"", "{}", "[]", "null", "{\"type\": \"octant_deployment\"}", "octant_site: 1", "{\"type\": 5}"})
    EXPECT_FALSE(is_saved_report(other)) << other;
}

}  // namespace report_json_test
}  // namespace octant::app
