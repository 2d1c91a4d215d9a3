// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Reports as the program writes them: forms, saved results, refusals, outputs that cannot be written.
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace report_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Report : public HallFolder {};

TEST_F(Report, AllFormsFromOneCalibration) {
  const Outcome done = calibrate({"--report", out("r.html"), "--report", out("r.md"), "--report",
                                  out("r.json"), "--report-static", "--json"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_THAT(outputs(), ElementsAre("d.json", "r.html", "r.json", "r.md"));
  // Numbers and their units are tied together in the page.
  const std::string page = std::regex_replace(slurp(out("r.html")), std::regex("&#160;"), " ");
  EXPECT_LT(page.size(), 500'000u);
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(slurp(out("r.md")), HasSubstr("\n## Where this comes from\n"));
  // The JSON object agrees.
  const auto verdict = done.json()["verdict"];
  EXPECT_EQ(verdict["grade"], "Good");
  EXPECT_THAT(page, HasSubstr(verdict["sentence"].get<std::string>()));
  for (const auto& step : verdict["next"]) EXPECT_THAT(page, HasSubstr(step.get<std::string>()));
}

TEST_F(Report, SavedResultMakesTheSameReport) {
  ASSERT_EQ(calibrate({"--report", out("r.html"), "--report", out("r.json")}).exit, 0);
  const Outcome again = octant({"report", out("r.json"), "-o", out("again.html"), "-o", out("again.json")});
  ASSERT_EQ(again.exit, 0) << again.err;
  // The command that wrote the report is another one; all else is the same.
  auto saved = nlohmann::json::parse(slurp(out("r.json"))),
       copy = nlohmann::json::parse(slurp(out("again.json")));
  EXPECT_NE(saved["command"], copy["command"]);
  copy["command"] = saved["command"];
  EXPECT_EQ(saved, copy);
  std::string page = slurp(out("again.html"));
  const std::size_t row = page.find("<tr><th scope='row'>report by");
  ASSERT_NE(row, std::string::npos);
  page.erase(row, page.find('\n', row) - row + 1);
  EXPECT_EQ(page, slurp(out("r.html")));
}

TEST_F(Report, FromADeploymentAloneAndWithARun) {
  ASSERT_EQ(calibrate().exit, 0);
  ASSERT_EQ(octant({"report", out("d.json"), "-o", out("r.md")}).exit, 0);
  EXPECT_THAT(slurp(out("r.md")), Not(HasSubstr("## Verification")));
  EXPECT_THAT(slurp(out("r.md")), HasSubstr("## When a beacon falls silent"));
  const Outcome with_run = octant({"report", out("d.json"), box / "hall/heldout", "-o", out("r.md"),
                                   "--since", box / "hall/deployment.true.json", "--json"});
  ASSERT_EQ(with_run.exit, 0) << with_run.err;
  EXPECT_THAT(slurp(out("r.md")), HasSubstr("## Verification"));
  EXPECT_THAT(slurp(out("r.md")), HasSubstr("## Changes since an earlier deployment"));
  EXPECT_TRUE(with_run.json()["verdict"]["next"].is_array());
  const Outcome verified =
      octant({"verify", out("d.json"), box / "hall/heldout", "--report", out("v.html"), "--report-static"});
  ASSERT_EQ(verified.exit, 0) << verified.err;
  EXPECT_THAT(slurp(out("v.html")), HasSubstr("Verification with held-out runs"));
}

TEST_F(Report, WithoutOneTheTerminalSaysTheSame) {
  const Outcome done = calibrate({"--no-report"});
  ASSERT_EQ(done.exit, 0);
  EXPECT_TRUE(done.out.starts_with("verdict          Good: ")) << done.out;
  EXPECT_THAT(done.out, HasSubstr("\nnext             "));
  EXPECT_THAT(outputs(), ElementsAre("d.json"));
}

TEST_F(Report, ARefusedCalibrationSaysWhy) {
  make(2);  // two epochs cannot carry five unknown beacons
  const Outcome refused = calibrate({"--report", out("r.html"), "--report", out("r.json"), "--json"});
  EXPECT_EQ(refused.exit, 5) << refused.err;
  EXPECT_THAT(outputs(), ElementsAre("r.html", "r.json"));
  EXPECT_EQ(refused.json()["verdict"]["grade"], "Refused");
  const std::string page = slurp(out("r.html"));
  EXPECT_THAT(page, HasSubstr("<strong>Refused</strong> The data do not determine "));
  EXPECT_THAT(page, HasSubstr("What to do next"));
  EXPECT_EQ(octant({"report", out("r.json"), "-o", out("again.md")}).exit, 0);
  EXPECT_THAT(slurp(out("again.md")), HasSubstr("**Refused.**"));
  EXPECT_EQ(octant({"report", out("r.json"), box / "hall/heldout", "-o", out("again.md")}).exit, 2);
}

TEST_F(Report, SiteSheetNamesTheDeployment) {
  ASSERT_EQ(calibrate().exit, 0);
  ASSERT_EQ(octant({"report", out("d.json"), "--site-sheet", out("s.html")}).exit, 0);
  const std::string sheet = slurp(out("s.html"));
  EXPECT_THAT(sheet, HasSubstr(nlohmann::json::parse(slurp(out("d.json")))["digest"].get<std::string>()));
  std::size_t codes = 0;
  for (std::size_t at = sheet.find("QR code"); at != std::string::npos; at = sheet.find("QR code", at + 1))
    ++codes;
  EXPECT_EQ(codes, 8u);
}

TEST_F(Report, ACertificateNamesWhoAndWhatWasFound) {
  ASSERT_EQ(calibrate().exit, 0);
  const Outcome made = octant({"report", out("d.json"), "--certificate", out("c.md"), "--operator",
                               "A. Mason", "--certificate-number", "C-17"});
  ASSERT_EQ(made.exit, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("certificate"));
  const std::string text = slurp(out("c.md"));
  for (const char* what : {"C-17", "A. Mason", "k = 2", "B4", "SHA-256"}) EXPECT_THAT(text, HasSubstr(what));
  EXPECT_EQ(octant({"report", out("d.json"), "--certificate", out("d.json")}).exit, 2) << "over its input";
  ASSERT_EQ(octant({"report", out("d.json"), "--certificate", out("c.html")}).exit, 0);
  EXPECT_THAT(slurp(out("c.html")), HasSubstr("<!DOCTYPE html>"));
}

TEST_F(Report, WrongFilesAreExit3) {
  ASSERT_EQ(calibrate().exit, 0);
  spit(box / "not.json", "{}");
  spit(box / "old.json", R"({"type":"octant_report","version":2})");
  spit(box / "torn.json", R"({"type":"octant_report","version":1,"kind":)");
  spit(box / "part.json", R"({"type":"octant_report","version":1,"kind":"x"})");
  for (const char* name : {"not.json", "old.json", "torn.json", "part.json", "none.json"}) {
    const Outcome bad = octant({"report", box / name, "-o", out("r.html"), "--json"});
    EXPECT_EQ(bad.exit, 3) << name << bad.err;
    EXPECT_EQ(bad.json()["error"]["code"], "bad_input");
  }
  EXPECT_EQ(octant({"report", out("d.json"), "-o", out("r.html"), "--since", box / "not.json"}).exit, 3);
  EXPECT_THAT(outputs(), ElementsAre("d.json"));
}

TEST_F(Report, NothingIsReplacedUnlessAllCanBe) {
  ASSERT_EQ(calibrate({"--report", out("r.html")}).exit, 0);
  const std::string page = slurp(out("r.html")), deployment = slurp(out("d.json"));
  const Outcome refused = octant({"calibrate", box / "hall/site.yaml", box / "hall/run", "-o",
                                  box / "missing/d.json", "--report", out("r.html"), "--json"});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_EQ(refused.json()["error"]["code"], "output");
  EXPECT_EQ(octant({"report", out("d.json"), "-o", box / "missing/r.html"}).exit, 3);
  EXPECT_EQ(octant({"report", out("d.json"), "-o", "/dev/full"}).exit,
            2);  // has no ending that is understood
  EXPECT_EQ(slurp(out("r.html")), page);
  EXPECT_EQ(slurp(out("d.json")), deployment);
}

TEST_F(Report, AFullDiskLeavesTheOldReportAlone) {
  ASSERT_EQ(calibrate().exit, 0);
  std::filesystem::create_directory(box / "small");
  if (::geteuid() != 0 || ::mount("octant-test", (box / "small").c_str(), "tmpfs", 0, "size=256k") != 0)
    GTEST_SKIP() << "a small disk can be mounted by root alone, and not in every container";
  spit(box / "small/r.html", "the old one");
  const Outcome full = octant({"calibrate", box / "hall/site.yaml", box / "hall/run", "-o", out("new.json"),
                               "--report", box / "small/r.html", "--json"});
  const Outcome again = octant({"report", out("d.json"), "-o", box / "small/r.html"});
  const std::string kept = slurp(box / "small/r.html");
  const auto left = std::distance(std::filesystem::directory_iterator(box / "small"), {});
  ASSERT_EQ(::umount((box / "small").c_str()), 0);
  if (full.exit == 0) GTEST_SKIP() << "built without plotly.js: the page fits";
  EXPECT_EQ(full.exit, 3) << full.err;
  EXPECT_EQ(full.json()["error"]["code"], "output");
  EXPECT_THAT(full.err, HasSubstr("No space left on device"));
  EXPECT_EQ(again.exit, 3);
  EXPECT_EQ(kept, "the old one");
  EXPECT_EQ(left, 1);                             // no half-written file beside it
  EXPECT_THAT(outputs(), ElementsAre("d.json"));  // nor a deployment without its report
}

}  // namespace report_test
}  // namespace octant::test
