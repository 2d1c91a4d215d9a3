// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The arrows between the rooms: apps -> {calib, survey, io} -> models, and the middle three do not include
// each other.
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace {

const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"models", {"models"}},
    {"io", {"io", "models"}},
    {"calib", {"calib", "models"}},
    {"survey", {"survey", "models"}},
    {"apps", {"apps", "calib", "survey", "io", "models"}}};
/// Third parties that stay in one room, and out of every header but Eigen, tl::expected and what apps need.
const std::map<std::string, std::string> kOnlyIn = {
    {"ceres/", "calib"}, {"nlopt", "survey"}, {"yaml.h", "io"}, {"CLI/", "apps"}};

struct Include {
  int line = 0;
  bool quoted = false;
  std::string what;
};

std::vector<Include> includes_of(const std::filesystem::path& file) {
  std::vector<Include> found;
  std::istringstream text(slurp(file.string()));
  const std::regex pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::smatch match;
    if (std::regex_search(line, match, pattern)) found.push_back({number, match[1] == "\"", match[2]});
  }
  return found;
}

template <class Visit>
void for_each_source(const std::string& room, Visit visit) {
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::filesystem::path(OCTANT_SOURCE_DIR) / room)) {
    const auto extension = entry.path().extension();
    if (extension == ".h" || extension == ".cc") visit(entry.path());
  }
}

TEST(Rooms, ArrowsGoDownOnly) {
  for (const auto& [room, allowed] : kMayInclude) {
    for_each_source(room, [&, &where = room, &may = allowed](const std::filesystem::path& file) {
      for (const auto& include : includes_of(file)) {
        if (!include.quoted) continue;
        const std::string to = include.what.substr(0, include.what.find('/'));
        EXPECT_TRUE(may.count(to) == 1)
            << file.string() << ":" << include.line << ": " << where << " may not include \"" << include.what
            << "\" (and includes are spelled from the root)";
      }
    });
  }
}

TEST(Rooms, ThirdPartiesStayWhereTheyBelong) {
  for (const auto& [room, allowed] : kMayInclude) {
    for_each_source(room, [&, &where = room](const std::filesystem::path& file) {
      for (const auto& include : includes_of(file)) {
        for (const auto& [prefix, only] : kOnlyIn) {
          EXPECT_TRUE(include.what.rfind(prefix, 0) != 0 || where == only)
              << file.string() << ":" << include.line << ": " << include.what << " belongs in " << only;
        }
      }
    });
  }
}

TEST(Rooms, EverySourceNamesItsLicence) {
  for (const auto& [room, allowed] : kMayInclude) {
    for_each_source(room, [](const std::filesystem::path& file) {
      const std::string text = slurp(file.string());
      EXPECT_NE(text.substr(0, 300).find("SPDX-License-Identifier: Apache-2.0"), std::string::npos) << file;
      if (file.extension() == ".h") EXPECT_NE(text.find("#pragma once"), std::string::npos) << file;
    });
  }
}

TEST(Rooms, NoFolderHoldsMoreThanOneSeesAtAGlance) {
  std::map<std::filesystem::path, int> sources;
  for (const auto& [room, allowed] : kMayInclude)
    for_each_source(room, [&](const std::filesystem::path& file) { ++sources[file.parent_path()]; });
  EXPECT_GT(sources.size(), 30u);
  for (const auto& [folder, count] : sources) EXPECT_LE(count, 25) << folder;
}

TEST(Rooms, EachHasAShortReadme) {
  for (const char* room : {"models", "io", "calib", "survey", "apps", "tests", "datasets"}) {
    const std::string path = std::string(OCTANT_SOURCE_DIR) + "/" + room + "/README.md";
    ASSERT_TRUE(std::filesystem::exists(path)) << path;
    const std::string text = slurp(path);
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 40) << path;
  }
}

}  // namespace
}  // namespace octant::test
