// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The guide as somebody reads it who types what it says: every command, and what it prints.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace {

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

/// Words alike; numbers within the last digits that another processor may print otherwise, and times of no
/// matter.
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

/// Whether a text prints as another says, in which a line of "..." stands for any lines.
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

class Guide : public testing::TestWithParam<std::string> {};

TEST_P(Guide, EachCommandPrintsWhatThePageSays) {
  const auto blocks = blocks_of(slurp((guide() / GetParam()).string()));
  ASSERT_GE(blocks.size(), 2U);
  TemporaryFolder box;
  fs::create_directory_symlink(fs::path(OCTANT_SOURCE_DIR) / "datasets", box / "datasets");
  const std::string path = fs::path(OCTANT_BINARY).parent_path().string();
  for (const Block& block : blocks) {
    spit(box / "block.sh", block.commands);
    const std::string line = "cd '" + box.path().string() + "' && PATH='" + path +
                             "':\"$PATH\" NO_COLOR=1 sh block.sh > out.txt 2> err.txt";
    const int status = std::system(line.c_str());
    if (!block.printed) {
      EXPECT_EQ(status, 0) << block.commands << slurp(box / "err.txt");
      continue;
    }
    EXPECT_TRUE(prints(*block.printed, slurp(box / "out.txt"))) << block.commands << slurp(box / "err.txt");
  }
}

INSTANTIATE_TEST_SUITE_P(Pages, Guide,
                         testing::Values("1-first-site.md", "2-reading-the-report.md", "3-when-it-says-no.md",
                                         "5-radio-and-underwater.md", "6-worked-example.md"),
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

}  // namespace
}  // namespace octant::test
