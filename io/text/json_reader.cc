// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/json_reader.h"

#include <cmath>

#include <fmt/format.h>

#include "io/text/bounds.h"

namespace octant::io {
namespace {

/// Walks over a JSON text along a pointer. The text is known to be valid, so only structure matters.
class Locator {
 public:
  explicit Locator(std::string_view text) : text_(text) {}

  std::optional<std::size_t> find(std::string_view pointer) {
    blanks();
    while (!pointer.empty()) {
      const std::size_t stop = std::min(pointer.find('/', 1), pointer.size());
      if (!enter(pointer.substr(1, stop - 1))) return std::nullopt;
      pointer.remove_prefix(stop);
    }
    return at_;
  }

 private:
  [[nodiscard]] char now() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void blanks() { at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size()); }

  void skip_string() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\\') ++at_;
    }
    ++at_;
  }

  void skip_value() {
    int depth = 0;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '"') {
        skip_string();
        --at_;
      } else if (c == '{' || c == '[') {
        ++depth;
      } else if (c == '}' || c == ']' || c == ',') {
        if (depth == 0) return;
        if (c != ',') --depth;
      }
    }
  }

  /// Moves to the value of a key or an index of the value here.
  bool enter(std::string_view step) {
    const bool object = now() == '{';
    if (!object && now() != '[') return false;
    ++at_;
    for (std::size_t index = 0;; ++index) {
      blanks();
      if (now() == '}' || now() == ']' || now() == '\0') return false;
      std::string key = std::to_string(index);
      if (object) {
        const std::size_t begin = at_;
        skip_string();
        key = text_.substr(begin + 1, at_ - begin - 2);
        at_ = std::min(text_.find(':', at_), text_.size() - 1) + 1;
        blanks();
      }
      if (key == step) return true;
      skip_value();
      if (now() == ',') ++at_;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

std::string kind_of(const nlohmann::json& json) {
  if (json.is_string()) return in_quotes(json.get_ref<const std::string&>());
  if (json.is_object()) return "an object";
  if (json.is_array()) return fmt::format("an array of {}", json.size());
  return json.dump();
}

bool is_plain(const nlohmann::ordered_json& array) {
  for (const auto& item : array) {
    if (item.is_object()) return false;
    if (item.is_array() && !(item.size() <= 3 && is_plain(item))) return false;
  }
  return true;
}

void append_pretty(std::string& out, const nlohmann::ordered_json& json, int indent) {
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
  if (json.is_object() && !json.empty()) {
    const char* separator = "{\n";
    for (const auto& [key, value] : json.items()) {
      out += separator + std::string(static_cast<std::size_t>(indent) + 1, ' ') +
             nlohmann::ordered_json(key).dump(-1, ' ', false, kReplace) + ": ";
      append_pretty(out, value, indent + 1);
      separator = ",\n";
    }
    out += "\n" + std::string(static_cast<std::size_t>(indent), ' ') + "}";
  } else if (json.is_array() && !is_plain(json)) {
    const char* separator = "[\n";
    for (const auto& value : json) {
      out += separator + std::string(static_cast<std::size_t>(indent) + 1, ' ');
      append_pretty(out, value, indent + 1);
      separator = ",\n";
    }
    out += "\n" + std::string(static_cast<std::size_t>(indent), ' ') + "]";
  } else {
    out += json.dump(-1, ' ', false, kReplace);
  }
}

}  // namespace

Result<nlohmann::json> parse_json(std::string_view text, const std::string& file) {
  if (auto ok = check_utf8(text, file); !ok) return fail(ok.error());
  if (auto ok = check_json(text, file); !ok) return fail(ok.error());
  text = without_bom(text);
  try {
    return nlohmann::json::parse(text.begin(), text.end());
  } catch (const nlohmann::json::parse_error& e) {
    const TextPosition at = position_of(text, e.byte > 0 ? e.byte - 1 : 0);
    const bool cut = e.byte >= text.size();
    return fail({.file = file,
                 .line = at.line,
                 .column = at.column,
                 .found = text.empty() ? "the file is empty"
                          : cut        ? "the JSON ends too early"
                                       : "not JSON",
                 .expected = "a whole JSON document",
                 .advice = "the file is truncated or altered: write it again, or take a copy"});
  } catch (const std::exception& e) {  // a number beyond the range of a double, no memory
    return fail({.file = file, .found = std::string("the JSON cannot be read: ") + e.what()});
  }
}

std::optional<TextPosition> locate(std::string_view text, std::string_view pointer) {
  const std::optional<std::size_t> at = Locator(text).find(pointer);
  if (!at) return std::nullopt;
  return position_of(text, *at);
}

std::string pretty(const nlohmann::ordered_json& json) {
  std::string out;
  append_pretty(out, json, 0);
  return out + "\n";
}

void JsonLog::fail(const std::string& pointer, std::string found, std::string expected, std::string advice) {
  if (error) return;
  const TextPosition at = locate(without_bom(text), pointer).value_or(TextPosition{0, 0});
  error = Error{.file = file,
                .line = at.line,
                .column = at.column,
                .found = fmt::format("{} is {}", pointer.empty() ? "the document" : pointer, found),
                .expected = std::move(expected),
                .advice = std::move(advice)};
}

JsonValue JsonValue::find(const char* key) const {
  const std::string pointer = pointer_ + "/" + key;
  if (!present()) return {nullptr, pointer, *log_};
  if (!json_->is_object()) {
    fail(kind_of(*json_), "an object");
    return {nullptr, pointer, *log_};
  }
  const auto found = json_->find(key);
  return {found == json_->end() || found->is_null() ? nullptr : &*found, pointer, *log_};
}

JsonValue JsonValue::at(const char* key) const {
  JsonValue value = find(key);
  if (!value.present() && !log_->error) {
    fail(fmt::format("without {}", in_quotes(key)), "this key, with a value",
         "the file may be truncated or altered");
  }
  return value;
}

std::vector<JsonValue> JsonValue::items() const {
  std::vector<JsonValue> values;
  if (!present()) return values;
  if (!json_->is_array()) {
    fail(kind_of(*json_), "an array");
    return values;
  }
  for (const auto& item : *json_)
    values.emplace_back(&item, fmt::format("{}/{}", pointer_, values.size()), *log_);
  return values;
}

double JsonValue::number(NumberRange range) const {
  if (json_ == nullptr) return 0.0;
  const double value = json_->is_number() ? json_->get<double>() : NAN;
  if (!std::isfinite(value))
    fail(kind_of(*json_), "a finite number");
  else if (!range.contains(value))
    fail(kind_of(*json_), range.words);
  return std::isfinite(value) ? value : 0.0;
}

std::size_t JsonValue::count() const {
  if (json_ == nullptr) return 0;
  if (json_->is_number_unsigned()) return json_->get<std::size_t>();
  fail(kind_of(*json_), "a whole number");
  return 0;
}

bool JsonValue::boolean() const {
  if (json_ == nullptr) return false;
  if (json_->is_boolean()) return json_->get<bool>();
  fail(kind_of(*json_), "true or false");
  return false;
}

std::string JsonValue::text() const {
  if (json_ == nullptr) return "";
  if (json_->is_string()) return json_->get<std::string>();
  fail(kind_of(*json_), "text");
  return "";
}

std::vector<double> JsonValue::numbers(std::size_t size) const {
  std::vector<double> values(size, 0.0);
  if (json_ == nullptr) return values;
  if (!json_->is_array() || json_->size() != size) {
    fail(kind_of(*json_), fmt::format("an array of {} numbers", size));
    return values;
  }
  for (std::size_t i = 0; i < size; ++i) {
    const nlohmann::json& item = (*json_)[i];
    // Pointers are made only for what is wrong: the covariance of a large site has millions of numbers.
    values[i] = item.is_number() ? item.get<double>()
                                 : JsonValue(&item, fmt::format("{}/{}", pointer_, i), *log_).number();
    if (item.is_null())
      JsonValue(&item, fmt::format("{}/{}", pointer_, i), *log_).fail("null", "a finite number");
  }
  return values;
}

Eigen::Vector3d JsonValue::vector3() const {
  const std::vector<double> v = numbers(3);
  return {v[0], v[1], v[2]};
}

std::vector<std::string> JsonValue::texts() const {
  std::vector<std::string> values;
  for (const JsonValue& item : items()) values.push_back(item.text());
  return values;
}

}  // namespace octant::io
