// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// First steps of a new user: an initial site file, help, completion, glossary.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace first_hour_test {

using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  for (const std::string& line : lines_of(text)) longest = std::max(longest, line.size());
  return longest;
}

/// Commands as the program's help lists them.
std::vector<std::string> commands() {
  std::vector<std::string> names;
  bool listed = false;
  for (const std::string& line : lines_of(octant({"--help"}).out)) {
    if (line.empty()) listed = false;
    if (listed && line.starts_with("  ") && line[2] != ' ')
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
    if (line.starts_with("Subcommands")) listed = true;
  }
  return names;
}

class Init : public HallFolder {
 protected:
  void SetUp() override { make(12); }  // check looks for beacons of which nothing is known
};

TEST_F(Init, WritesASiteFileThatCheckTakesAsItIs) {
  for (const char* kind : {"ultrasound", "uwb", "underwater"}) {
    const std::string site = out(std::string(kind) + ".yaml");
    const Outcome made = octant({"init", hall("run"), "--for", kind, "-o", site});
    ASSERT_EQ(made.exit, 0) << made.err;
    EXPECT_THAT(made.out, HasSubstr("octant check " + site));
    const std::string text = slurp(site);
    for (const char* id : {"{id: B0}", "{id: B7}", "{id: r0, position_m", "{id: r7, position_m"})
      EXPECT_THAT(text, HasSubstr(id));
    EXPECT_LT(longest_line(text), 110U);
    const Outcome check = octant({"check", site, hall("run"), "--json"});
    EXPECT_NE(check.exit, 3) << check.err;
    EXPECT_NE(check.exit, 2) << check.err;
    EXPECT_THAT(check.err, Not(HasSubstr("unknown key")));
    EXPECT_THAT(check.err, Not(HasSubstr("is not given"))) << "the template leaves nothing to assume";
  }
}

TEST_F(Init, FilledInItIsASiteThatCalibrates) {
  make(40);
  ASSERT_EQ(octant({"init", hall("run"), "-o", out("site.yaml")}).exit, 0);
  std::string text = slurp(out("site.yaml"));
  // Site file of a new user: the beacons of the simulated site, the octagon, the temperature.
  const std::string known = slurp(hall("site.yaml"));
  const auto block = [](const std::string& of, const std::string& from, const std::string& to) {
    const std::size_t begin = of.find(from);
    return of.substr(begin, of.find(to, begin) - begin);
  };
  const std::string old_beacons = block(text, "\nbeacons:", "\n# Where the receivers"),
                    old_vehicles = block(text, "vehicles:", "\n# What the site must");
  text.replace(text.find(old_beacons), old_beacons.size(), "\n" + block(known, "beacons:", "vehicles:"));
  text.replace(text.find(old_vehicles), old_vehicles.size(), block(known, "vehicles:", "tolerance:"));
  spit(out("site.yaml"), text);
  const Outcome calibrated =
      octant({"calibrate", out("site.yaml"), hall("run"), "-o", out("d.json"), "--json"});
  EXPECT_EQ(calibrated.exit, 0) << calibrated.err;
}

TEST_F(Init, NeedsNoRunAndOverwritesNothing) {
  const Outcome plain = octant({"init"});
  EXPECT_EQ(plain.exit, 0);
  EXPECT_THAT(plain.out, HasSubstr("octant_site: 1"));
  spit(out("mine.yaml"), "mine");
  EXPECT_EQ(octant({"init", hall("run"), "-o", out("mine.yaml")}).exit, 2);
  EXPECT_EQ(slurp(out("mine.yaml")), "mine");
  EXPECT_EQ(octant({"init", box / "none"}).exit, 3);
  EXPECT_EQ(octant({"init", "--for", "sonar"}).exit, 2);
  EXPECT_EQ(octant({"init", hall("run"), "--json"}).exit, 2) << "one of the two has standard output";
  EXPECT_EQ(octant({"init", hall("run"), "--json", "-o", out("site.yaml")}).json()["beacons"].size(), 8U);
}

TEST(Help, FitsATerminalAndNamesTheProgram) {
  const auto names = commands();
  ASSERT_GT(names.size(), 15U);
  for (const std::string& name : names) {
    const std::string help = octant({name, "--help"}).out;
    EXPECT_LE(longest_line(help), 80U) << help;
    EXPECT_THAT(help, HasSubstr("Usage: octant " + name)) << help;
    for (const char* spelling : {" in [", ":{", "UINT", "Excludes", "REQUIRED"})
      EXPECT_THAT(help, Not(HasSubstr(spelling))) << "a programmer's spelling";
    const std::size_t own = help.find("\nOptions:"), common = help.find("\nCommon options:");
    if (own != std::string::npos) EXPECT_LT(own, common) << help;
    EXPECT_EQ(octant({"help", name}).out, help);
  }
  EXPECT_LE(longest_line(octant({"--help"}).out), 80U);
  EXPECT_THAT(octant({"help", "history", "trend"}).out, HasSubstr("Usage: octant history trend"));
}

TEST(Help, GuessesWhatWasMeant) {
  for (const auto& [words, meant] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"calbrate"}, "did you mean 'calibrate'?"},
           {{"help", "calbrate"}, "did you mean 'calibrate'?"},
           {{"survy", "site.yaml"}, "did you mean 'survey'?"},
           {{"calibrate", "s", "r", "-o", "d", "--reprot", "x"}, "did you mean '--report'?"},
           {{"localize", "d", "r", "-o", "f", "--metod=auto"}, "did you mean '--method'?"},
           {{"explain", "datun"}, "did you mean 'datum'?"}}) {
    const Outcome outcome = octant(words);
    EXPECT_EQ(outcome.exit, 2) << words.front();
    EXPECT_THAT(outcome.err, HasSubstr(meant)) << words.front();
  }
}

TEST(Help, VersionNamesTheCommit) {
  const Outcome json = octant({"--version", "--json"});
  EXPECT_TRUE(json.json().contains("commit")) << json.out;
  EXPECT_TRUE(
      std::regex_match(octant({"--version"}).out, std::regex("octant [0-9.]+( \\([0-9a-f]{7,}\\))?\n")));
}

TEST(Help, ManPageHasEachCommandAndOption) {
  const Outcome man = octant({"help", "--man"});
  ASSERT_EQ(man.exit, 0);
  EXPECT_TRUE(man.out.starts_with(".TH OCTANT 1"));
  for (const std::string& name : commands()) {
    std::string escaped = name;
    for (std::size_t at = 0; (at = escaped.find('-', at)) != std::string::npos; at += 2)
      escaped.insert(at, "\\");
    EXPECT_THAT(man.out, HasSubstr(".SS octant " + escaped + "\n"));
  }
  EXPECT_THAT(man.out, HasSubstr("\\-\\-memory\\-mb"));
  EXPECT_THAT(man.out, HasSubstr(".SH EXIT STATUS"));
}

class FirstMistakes : public HallFolder {
 protected:
  void SetUp() override { make(12); }
  /// Returns the program's message, and checks its exit code.
  std::string said(const std::vector<std::string>& words, int exit) {
    const Outcome outcome = octant(words);
    EXPECT_EQ(outcome.exit, exit) << outcome.err;
    return outcome.err;
  }
};

TEST_F(FirstMistakes, AreAnsweredWithTheWayOut) {
  EXPECT_THAT(said({}, 2), HasSubstr("octant demo shows a site from recording to report"));
  // No site file, or behind the recording.
  EXPECT_THAT(said({"calibrate", hall("run"), "-o", out("d.json")}, 2),
              HasSubstr("octant init " + hall("run")));
  EXPECT_THAT(said({"check", hall("run")}, 2), HasSubstr("is a folder, so a recording, and the site file"));
  EXPECT_THAT(said({"calibrate", hall("run"), hall("site.yaml"), "-o", out("d.json")}, 3),
              HasSubstr("a site file, which stands before the run folders"));
  // The parent folder, a missing folder, an empty folder.
  for (const char* command : {"calibrate", "init"}) {
    std::vector<std::string> words = {command, hall("")};
    if (words[0] == "calibrate") words = {"calibrate", hall("site.yaml"), hall(""), "-o", out("d.json")};
    EXPECT_THAT(said(words, 3),
                HasSubstr("did you mean '" + hall("heldout") + "' or '" + hall("run") + "'?"));
  }
  EXPECT_THAT(said({"init", out("none")}, 3),
              HasSubstr("No such file or directory; expected a folder with tof.csv"));
  EXPECT_THAT(said({"init", out("")}, 3), HasSubstr("is this the run folder?"));
  spit(out("kit.csv"), "p,q,v\n1220,A3,1583.9\n");
  EXPECT_THAT(said({"convert", out("kit.csv"), "-o", out("c")}, 3), HasSubstr("--columns time=COLUMN"));
  // A recording where the deployment belongs, and a word that is missing.
  for (const std::vector<std::string>& words : {std::vector<std::string>{"localize", "-o", out("f")},
                                                {"verify"},
                                                {"monitor"},
                                                {"recalibrate", "-o", out("f")}}) {
    std::vector<std::string> line = words;
    line.insert(line.end(), {hall("run"), out("d.json")});
    EXPECT_THAT(said(line, 3), HasSubstr("a deployment file, which stands before the run folders"));
  }
  EXPECT_THAT(said({"simulate", hall("site.yaml"), "-o", out("w")}, 3),
              HasSubstr("a site file; expected octant_scenario: 1"));
  EXPECT_THAT(said({"monitor", out("d.json"), hall("run"), "--drift-beacon-m", "0"}, 2),
              HasSubstr("--drift-beacon-m: Value 0 is not above 0;"));
  EXPECT_THAT(said({"diff", out("d.json")}, 2), HasSubstr("B.json is required (The later deployment)"));
  EXPECT_THAT(said({"schema", "cell.csv"}, 2), HasSubstr("did you mean 'cells.csv'?"));
}

TEST_F(FirstMistakes, AGermanTableIsReadByTheCommandThatTheMessageNames) {
  std::string text = slurp(hall("run/tof.csv"));
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace(text.begin(), text.end(), '.', ',');
  std::filesystem::create_directory(out("german"));
  spit(out("german/tof.csv"), text);
  const std::string told = said({"check", hall("site.yaml"), out("german")}, 3);
  std::smatch command;
  ASSERT_TRUE(std::regex_search(told, command, std::regex("octant convert (\\S+) -o RUN"))) << told;
  const Outcome converted = octant({"convert", command[1], "-o", out("run")});
  ASSERT_EQ(converted.exit, 0) << converted.err;
  const Outcome a = octant({"check", hall("site.yaml"), out("run"), "--json"}),
                b = octant({"check", hall("site.yaml"), hall("run"), "--json"});
  EXPECT_EQ(a.json()["beacons"], b.json()["beacons"]);
}

TEST_F(FirstMistakes, ANeighboursBeaconIsLeftOutByTheCommandThatTheMessageNames) {
  spit(out("site.yaml"), std::regex_replace(slurp(hall("site.yaml")), std::regex("id: B7"), "id: B77"));
  const std::string told = said({"check", out("site.yaml"), hall("run")}, 3);
  std::smatch command;
  ASSERT_TRUE(
      std::regex_search(told, command, std::regex("octant convert (\\S+) --ignore '(\\S+)' -o RUN leaves")))
      << told;
  const Outcome converted = octant({"convert", command[1], "--ignore", command[2], "-o", out("run")});
  ASSERT_EQ(converted.exit, 0) << converted.err;
  const std::string before = slurp(hall("run/tof.csv")), after = slurp(out("run/tof.csv"));
  EXPECT_EQ(before.substr(0, before.find('\n')).size(), after.substr(0, after.find('\n')).size())
      << "the same columns";
  EXPECT_THAT(after, Not(HasSubstr(",B7,")));
  EXPECT_EQ(octant({"check", out("site.yaml"), out("run")}).exit, 0);
}

TEST_F(FirstMistakes, CommandsToCopyAreQuoted) {
  const std::string run = out("run one");
  std::filesystem::copy(hall("run"), run);
  EXPECT_THAT(octant({"init", run, "-o", out("my site.yaml")}).out,
              HasSubstr("octant check '" + out("my site.yaml") + "' '" + run + "'"));
}

TEST(Defaults, StandBehindWhatIsTyped) {
  TemporaryFolder box;
  spit(box / "mine.yaml", "octant_defaults: 1\nverbose: true\nprogress: plain\nthreads: 1\n");
  const RunOptions mine{.environment = {"OCTANT_DEFAULTS=" + (box / "mine.yaml")}};
  EXPECT_THAT(octant({"schema", "--help"}, mine).out, HasSubstr("plain, json or none [plain]"));
  const Outcome world = octant({"demo", "-o", box / "hall"}, mine);
  ASSERT_EQ(world.exit, 0) << world.err;
  EXPECT_THAT(world.err, HasSubstr(" % ")) << "plain progress, as asked for";
  EXPECT_EQ(octant({"demo", "-o", box / "quiet", "-q", "--progress", "none"}, mine).err, "");
  std::filesystem::create_directories(box / "config/octant");
  spit(box / "config/octant/defaults.yaml", "octant_defaults: 1\nthreads: many\n");
  const Outcome wrong = octant({"schema", "site"}, {.environment = {"XDG_CONFIG_HOME=" + (box / "config")}});
  EXPECT_EQ(wrong.exit, 3);
  EXPECT_THAT(wrong.err, HasSubstr("defaults.yaml:2:"));
  const Outcome without = octant(
      {"schema", "site"}, {.environment = {"XDG_CONFIG_HOME=" + (box / "config"), "OCTANT_DEFAULTS="}});
  EXPECT_EQ(without.exit, 0) << without.err;
}

TEST(Completion, KnowsCommandsAndOptions) {
  const std::string bash = octant({"completion", "bash"}).out;
  TemporaryFolder box;
  spit(box / "octant.bash", bash);
  // Completions that bash would offer after these words.
  const auto offered = [&](const std::string& words, int last) {
    const std::string script = ". " + (box / "octant.bash") + "; COMP_WORDS=(" + words +
                               "); COMP_CWORD=" + std::to_string(last) +
                               "; _octant; printf '%s\\n' \"${COMPREPLY[@]}\" > " + (box / "out");
    EXPECT_EQ(std::system(("bash -c '" + std::regex_replace(script, std::regex("'"), "'\\''") + "'").c_str()),
              0);
    return slurp(box / "out");
  };
  if (std::system("bash -c : 2>/dev/null") == 0) {
    EXPECT_EQ(offered("octant calib", 1), "calibrate\n");
    EXPECT_THAT(offered("octant calibrate site.yaml --memo", 3), HasSubstr("--memory-mb"));
    EXPECT_THAT(offered("octant history tr", 2), HasSubstr("trend"));
  }
  const std::string zsh = octant({"completion", "zsh"}).out, fish = octant({"completion", "fish"}).out;
  for (const std::string& name : commands()) {
    EXPECT_THAT(bash, HasSubstr(name));
    EXPECT_THAT(zsh, HasSubstr("'" + name + ":"));
    EXPECT_THAT(fish, HasSubstr("-a " + name + " "));
  }
  EXPECT_EQ(octant({"completion", "tcsh"}).exit, 2);
}

TEST(Explain, KnowsTheWordsOfTheOutputs) {
  for (const char* word : {"variance factor",
                           "variance_factor",
                           "datum",
                           "epoch",
                           "MDB",
                           "NEES",
                           "redundancy",
                           "r",
                           "residuals",
                           "p",
                           "control point",
                           "protection level",
                           "protection_level_m",
                           "late",
                           "early",
                           "late (echo)",
                           "moves",
                           "w",
                           "azimuth",
                           "sx",
                           "hdop",
                           "unknowns",
                           "arrivals",
                           "weak",
                           "tolerance",
                           "undetermined",
                           "time-walk",
                           "Good",
                           "Not good enough",
                           "Contradicted",
                           "Refused",
                           "no_consensus",
                           "ambiguous",
                           "too_few_arrivals",
                           "poor_geometry",
                           "not_converged",
                           "exit 5",
                           "0",
                           "1",
                           "2",
                           "3",
                           "4",
                           "6",
                           "130",
                           "chi2_p",
                           "rms_s",
                           "white_sigma_m",
                           "held fixed",
                           "moved most"}) {
    const Outcome outcome = octant({"explain", word});
    EXPECT_EQ(outcome.exit, 0) << word << ": " << outcome.err;
    EXPECT_GT(outcome.out.size(), 40U) << word;
    EXPECT_LE(longest_line(outcome.out), 80U) << word;
  }
  EXPECT_THAT(octant({"explain", "variance", "factor"}).out, HasSubstr("variance factor: "));
  EXPECT_EQ(octant({"explain"}).exit, 0);
  EXPECT_EQ(octant({"explain", "6", "--json"}).json()["term"], "exit 6");
}

}  // namespace first_hour_test
}  // namespace octant::test
