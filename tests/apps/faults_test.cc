// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The system fails while octant works: tests/support/faults/faulty_system.cc, and limits of its own.
#include <sys/resource.h>

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace faults_test {

using ::testing::AnyOf;
using ::testing::HasSubstr;

class Faults : public HallFolder {
 protected:
  void SetUp() override {
    if (std::string(OCTANT_FAULTY_SYSTEM).empty())
      GTEST_SKIP() << "a sanitizer wants to be loaded before all else: faults were not injected";
    make(30);
    ASSERT_EQ(calibrate().exit, 0);
    ASSERT_EQ(octant({"sign", "--new-key", box / "key"}).exit, 0);
  }
  static RunOptions with(const std::string& faults) {
    return {.environment = {"LD_PRELOAD=" OCTANT_FAULTY_SYSTEM, "OCTANT_FAULTS=" + faults}};
  }
  [[nodiscard]] std::vector<std::string> calibrating(const std::string& to) const {
    return {"calibrate", hall("site.yaml"), hall("run"), "-o", out(to), "--progress", "none"};
  }
  /// Commands that write, with their outputs in out().
  [[nodiscard]] std::vector<std::vector<std::string>> writers() const {
    const std::string d = out("d.json"), heldout = hall("heldout"), site = hall("site.yaml");
    std::vector<std::string> with_report = calibrating("new.json");
    with_report.insert(with_report.end(), {"--report", out("new.html")});
    return {with_report,
            {"recalibrate", d, hall("run"), "-o", out("new.json")},
            {"localize", d, heldout, "-o", out("new.tum"), "--csv", out("new.csv")},
            {"verify", d, heldout, "--report", out("new.html")},
            {"survey", d, "-o", out("new.html"), "--csv", out("new.csv")},
            {"report", d, "--certificate", out("new.html")},
            {"init", hall("run"), "-o", out("new.yaml")},
            {"sign", d, "--key", box / "key", "-o", out("new.json")}};
  }
};

/// A deployment without what differs from run to run.
nlohmann::json content_of(const std::string& path) {
  nlohmann::json object = nlohmann::json::parse(slurp(path));
  object.erase("created");
  object.erase("digest");
  object.erase("program");
  return object;
}

TEST_F(Faults, AFullDiskLeavesNothingHalfWritten) {
  const auto before = outputs();
  for (const std::string bytes : {"0", "100", "3000"})
    for (const auto& words : writers()) {
      const Outcome outcome = octant(words, with("full=" + bytes));
      EXPECT_EQ(outcome.exit, 3) << words.front() << ": " << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr("No space left on device")) << words.front();
      EXPECT_EQ(outputs(), before) << words.front();
    }
}

TEST_F(Faults, AHistoryOnAFullDiskStaysWhatItWas) {
  const std::string d = out("d.json"), db = out("site.octant.db"), fresh = out("fresh.octant.db");
  ASSERT_EQ(octant({"history", "add", d, "--db", db}).exit, 0);
  ASSERT_EQ(octant({"calibrate", hall("site.yaml"), hall("run"), hall("heldout"), "-o", out("e.json")}).exit,
            0);
  for (const std::string bytes : {"0", "3000", "20000"}) {
    const Outcome outcome = octant({"history", "add", out("e.json"), "--db", db}, with("full=" + bytes));
    EXPECT_EQ(outcome.exit, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("is there space"));
    EXPECT_EQ(octant({"history", "list", "--db", db, "--json"}).json()["visits"].size(), 1U) << bytes;
    EXPECT_EQ(octant({"history", "add", d, "--db", fresh}, with("full=" + bytes)).exit, 3);
  }
  EXPECT_EQ(octant({"history", "add", d, "--db", fresh}).exit, 0) << "an empty one is no obstacle";
}

TEST_F(Faults, NorDoesADiskThatTakesNothingOrLosesIt) {
  const auto before = outputs();
  for (const std::string fault : {"read_only", "no_flush"})
    for (const auto& words : writers()) {
      const Outcome outcome = octant(words, with(fault));
      EXPECT_EQ(outcome.exit, 3) << fault << " " << words.front() << ": " << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr("cannot be written")) << words.front();
      EXPECT_EQ(outputs(), before) << words.front();
    }
  EXPECT_EQ(octant({"simulate", box / "scenario.yaml", "-o", box / "world"}, with("read_only")).exit, 3);
  EXPECT_FALSE(std::filesystem::exists(box / "world"));
}

TEST_F(Faults, ASmallestFileThatTheSystemAllowsIsSaid) {
  const Outcome outcome =
      octant(calibrating("new.json"), {.limits = {{RLIMIT_FSIZE, 4096}}});  // SIGXFSZ would end it
  EXPECT_EQ(outcome.exit, 3) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("File too large"));
  EXPECT_FALSE(std::filesystem::exists(out("new.json")));
}

TEST_F(Faults, InterruptedAndShortCallsChangeNothing) {
  const auto expected = content_of(out("d.json"));
  for (const std::string faults : {"interrupted", "short", "no_map", "no_map short interrupted"}) {
    const Outcome outcome = octant(calibrating("new.json"), with(faults));
    ASSERT_EQ(outcome.exit, 0) << faults << ": " << outcome.err;
    EXPECT_EQ(content_of(out("new.json")), expected) << faults;
  }
  EXPECT_EQ(octant({"history", "add", out("d.json"), "--db", out("h.octant.db")}, with("interrupted")).exit,
            0);
  EXPECT_EQ(octant({"survey", out("d.json"), "-o", out("s.html")}, with("interrupted short")).exit, 0);
}

TEST_F(Faults, ARecordingThatGrowsOrIsReplacedIsReadAsItWas) {
  const auto expected = content_of(out("d.json"));
  const std::string tof = slurp(hall("run/tof.csv"));
  for (const std::string faults : {"grow=tof.csv", "replace=tof.csv"}) {
    const Outcome outcome = octant(calibrating("new.json"), with(faults));
    ASSERT_EQ(outcome.exit, 0) << faults << ": " << outcome.err;
    EXPECT_NE(slurp(hall("run/tof.csv")), tof) << "nothing happened to it";
    EXPECT_EQ(content_of(out("new.json")), expected) << faults << ": values and digests of what was read";
    spit(hall("run/tof.csv"), tof);
  }
}

TEST_F(Faults, ARecordingThatIsCutOffIsSaid) {
  const std::string tof = slurp(hall("run/tof.csv"));
  const Outcome talk = octant(calibrating("new.json"), with("cut=tof.csv"));
  EXPECT_EQ(talk.exit, 3) << talk.err;
  EXPECT_THAT(talk.err, HasSubstr("has become shorter"));
  spit(hall("run/tof.csv"), tof);
  std::vector<std::string> words = calibrating("new.json");
  words.push_back("--json");
  const Outcome json = octant(words, with("cut=tof.csv"));
  EXPECT_EQ(json.exit, 3);
  EXPECT_EQ(json.json()["error"]["code"], "bad_input") << json.out;
  EXPECT_FALSE(std::filesystem::exists(out("new.json")));
}

TEST_F(Faults, AClockThatRunsBackwardsIsNoMatter) {
  ASSERT_EQ(octant(calibrating("new.json"), with("clock_back")).exit, 0);
  EXPECT_EQ(content_of(out("new.json")), content_of(out("d.json")));
  const std::string db = out("site.octant.db");
  for (const std::string name : {"d.json", "new.json"})  // the later one is the elder
    EXPECT_EQ(octant({"history", "add", out(name), "--db", db}, with("clock_back")).exit, 0);
  EXPECT_EQ(octant({"history", "trend", "--db", db}, with("clock_back")).exit, 0);
}

TEST_F(Faults, ALimitOfMemoryIsSaid) {
  // Memory limits from the need of the program's libraries to that of a calibration of this size: some
  // refusals, no crash.
  make(hall_scenario_text("epochs: 150", "epochs: 3000"));
  int refused = 0;
  for (rlim_t mb = 41; mb <= 131; mb += 3) {
    const Outcome outcome =
        octant({"calibrate", hall("site.yaml"), hall("run"), "-o", out("big.json"), "--threads", "2"},
               {.limits = {{RLIMIT_AS, mb << 20}}});
    if (outcome.exit == 0) break;
    if (outcome.exit == 127) continue;  // not even its libraries
    ++refused;
    EXPECT_EQ(outcome.exit, 1) << mb << " MB: " << outcome.err;
    EXPECT_THAT(outcome.err, AnyOf(HasSubstr("out of memory"), HasSubstr("the system gives no more")));
    EXPECT_FALSE(std::filesystem::exists(out("big.json")));
  }
  EXPECT_GT(refused, 0);
}

}  // namespace faults_test
}  // namespace octant::test
