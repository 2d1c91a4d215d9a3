// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The arrows between the rooms: apps -> {calib, survey, io} -> models, and the middle three do not include
// each other.
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/apps/process.h"
#include "tests/apps/source_shape.h"

namespace octant::test {
namespace rooms_test {

const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"models", {"models"}},
    {"io", {"io", "models"}},
    {"calib", {"calib", "models"}},
    {"survey", {"survey", "models"}},
    {"apps", {"apps", "calib", "survey", "io", "models"}}};
/// Third parties that stay in one room, and out of every header but Eigen, tl::expected and what apps need.
const std::map<std::string, std::string> kOnlyIn = {
    {"ceres/", "calib"}, {"nlopt", "survey"}, {"yaml.h", "io"}, {"pugixml", "io"}, {"CLI/", "apps"}};

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
      // Insides of vector kernels are read once for each instruction set.
      const bool is_inside = file.filename().string().find("-inl.h") != std::string::npos;
      if (file.extension() == ".h" && !is_inside) {
        EXPECT_NE(text.find("#pragma once"), std::string::npos) << file;
      }
    });
  }
}

TEST(Rooms, EachTestHasItsOwnNamespace) {
  for_each_source("tests", [](const std::filesystem::path& file) {
    const std::string name = file.stem().string(), text = slurp(file.string());
    if (!name.ends_with("_test")) return;
    EXPECT_NE(text.find("\nnamespace " + name + " {\n"), std::string::npos)
        << file << ": several tests are compiled as one source, so its names are in namespace " << name;
  });
}

/// Like apps/package/install_headers.cmake: headers that it does not install are private.
bool is_private(const std::string& header) {
  return header.find("-inl.h") != std::string::npos ||
         slurp(std::string(OCTANT_SOURCE_DIR) + "/" + header).find("Private to io") != std::string::npos;
}

TEST(Rooms, WhatIsInstalledLeansOnNothingThatIsNot) {
  int arrows = 0;
  for (const char* room : {"models", "calib", "survey", "io"})
    for_each_source(room, [&](const std::filesystem::path& file) {
      const std::string name = std::filesystem::relative(file, OCTANT_SOURCE_DIR).string();
      if (file.extension() != ".h" || is_private(name)) return;
      for (const auto& include : includes_of(file)) {
        if (!include.quoted) continue;
        ++arrows;
        EXPECT_FALSE(is_private(include.what))
            << name << ":" << include.line << ": " << include.what
            << " is not installed: say \"Private to io\" in " << name << " too";
      }
    });
  EXPECT_GT(arrows, 300);
}

TEST(Rooms, NoFolderHoldsMoreThanOneSeesAtAGlance) {
  std::map<std::filesystem::path, int> sources;
  for (const auto& [room, allowed] : kMayInclude)
    for_each_source(room, [&](const std::filesystem::path& file) { ++sources[file.parent_path()]; });
  EXPECT_GT(sources.size(), 30u);
  for (const auto& [folder, count] : sources) EXPECT_LE(count, 25) << folder;
}

constexpr int kMostFileLines = 400, kMostFunctionLines = 60;

/// Files above the limit, with their present length. They may only become shorter, and leave the list when
/// they meet the limit.
const std::map<std::string, int> kLongFiles = {};
/// Functions above the limit: file, first words up to the parentheses (for a test, including these).
const std::map<std::string, int> kLongFunctions = {{"tests/bench/drive_bench.cc: double build", 69}};

std::string from_root(const std::filesystem::path& file) {
  return std::filesystem::relative(file, OCTANT_SOURCE_DIR).string();
}

/// Checks the limit `most`, or the length in the list of exceptions, and that the list has no entry that
/// meets the limit.
void expect_at_most(int most, const std::map<std::string, int>& listed, const std::string& what, int lines) {
  const auto left = listed.find(what);
  EXPECT_LE(lines, left == listed.end() ? most : left->second) << what;
  EXPECT_TRUE(left == listed.end() || lines > most) << what << " keeps the limit: take it off the list";
}

TEST(Rooms, FilesAndFunctionsAreShortEnoughToRead) {
  std::size_t functions = 0;
  for (const char* room : {"models", "calib", "survey", "io", "apps", "tests"})
    for_each_source(room, [&](const std::filesystem::path& file) {
      const std::string text = slurp(file.string()), name = from_root(file);
      expect_at_most(kMostFileLines, kLongFiles, name, lines_of(text));
      for (const FunctionShape& f : functions_of(text)) {
        ++functions;
        const std::string what = f.head.rfind("TEST", 0) == 0 ? f.head : f.head.substr(0, f.head.find('('));
        expect_at_most(kMostFunctionLines, kLongFunctions, name + ": " + what, f.lines());
      }
    });
  EXPECT_GT(functions, 3000U);
}

/// Include graph: other nodes that each node includes. Nodes are folders, or units (a header and its source).
using Arrows = std::map<std::string, std::set<std::string>>;

template <class Node>
Arrows arrows_between(Node node_of) {
  Arrows arrows;
  for (const auto& [room, allowed] : kMayInclude)
    for_each_source(room, [&](const std::filesystem::path& file) {
      const std::string from = node_of(std::filesystem::path(from_root(file)));
      for (const auto& include : includes_of(file))
        if (const std::string to = node_of(std::filesystem::path(include.what));
            include.quoted && to != from &&
            std::filesystem::exists(std::filesystem::path(OCTANT_SOURCE_DIR) / include.what))
          arrows[from].insert(to);
    });
  return arrows;
}

/// Nodes that can be reached from one by its arrows.
std::set<std::string> reachable(const Arrows& arrows, const std::string& from) {
  std::set<std::string> met;
  std::vector<std::string> open = {from};
  while (!open.empty()) {
    const auto at = arrows.find(open.back());
    open.pop_back();
    if (at == arrows.end()) continue;
    for (const std::string& to : at->second)
      if (met.insert(to).second) open.push_back(to);
  }
  return met;
}

/// Nodes that reach themselves.
std::set<std::string> in_cycles(const Arrows& arrows) {
  std::set<std::string> found;
  for (const auto& [node, unused] : arrows)
    if (reachable(arrows, node).count(node) == 1) found.insert(node);
  return found;
}

void expect_no_cycles(const Arrows& arrows) {
  EXPECT_GT(arrows.size(), 30u);
  for (const std::string& node : in_cycles(arrows))
    ADD_FAILURE() << node << " includes itself through others";
}

TEST(Rooms, FoldersHaveNoCycles) {
  expect_no_cycles(
      arrows_between([](const std::filesystem::path& file) { return file.parent_path().string(); }));
}

TEST(Rooms, UnitsHaveNoCycles) {
  expect_no_cycles(
      arrows_between([](std::filesystem::path file) { return file.replace_extension().string(); }));
}

TEST(Rooms, CyclesAreFound) {
  EXPECT_EQ(in_cycles({{"a", {"b"}}, {"b", {"c"}}, {"c", {"b", "d"}}, {"d", {}}}),
            (std::set<std::string>{"b", "c"}));
}

TEST(Rooms, LengthsAreCountedAsPeopleCountThem) {
  const std::string text = R"source(namespace a {
struct alignas(64) Lanes {
  double of[8] = {};
  int twice() const {
    return 2;
  }
};
const std::vector<int> table = {1, 2};
// a { in a comment
template <class T>
void visit(T&& f, int many = 3) {
  if (many > 0) {
    f('{');
  }
}
const char* script() {
  return R"js(
    {
  )js";
}
bool operator<(Lanes a, Lanes b) { return a.of[0] < b.of[0]; }
}  // namespace a
)source";
  std::vector<std::pair<int, int>> found;  // first line, length
  for (const FunctionShape& f : functions_of(text)) found.emplace_back(f.first_line, f.lines());
  EXPECT_EQ(found, (std::vector<std::pair<int, int>>{{4, 3}, {10, 6}, {16, 3}, {21, 1}}));
}

TEST(Rooms, EachHasAShortReadme) {
  for (const char* room : {"models", "io", "calib", "survey", "apps", "tests", "datasets"}) {
    const std::string path = std::string(OCTANT_SOURCE_DIR) + "/" + room + "/README.md";
    ASSERT_TRUE(std::filesystem::exists(path)) << path;
    const std::string text = slurp(path);
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 40) << path;
  }
}

}  // namespace rooms_test
}  // namespace octant::test
