// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Every word that terminal, report and guide set in front of a reader is explained: octant explain WORD.
#include <cctype>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace words_test {

/// Terms that need no explanation, and names of axes.
const std::set<std::string> kPlain = {"",
                                      "x",
                                      "y",
                                      "z",
                                      "what",
                                      "value",
                                      "found",
                                      "stated",
                                      "next",
                                      "file",
                                      "sha256",
                                      "program",
                                      "command",
                                      "option",
                                      "report by",
                                      "report",
                                      "written",
                                      "name",
                                      "least",
                                      "median",
                                      "median range",
                                      "word",
                                      "other",
                                      "what to do",
                                      "what it means",
                                      "distance",
                                      "time",
                                      "temperature",
                                      "pauses",
                                      "rejected rows",
                                      "duplicate rows",
                                      "measured poses"};

/// "U x [mm]" and "left out: late (echo)" as explain takes them.
std::string bare(std::string text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  text = text.substr(first, text.find_last_not_of(' ') - first + 1);
  text = std::regex_replace(text, std::regex(R"(\\)"), "");
  text = std::regex_replace(text, std::regex(R"(\s*\[[^\]]*\])"), "");
  text = std::regex_replace(text, std::regex("^left out: "), "");
  text =
      std::regex_replace(text, std::regex(", (RMSE|RMS|95 %|largest|median|mean|CE50|CE95|VE95|SE95)$"), "");
  text = std::regex_replace(text, std::regex(" (by the arrivals' noise|over its degrees of freedom)$"), "");
  return text;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

class ExplainedWords : public HallFolder {
 protected:
  /// @param where  for the message
  void expect_explained(const std::string& word, const std::string& where) {
    const std::string wanted = lower(bare(word));
    if (kPlain.contains(wanted) || !known_.insert(wanted).second) return;
    EXPECT_EQ(octant({"explain", "--", wanted}).exit, 0)
        << "'" << word << "' of " << where << " is explained nowhere";
  }
  std::set<std::string> known_;
};

TEST_F(ExplainedWords, OfTheReportAreExplained) {
  ASSERT_EQ(calibrate({"--report", out("r.json")}).exit, 0);
  ASSERT_EQ(octant({"report", out("r.json"), hall("heldout"), "--since", hall("deployment.true.json"), "-o",
                    out("r.md")})
                .exit,
            0);
  std::istringstream in(slurp(out("r.md")));
  std::string before, table;
  std::size_t headings = 0;
  for (std::string line; std::getline(in, line); before = line) {
    if (line.starts_with("|:--")) {  // the line before is a heading
      std::istringstream cells(before.substr(1));
      for (std::string cell; std::getline(cells, cell, '|'); ++headings) expect_explained(cell, "the report");
      table = before;
    } else if (line.starts_with("| ") && table.starts_with("| what |")) {
      expect_explained(line.substr(2, line.find(" |", 2) - 2), "the report's table");
    }
  }
  EXPECT_GT(headings, 40U);
}

TEST_F(ExplainedWords, OfTheTerminalAreExplained) {
  ASSERT_EQ(calibrate().exit, 0);
  const std::vector<std::vector<std::string>> commands = {
      {"calibrate", hall("site.yaml"), hall("run"), "-o", out("e.json"), "--no-report", "-v"},
      {"check", hall("site.yaml"), hall("run")},
      {"verify", out("d.json"), hall("heldout")},
      {"survey", out("d.json")}};
  // A name in 17 columns, then its value; or the heading of a table, its columns two blanks apart.
  const std::regex named("^([A-Za-z][A-Za-z' _-]{0,15}) {2,}[^ ].*"), blanks(" {2,}");
  for (const auto& words : commands) {
    const Outcome outcome = octant(words);
    ASSERT_EQ(outcome.exit, 0) << outcome.err;
    std::istringstream in(outcome.out);
    std::string before;
    for (std::string line; std::getline(in, line); before = line) {
      EXPECT_LE(line.size(), 80U) << words[0] << ": " << line;
      std::smatch match;
      const bool heading = line.find("  ") != std::string::npos && before.empty() &&
                           (line.find('[') != std::string::npos || line.starts_with("beacon "));
      if (heading)
        for (std::sregex_token_iterator at(line.begin(), line.end(), blanks, -1), end; at != end; ++at)
          expect_explained(*at, words[0] + "'s table");
      else if (std::regex_match(line, match, named) && match[1].str().size() > 2 && line.size() > 17 &&
               line[16] == ' ' && line[17] != ' ' && !line.starts_with("robot"))
        expect_explained(match[1].str(), words[0]);
    }
  }
  EXPECT_GT(known_.size(), 20U);
}

TEST_F(ExplainedWords, OfTheGuideAreExplained) {
  // Bold terms of the page on the report.
  const std::string page =
      slurp((std::filesystem::path(OCTANT_SOURCE_DIR) / "apps/guide/2-reading-the-report.md").string());
  const std::regex bold(R"(\*\*([^*]+)\*\*)");
  std::size_t words = 0;
  for (auto at = std::sregex_iterator(page.begin(), page.end(), bold); at != std::sregex_iterator();
       ++at, ++words) {
    std::string word = (*at)[1];
    while (!word.empty() && word.back() == '.') word.pop_back();
    word = std::regex_replace(word, std::regex("^The |s of the beacons$"), "");
    expect_explained(word, "the guide");
  }
  EXPECT_GT(words, 6U);
}

}  // namespace words_test
}  // namespace octant::test
