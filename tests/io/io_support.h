// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "models/site.h"
#include "models/support/result.h"

namespace octant::io::test {

/// A temporary folder, removed after the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    // In memory where there is such a place: the files are flushed to disk one by one otherwise.
    const bool memory = ::access("/dev/shm", W_OK) == 0;
    std::string pattern =
        ((memory ? std::filesystem::path("/dev/shm") : std::filesystem::temp_directory_path()) /
         "octant_io_test.XXXXXX")
            .string();
    path_ = ::mkdtemp(pattern.data());
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] std::string path(const std::string& name = "") const {
    return name.empty() ? path_ : path_ + "/" + name;
  }
  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
  }
  [[nodiscard]] std::string read(const std::string& name) const {
    std::stringstream text;
    text << std::ifstream(path(name), std::ios::binary).rdbuf();
    return text.str();
  }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::string path_;
};

/// Expects a failure at a line (0: of the file as a whole) whose message holds some words.
template <class T>
void expect_error(const Result<T>& result, int line, const std::string& words, const char* file = "") {
  ASSERT_FALSE(result.has_value()) << "read without complaint; expected: " << words;
  const Error& error = result.error();
  EXPECT_EQ(error.line, line) << error.message();
  EXPECT_THAT(error.message(), testing::HasSubstr(words));
  EXPECT_THAT(error.file, testing::EndsWith(file));
  EXPECT_LT(error.message().size(), 1000u) << "a message is for reading";
}

/// Any finite double of a size that occurs, with all its digits.
inline double some_number() {
  const auto mantissa = *rc::gen::inRange<std::int64_t>(-(1LL << 53), 1LL << 53);
  return std::ldexp(static_cast<double>(mantissa), *rc::gen::inRange(-90, -33));
}
inline double some_positive() { return std::abs(some_number()) + 1e-12; }
inline double some_fraction() {
  return std::ldexp(static_cast<double>(*rc::gen::inRange<std::int64_t>(0, 1LL << 53)), -53);
}
inline std::optional<double> maybe(double value) {
  return *rc::gen::arbitrary<bool>() ? std::optional<double>(value) : std::nullopt;
}

inline std::optional<Rail> some_rail() {
  switch (*rc::gen::inRange(0, 3)) {
    case 0: return Rail{.from_m = {some_number(), some_number()}, .to_m = {some_number(), 1.0}};
    case 1:
      return Rail{.shape = Rail::Shape::kArc,
                  .centre_m = {some_number(), some_number()},
                  .radius_m = some_positive()};
    default: return std::nullopt;
  }
}
inline bool same_rail(const std::optional<Rail>& a, const std::optional<Rail>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->shape == b->shape && a->from_m == b->from_m && a->to_m == b->to_m && a->centre_m == b->centre_m &&
         a->radius_m == b->radius_m;
}

/// Names that are awkward in YAML, CSV or JSON.
inline std::string some_name(std::size_t number) {
  static const std::vector<std::string> kinds = {"B",    "no",  "1e", "a: b", "x,y", "\"q\"", "#", "Süd 北",
                                                 "null", "- a", "{",  "a\\b", "'s'", "true",  "~", "[1]"};
  return *rc::gen::elementOf(kinds) + std::to_string(number);
}

}  // namespace octant::io::test
