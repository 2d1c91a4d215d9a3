// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: typed access to a JSON document, in the manner of yaml_reader.h. Include it from .cc files
// only.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "io/text/text.h"
#include "models/support/result.h"

namespace octant::io {

/// Parses JSON. Errors: not UTF-8, not JSON (truncated files among them), with line and column.
[[nodiscard]] Result<nlohmann::json> parse_json(std::string_view text, const std::string& file);

/// Line and column of the value that a JSON pointer ("/beacons/3/position_m") names in a text known to be
/// JSON.
[[nodiscard]] std::optional<TextPosition> locate(std::string_view text, std::string_view pointer);

/// Objects with one key a line, arrays of plain values on one line.
[[nodiscard]] std::string pretty(const nlohmann::ordered_json& json);

/// State of reading one document; the first error is kept.
struct JsonLog {
  std::string file;
  std::string_view text;
  std::optional<Error> error;
  /// @param pointer  of the value that is wrong; of the parent where one is missing
  void fail(const std::string& pointer, std::string found, std::string expected, std::string advice = "");
};

/// A value and where it stands. On failure getters log and return a fallback.
class JsonValue {
 public:
  JsonValue(const nlohmann::json* json, std::string pointer, JsonLog& log)
      : json_(json), pointer_(std::move(pointer)), log_(&log) {}

  [[nodiscard]] bool present() const { return json_ != nullptr && !json_->is_null(); }
  [[nodiscard]] bool is_array() const { return present() && json_->is_array(); }
  /// Member of an object; its absence is an error.
  [[nodiscard]] JsonValue at(const char* key) const;
  /// Optional member of an object; if it is absent or null, present() returns false.
  [[nodiscard]] JsonValue find(const char* key) const;
  [[nodiscard]] std::vector<JsonValue> items() const;

  [[nodiscard]] double number(NumberRange range = kAnyNumber) const;
  [[nodiscard]] std::size_t count() const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] Eigen::Vector3d vector3() const;
  /// `size` numbers.
  [[nodiscard]] std::vector<double> numbers(std::size_t size) const;
  [[nodiscard]] std::vector<std::string> texts() const;

  template <class Enum>
  [[nodiscard]] Enum choice(const std::vector<std::pair<std::string, Enum>>& choices) const {
    const std::string word = text();
    std::vector<std::string> words;
    for (const auto& [spelling, value] : choices) {
      if (spelling == word) return value;
      words.push_back(spelling);
    }
    fail(in_quotes(word), "one of " + listed(words));
    return choices.front().second;
  }
  void fail(std::string found, std::string expected, std::string advice = "") const {
    log_->fail(pointer_, std::move(found), std::move(expected), std::move(advice));
  }

 private:
  const nlohmann::json* json_;
  std::string pointer_;
  JsonLog* log_;
};

}  // namespace octant::io
