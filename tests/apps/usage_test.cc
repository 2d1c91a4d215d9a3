// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The command line as a process: words, help, exit codes of wrong usage.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace usage_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const std::vector<std::string> kCommands = {"demo",   "simulate", "calibrate", "localize", "verify",
                                            "check",  "survey",   "schema",    "batch",    "convert",
                                            "export", "plan",     "report",    "adjust",   "cockpit"};

TEST(Usage, EveryCommandHelpsWithAnExample) {
  for (const auto& command : kCommands) {
    const Outcome help = octant({command, "--help"});
    EXPECT_EQ(help.exit, 0) << command;
    EXPECT_THAT(help.out, HasSubstr("Example:\n  octant " + command));
    for (const char* common :
         {"--json", "--quiet", "--verbose", "--progress", "--threads", "--seed", "--version"})
      EXPECT_THAT(help.out, HasSubstr(common));
    EXPECT_THAT(help.err, IsEmpty());
  }
  const Outcome all = octant({"--help"});
  EXPECT_EQ(all.exit, 0);
  for (const auto& command : kCommands) EXPECT_THAT(all.out, HasSubstr("\n  " + command));
  EXPECT_THAT(all.out, HasSubstr("Example:"));
}

TEST(Usage, Version) {
  EXPECT_THAT(octant({"--version"}).out, ::testing::StartsWith("octant "));
  EXPECT_EQ(octant({"--version"}).exit, 0);
  EXPECT_EQ(octant({"calibrate", "--version"}).exit, 0);
  EXPECT_TRUE(octant({"--version", "--json"}).json()["version"].is_string());
}

TEST(Usage, WrongWordsAreExit2) {
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"fly"},
      {"calibrate"},
      {"calibrate", "site.yaml"},
      {"calibrate", "site.yaml", "run"},
      {"calibrate", "s", "r", "-o", "d", "--what"},
      {"localize", "d.json", "run", "-o", "f", "--method", "magic"},
      {"schema", "nothing"},
      {"schema"},
      {"simulate", "s.yaml"},
      {"verify", "d.json"},
      {"schema", "site", "--threads", "-1"},
      {"schema", "site", "--threads", "many"},
      {"schema", "site", "--seed", "x"},
      {"schema", "site", "--progress", "loud"},
      {"demo", "too", "many"},
      {"calibrate", "s", "r", "-o", "-", "--json"},
      {"calibrate", "s", "r", "-o", "-", "--report", "-"},
      {"report"},
      {"report", "d", "-o", "-", "--site-sheet", "-"},
      {"calibrate", "s", "r", "-o", "d", "--report", "r.pdf"},
      {"calibrate", "s", "r", "-o", "d", "--report", "r.html", "--no-report"},
      {"verify", "d", "r", "--all-methods", "--report", "r.html"},
      {"localize", "d", "r", "-o", "-", "--csv", "-"},
      {"localize", "d", "r", "-o", "-", "--json"},
      {"survey"},
      {"survey", "s", "-o", "-", "--csv", "-"},
      {"survey", "s", "--failures", "3"},
      {"survey", "s", "-o", "-", "--json"}};
  for (const auto& words : wrong) {
    const Outcome plain = octant(words);
    EXPECT_EQ(plain.exit, 2) << ::testing::PrintToString(words) << plain.err;
    if (words.empty() || words.back() != "--json") EXPECT_THAT(plain.out, IsEmpty());
    EXPECT_THAT(plain.err, HasSubstr("error:"));

    std::vector<std::string> with_json = words;
    with_json.push_back("--json");
    const Outcome json = octant(with_json);
    EXPECT_EQ(json.exit, 2) << ::testing::PrintToString(with_json);
    const auto object = json.json();
    ASSERT_TRUE(object.is_object()) << json.out;
    EXPECT_EQ(object["status"], "error");
    EXPECT_EQ(object["error"]["code"], "usage");
    EXPECT_EQ(object["error"]["exit"], 2);
    for (const char* key : {"message", "file", "line", "column", "found", "expected", "advice"})
      EXPECT_TRUE(object["error"].contains(key)) << key;
  }
}

/// Range checks would accept NaN, and loops up to infinity would not end.
TEST(Usage, WhatIsNoNumberIsNone) {
  const std::string aisles = std::string(OCTANT_SOURCE_DIR) + "/datasets/aisles/site.yaml";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"plan", aisles, "--schedule", "--height", "nan"},
        {"plan", aisles, "--schedule", "--pulse", "NaN"},
        {"survey", aisles, "--cell", "inf"},
        {"plan", aisles, "--tolerance", "-nan"},
        {"recalibrate", "d.json", "run", "-o", "n.json", "--drift-beacon-m", "nan"}}) {
    const Outcome none = octant(words);
    EXPECT_EQ(none.exit, 2) << none.err;
    EXPECT_THAT(none.err, HasSubstr("no finite number")) << words[2];
  }
}

TEST(Usage, UnknownCommandIsNamed) {
  EXPECT_THAT(octant({"fly", "me"}).err, HasSubstr("'fly'"));
  EXPECT_THAT(octant({"--threads", "2", "fly"}).err, HasSubstr("'fly'"));
  EXPECT_THAT(octant({}).err, HasSubstr("a command is missing"));
}

TEST(Usage, CommonOptionsStandBeforeAndAfterTheCommand) {
  EXPECT_EQ(octant({"--threads", "2", "-q", "schema", "site"}).exit, 0);
  EXPECT_EQ(octant({"schema", "site", "--threads", "2", "-v"}).exit, 0);
}

TEST(Usage, SchemaPrintsJson) {
  for (const char* format : {"site", "run", "deployment", "scenario", "scene"}) {
    const Outcome schema = octant({"schema", format});
    EXPECT_EQ(schema.exit, 0);
    const auto object = nlohmann::json::parse(schema.out, nullptr, false);
    ASSERT_TRUE(object.is_object()) << format;
    EXPECT_THAT(object["$schema"].get<std::string>(), HasSubstr("2020-12"));
    EXPECT_THAT(schema.err, IsEmpty());
  }
}

TEST(Usage, ColourOnlyOnATerminalAndNotWithNoColor) {
  if (!has_terminals()) GTEST_SKIP() << "no pseudo-terminals here";
  const std::vector<std::string> words = {"fly"};
  EXPECT_THAT(octant(words, {.on_terminal = true}).err, HasSubstr("\033["));
  EXPECT_THAT(octant(words).err, Not(HasSubstr("\033[")));
  EXPECT_THAT(octant(words, {.environment = {"NO_COLOR=1"}, .on_terminal = true}).err,
              Not(HasSubstr("\033[")));
  EXPECT_THAT(octant(words, {.environment = {"TERM=dumb"}, .on_terminal = true}).err,
              Not(HasSubstr("\033[")));
}

TEST(Usage, AFullDiskUnderStandardOutputIsNoSuccess) {
  EXPECT_EQ(octant({"schema", "site"}, {.out_file = "/dev/full"}).exit, 3);
  EXPECT_EQ(octant({"--version", "--json"}, {.out_file = "/dev/full"}).exit, 3);
}

}  // namespace usage_test
}  // namespace octant::test
