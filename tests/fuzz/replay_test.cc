// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Initial inputs of the fuzzing and its findings, as tests for any compiler, and some mutations.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <random>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/fuzz/targets.h"

namespace octant::fuzz {

/// As ctest names it.
void PrintTo(const Target& target, std::ostream* out) { *out << target.name; }

namespace replay_test {

namespace fs = std::filesystem;

std::vector<std::string> corpus_of(const std::string& target) {
  const fs::path folder = fs::path(OCTANT_SOURCE_DIR) / "tests/fuzz/corpus" / target;
  std::vector<fs::path> files;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> inputs;
  for (const fs::path& file : files) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    inputs.push_back(text.str());
  }
  return inputs;
}

class Fuzzed : public ::testing::TestWithParam<Target> {};

TEST_P(Fuzzed, TheCorpusIsTaken) {
  const auto inputs = corpus_of(GetParam().name);
  ASSERT_GE(inputs.size(), 2U) << "tests/fuzz/corpus/" << GetParam().name
                               << " has hardly anything to begin with";
  for (const std::string& input : inputs) GetParam().take(input);
}

/// One of the strokes that mutation consists of.
std::string stroke(std::string text, std::mt19937& random) {
  const auto below = [&random](std::size_t n) { return n == 0 ? 0 : random() % n; };
  static const std::vector<std::string> kWords = {"\n",
                                                  ",",
                                                  "\"",
                                                  "nan",
                                                  "-",
                                                  "1e999",
                                                  "[",
                                                  "{",
                                                  "&a ",
                                                  "*a",
                                                  ": ",
                                                  "%",
                                                  std::string(1, '\0'),
                                                  "\xFF",
                                                  "99999999999999999999",
                                                  "\t"};
  switch (below(5)) {
    case 0: text.insert(below(text.size() + 1), kWords[below(kWords.size())]); break;
    case 1: text.erase(below(text.size()), 1 + below(8)); break;
    case 2:
      if (!text.empty()) text[below(text.size())] = static_cast<char>(random());
      break;
    case 3: text.insert(below(text.size() + 1), text.substr(below(text.size()), below(40))); break;
    default: text.resize(below(text.size() + 1));
  }
  return text;
}

TEST_P(Fuzzed, SoAreStrokesAtIt) {
  // OCTANT_FUZZ_STROKES=1000000 tries this number of other mutations, where libFuzzer is not available.
  const char* many = std::getenv("OCTANT_FUZZ_STROKES");
  const long strokes = many != nullptr ? std::atol(many) : GetParam().strokes;
  std::mt19937 random(many != nullptr ? std::random_device{}() : 20261122);
  const auto inputs = corpus_of(GetParam().name);
  ASSERT_FALSE(inputs.empty());
  for (long i = 0; i < strokes; ++i) {
    std::string text = inputs[random() % inputs.size()];
    for (std::size_t k = 1 + random() % 4; k > 0; --k) text = stroke(text, random);
    if (many != nullptr)
      std::ofstream(testing::TempDir() + "octant_fuzz.last", std::ios::binary) << text;  // if it crashes
    GetParam().take(text);
  }
}

INSTANTIATE_TEST_SUITE_P(Readers, Fuzzed, ::testing::ValuesIn(targets()),
                         [](const auto& info) { return info.param.name; });

}  // namespace replay_test
}  // namespace octant::fuzz
