// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant batch as a process: many sites, some of them broken.
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace batch_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Batch : public ::testing::Test {
 protected:
  void SetUp() override {
    spit(box / "scenario.yaml", hall_scenario_text("epochs: 150", "epochs: 40"));
    for (const char* seed : {"1", "2"})
      ASSERT_EQ(octant({"simulate", box / "scenario.yaml", "-o", box / (std::string("hall") + seed), "--seed",
                        seed})
                    .exit,
                0);
  }
  /// A list: hall 1, a missing site, an invalid run, hall 2 with a report.
  void list(const std::string& more = "") const {
    spit(box / "sites.yaml",
         "octant_batch: 1\nsites:\n"
         "- {site: hall1/site.yaml, runs: [hall1/run], output: one.json}\n"
         "- {site: nowhere/site.yaml, runs: [hall1/run], output: two.json}\n"
         "- {name: third, site: hall1/site.yaml, runs: [hall1], output: three.json, report: three.html}\n"
         "- {site: hall2/site.yaml, runs: [hall2/run], output: four.json, report: four.html}\n" +
             more);
  }
  [[nodiscard]] Outcome batch(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"batch", box / "sites.yaml", "-o", box / "out"};
    words.insert(words.end(), more.begin(), more.end());
    return octant(words, made_at_zero());
  }
  static RunOptions made_at_zero() {
    RunOptions options;
    options.environment = {"SOURCE_DATE_EPOCH=0"};
    return options;
  }
  [[nodiscard]] std::vector<std::string> outputs() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(box / "out"))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  /// A deployment less the command it was made with, and the digest of all of it.
  [[nodiscard]] static nlohmann::json content(const std::string& path) {
    nlohmann::json object = nlohmann::json::parse(slurp(path));
    for (const char* key : {"program", "digest"}) object.erase(key);
    return object;
  }
  TemporaryFolder box;
};

TEST_F(Batch, ABrokenSiteDoesNotStopTheOthers) {
  list();
  const Outcome all = batch({"--json"});
  EXPECT_EQ(all.exit, 3) << "that of the first site that failed";
  const auto object = all.json();
  EXPECT_EQ(object["status"], "error");
  EXPECT_EQ(object["calibrated"], 2);
  EXPECT_EQ(object["failed"], 2);
  ASSERT_EQ(object["sites"].size(), 4u) << "in the order of the list";
  std::vector<int> exits;
  for (const auto& site : object["sites"]) exits.push_back(site["exit"]);
  EXPECT_THAT(exits, ElementsAre(0, 3, 3, 0));
  EXPECT_GT(object["sites"][0]["arrivals"], 100);
  EXPECT_EQ(object["sites"][0]["beacons"].size(), 8u);
  EXPECT_THAT(object["sites"][1]["error"]["message"].get<std::string>(), HasSubstr("nowhere/site.yaml"));
  EXPECT_EQ(object["sites"][2]["name"], "third");
  EXPECT_THAT(object["sites"][2]["error"]["message"].get<std::string>(), HasSubstr("none of tof.csv"));
  EXPECT_EQ(object["sites"][3]["status"], "ok");
  EXPECT_THAT(outputs(), ElementsAre("four.html", "four.json", "one.json")) << "nothing of those that failed";
}

TEST_F(Batch, IsWhatCalibrateFindsWhateverTheThreads) {
  list();
  ASSERT_EQ(octant({"calibrate", box / "hall2/site.yaml", box / "hall2/run", "-o", box / "alone.json"},
                   made_at_zero())
                .exit,
            0);
  for (const char* threads : {"1", "3"}) {
    EXPECT_EQ(batch({"--threads", threads}).exit, 3);
    EXPECT_EQ(content(box / "out/four.json"), content(box / "alone.json")) << threads;
  }
}

TEST_F(Batch, TellsPeopleInATable) {
  list();
  const Outcome all = batch();
  EXPECT_THAT(all.out, HasSubstr("hall1/site.yaml"));
  EXPECT_THAT(all.out, HasSubstr("variance"));
  EXPECT_THAT(all.err, HasSubstr("2 of 4 sites failed, the first is nowhere/site.yaml"));
  EXPECT_THAT(all.err, HasSubstr("none of tof.csv"));
  EXPECT_THAT(batch({"-q"}).err, Not(HasSubstr("calibrated")));
}

TEST_F(Batch, ShardsShareTheList) {
  list();
  const auto first = batch({"--shard", "1/3", "--json"}).json(),
             second = batch({"--shard", "2/3", "--json"}).json();
  ASSERT_EQ(first["sites"].size(), 2u);
  EXPECT_EQ(first["status"], "ok");
  EXPECT_THAT(outputs(), ElementsAre("four.html", "four.json", "one.json"));
  ASSERT_EQ(second["sites"].size(), 1u);
  EXPECT_THAT(second["sites"][0]["site"].get<std::string>(), HasSubstr("nowhere"));
  const Outcome beyond = batch({"--shard", "9/9", "--json"});
  EXPECT_EQ(beyond.exit, 0) << "there may be more jobs than sites";
  EXPECT_THAT(beyond.json()["sites"], IsEmpty());
  for (const char* bad : {"0/3", "4/3", "1", "a/b", "1/3x", "-1/3", "1/0"})
    EXPECT_EQ(batch({"--shard", bad}).exit, 2) << bad;
}

TEST_F(Batch, RefusesAListThatIsNone) {
  spit(box / "sites.yaml", "- nothing\n");
  EXPECT_EQ(batch({"--json"}).json()["error"]["exit"], 3);
  EXPECT_FALSE(std::filesystem::exists(box / "out")) << "nothing is made for it";
}

TEST_F(Batch, AnInterruptionLeavesWholeFiles) {
  std::string more;
  for (int i = 0; i < 60; ++i)
    more += "- {site: hall2/site.yaml, runs: [hall2/run], output: more" + std::to_string(i) + ".json}\n";
  list(more);
  RunOptions options;
  options.interrupt_signal = SIGINT;  // as soon as the first site is reported
  const Outcome stopped =
      octant({"batch", box / "sites.yaml", "-o", box / "out", "--json", "--threads", "2"}, options);
  EXPECT_EQ(stopped.exit, 130) << stopped.err;
  EXPECT_EQ(stopped.json()["status"], "interrupted");
  EXPECT_EQ(stopped.json()["sites"].size(), 64u);
  for (const std::string& name : outputs()) EXPECT_THAT(name, Not(HasSubstr("tmp")));
  const nlohmann::json told = stopped.json();
  for (const auto& site : told["sites"]) {
    const std::string output = site["output"];
    EXPECT_EQ(std::filesystem::exists(output), site["status"] == "ok") << output;
    if (site["status"] == "ok") EXPECT_EQ(nlohmann::json::parse(slurp(output))["type"], "octant_deployment");
  }
}

}  // namespace batch_test
}  // namespace octant::test
