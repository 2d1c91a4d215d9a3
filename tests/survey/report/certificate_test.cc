// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report/certificate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/page/report_html.h"
#include "survey/page/report_markdown.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace certificate_test {

using ::testing::HasSubstr;
using ::testing::Not;

Deployment calibrated() { return full_report().plan.deployment; }

CertificateInput filled_in() {
  return {.number = "C-17",
          .organisation = "Survey & Sons",
          .operator_name = "A. Mason",
          .customer = "Hall Ltd",
          .place = "Hall 3",
          .issued = "2026-11-22T12:00:00Z",
          .digest = std::string(64, 'a')};
}

std::vector<std::string> sections_of(const ReportDocument& document) {
  std::vector<std::string> ids;
  for (const auto& section : document.sections) ids.push_back(section.id);
  return ids;
}

TEST(Certificate, HasWhatTheStandardAsksInItsOrder) {
  EXPECT_THAT(sections_of(certificate_document(calibrated(), filled_in())),
              ::testing::ElementsAre("identification", "conditions", "method", "traceability", "results",
                                     "conformity", "signature"));
  Deployment judged = calibrated();
  judged.tolerance.beacon_m = 0.03;
  const std::string text = to_markdown(certificate_document(judged, filled_in()));
  for (const char* what : {"C-17", "A. Mason", "Hall Ltd", "Hall 3", "2026-11-22T12:00:00Z", "Decision rule",
                           "claims no accreditation", "coverage factor k = 2"})
    EXPECT_THAT(text, HasSubstr(what));
}

TEST(Certificate, WhatIsNotStatedIsALineToFillIn) {
  CertificateInput input = filled_in();
  input.operator_name.clear();
  input.number.clear();
  const std::string text = to_markdown(certificate_document(calibrated(), input));
  EXPECT_THAT(text, HasSubstr("operator | . . . ."));
  EXPECT_THAT(text, HasSubstr(calibrated().site + "-aaaaaaaaaaaa")) << "a number of its own";
}

TEST(Certificate, ExpandedUncertaintyIsTwiceTheStandardOne) {
  Deployment d = calibrated();
  d.beacons.resize(2);
  d.beacons[0] = {.name = "A", .position_m = {1, 2, 3}, .delay_s = 1e-4, .delay_sigma_s = 2.5e-6};
  d.beacons[0].covariance_m2.diagonal() << 4e-6, 9e-6, 16e-6;
  d.beacons[1] = {.name = "B", .position_m = {4, 5, 6}, .status = BeaconStatus::kControlPoint};
  const ReportDocument document = certificate_document(d, filled_in());
  const auto& table = std::get<ReportTable>(document.sections[4].blocks[0]);
  std::vector<std::string> free, held;
  for (const auto& cell : table.rows[0]) free.push_back(cell.text);
  for (const auto& cell : table.rows[1]) held.push_back(cell.text);
  EXPECT_THAT(free, ::testing::ElementsAre("A", "1.0000", "4.0", "2.0000", "6.0", "3.0000", "8.0", "100.00",
                                           "5.00", "calibrated"));
  EXPECT_EQ(held[2], "held") << "no claim of perfection";
}

TEST(Certificate, ConformsByTheStatedRuleAlone) {
  Deployment d = calibrated();
  d.beacons.resize(1);
  d.beacons[0] = {.name = "A", .position_m = {1, 2, 3}};
  d.beacons[0].covariance_m2.diagonal() << 1e-4, 1e-4, 1e-4;  // a radius of 24 mm in the plane
  d.contradictions.clear();
  d.tolerance.beacon_m = 0.03;
  EXPECT_EQ(certificate_document(d, filled_in()).tone, Tone::kGood);
  d.tolerance.beacon_m = 0.02;
  EXPECT_EQ(certificate_document(d, filled_in()).tone, Tone::kBad);
  d.tolerance.beacon_m = 0.03;
  d.contradictions.push_back({});
  EXPECT_EQ(certificate_document(d, filled_in()).tone, Tone::kBad) << "contradicted";
  d.tolerance.beacon_m.reset();
  EXPECT_EQ(certificate_document(d, filled_in()).grade, "No tolerance stated");
}

TEST(Certificate, ARecalibrationSaysWhatWasFound) {
  Deployment d = calibrated();
  d.previous.emplace();
  d.previous->created = "2026-01-01T00:00:00Z";
  Change moved;
  moved.subject = "B3";
  moved.size = 0.042;
  moved.sigma = 0.003;
  moved.p = 1e-9;
  d.previous->changes = {moved};
  const std::string text = to_markdown(certificate_document(d, filled_in()));
  EXPECT_THAT(text, HasSubstr("As found"));
  EXPECT_THAT(text, HasSubstr("42 mm"));
  EXPECT_THAT(text, HasSubstr("6 mm")) << "expanded";
  EXPECT_THAT(sections_of(certificate_document(d, filled_in())), ::testing::Contains("as-found"));
}

TEST(Certificate, HostileWordsStayWords) {
  CertificateInput input = filled_in();
  input.organisation = "<script>alert(1)</script>";
  const std::string html = to_html(certificate_document(calibrated(), input), "");
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("&lt;script"));
}

}  // namespace certificate_test
}  // namespace octant::survey
