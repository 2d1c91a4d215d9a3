// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The guide as followed by a reader: every command, and its output.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace guide_test {

namespace fs = std::filesystem;

fs::path guide() { return fs::path(OCTANT_SOURCE_DIR) / "apps/guide"; }

struct Block {
  std::string commands;
  std::optional<std::string> printed;
};

std::vector<Block> blocks_of(const std::string& page) {
  std::vector<Block> blocks;
  std::istringstream in(page);
  std::string* into = nullptr;
  for (std::string line, before; std::getline(in, line); before = line) {
    if (line.starts_with("```")) {
      const bool closes = into != nullptr;
      into = nullptr;
      if (closes) continue;
      if (line == "```sh") into = &blocks.emplace_back().commands;
      if (line == "```text" && before == "```") into = &blocks.back().printed.emplace();
      continue;
    }
    if (into != nullptr) *into += line + "\n";
  }
  return blocks;
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// Equal words; numbers within the last digits that may differ between processors; times are ignored.
bool alike(const std::string& said, const std::string& printed) {
  const auto a = words_of(said), b = words_of(printed);
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] == b[i]) continue;
    char *end_a = nullptr, *end_b = nullptr;
    const double x = std::strtod(a[i].c_str(), &end_a), y = std::strtod(b[i].c_str(), &end_b);
    if (end_a == a[i].c_str() || std::string(end_a) != end_b) return false;
    const bool seconds = i + 1 < a.size() && a[i + 1] == "s" && a[0] == "hall:";
    if (!seconds && std::abs(x - y) > 0.03 * std::max(std::abs(x), std::abs(y)) + 0.02) return false;
  }
  return true;
}

/// Returns true if an output matches an expected text, in which a line of "..." matches any lines.
testing::AssertionResult prints(const std::string& said, const std::string& printed) {
  std::istringstream in_said(said), in_printed(printed);
  bool any = false;
  std::string line, now;
  while (std::getline(in_said, line)) {
    if (line == "...") {
      any = true;
      continue;
    }
    do {
      if (!std::getline(in_printed, now))
        return testing::AssertionFailure()
               << "the guide says: " << line << "\nand nothing like it is printed:\n"
               << printed;
    } while (any && !alike(line, now));
    if (!alike(line, now))
      return testing::AssertionFailure() << "the guide says: " << line << "\nprinted is:     " << now;
    any = false;
  }
  if (!any && std::getline(in_printed, now)) return testing::AssertionFailure() << "printed too: " << now;
  return testing::AssertionSuccess();
}

/// The folder of the sources for a new user, after the build: commands that would install or compile record
/// their arguments. Packages and the build itself are tested by tests/run.sh, with the same list and preset.
class Checkout {
 public:
  Checkout() {
    const fs::path sources = OCTANT_SOURCE_DIR;
    for (const char* name : {"datasets", "apps", "CMakePresets.json"})
      fs::create_symlink(sources / name, box_ / name);
    fs::create_directories(box_ / "build/release/bin");
    fs::create_symlink(OCTANT_BINARY, box_ / "build/release/bin/octant");
    fs::create_directories(box_ / "shims");
    for (const char* name : {"cmake", "apt-get", "sudo"}) {
      spit(box_ / "shims" / name,
           "#!/bin/sh\necho \"" + std::string(name) + " $*\" >> '" + (box_ / "asked.txt").string() + "'\n");
      fs::permissions(box_ / "shims" / name, fs::perms::owner_all);
    }
  }

  /// Runs a block of commands in a shell; `out` has its standard output, `err` its standard error.
  int run(const std::string& commands) {
    spit(box_ / "block.sh", commands);
    const std::string line = "cd '" + box_.string() + "' && PATH='" + (box_ / "shims").string() + "':'" +
                             (box_ / "build/release/bin").string() +
                             "':\"$PATH\" NO_COLOR=1 OCTANT_DEFAULTS= sh block.sh > out.txt 2> err.txt";
    const int status = std::system(line.c_str());
    out = slurp((box_ / "out.txt").string()), err = slurp((box_ / "err.txt").string());
    return status;
  }

  [[nodiscard]] std::string asked() const {
    return fs::exists(box_ / "asked.txt") ? slurp((box_ / "asked.txt").string()) : std::string();
  }
  [[nodiscard]] fs::path operator/(const std::string& name) const { return box_ / name; }
  std::string out, err;

 private:
  TemporaryFolder folder_;
  fs::path box_ = folder_.path();
};

class Guide : public testing::TestWithParam<std::string> {};

TEST_P(Guide, EachCommandPrintsWhatThePageSays) {
  const auto blocks = blocks_of(slurp((guide() / GetParam()).string()));
  ASSERT_GE(blocks.size(), 2U);
  Checkout checkout;
  for (const Block& block : blocks) {
    const int status = checkout.run(block.commands);
    if (!block.printed) {
      EXPECT_EQ(status, 0) << block.commands << checkout.err;
      continue;
    }
    EXPECT_TRUE(prints(*block.printed, checkout.out)) << block.commands << checkout.err;
  }
}

// A new user types the commands of the first page on a new machine, and gets a verified deployment.
TEST(GuidePages, FromABareMachineToAVerifiedDeployment) {
  Checkout newcomer;
  bool verified = false, installed = false;
  for (const Block& block : blocks_of(slurp((guide() / "1-first-site.md").string()))) {
    ASSERT_EQ(newcomer.run(block.commands), 0) << block.commands << newcomer.err;
    if (!installed) {  // the first thing that the page asks for
      EXPECT_NE(newcomer.asked().find("cmake --preset release "), std::string::npos) << newcomer.asked();
      EXPECT_NE(newcomer.asked().find("cmake --build --preset release --target octant"), std::string::npos);
      EXPECT_TRUE(fs::exists(newcomer / "demo/report.html"));
      installed = true;
    }
    if (block.commands.find("octant verify hall.json") != std::string::npos)
      verified = newcomer.out.find("gate fix_m       kept") != std::string::npos;
  }
  EXPECT_TRUE(verified);
  EXPECT_TRUE(fs::exists(newcomer / "hall.json"));
  EXPECT_TRUE(fs::exists(newcomer / "fixes.tum"));
  // The presets that the script asks for are there, and build where the page looks for the program.
  const auto presets = nlohmann::json::parse(slurp((newcomer / "CMakePresets.json").string()));
  for (const char* kind : {"configurePresets", "buildPresets"})
    EXPECT_TRUE(std::any_of(presets[kind].begin(), presets[kind].end(), [](const auto& preset) {
      return preset["name"] == "release";
    })) << kind;
  EXPECT_EQ(presets["configurePresets"][0].value("binaryDir", ""), "${sourceDir}/build/${presetName}");
}

INSTANTIATE_TEST_SUITE_P(Pages, Guide,
                         testing::Values("1-first-site.md", "2-reading-the-report.md", "3-when-it-says-no.md",
                                         "5-radio-and-underwater.md", "6-worked-example.md",
                                         "7-your-own-recording.md"),
                         [](const auto& info) { return "Page" + info.param.substr(0, 1); });

TEST(GuidePages, WordsAreThoseOfExplain) {
  EXPECT_EQ(slurp((guide() / "4-words.md").string()), octant({"explain", "--page"}).out);
}

TEST(GuidePages, LinksLeadSomewhere) {
  const std::regex link(R"(\]\(([^)#:]+)\))");
  for (const auto& entry : fs::directory_iterator(guide())) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = slurp(entry.path().string());
    for (auto at = std::sregex_iterator(text.begin(), text.end(), link); at != std::sregex_iterator(); ++at)
      EXPECT_TRUE(fs::exists(guide() / (*at)[1].str())) << entry.path() << ": " << (*at)[1];
  }
}

}  // namespace guide_test
}  // namespace octant::test
