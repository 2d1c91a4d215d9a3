// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/yaml/yaml_reader.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace octant::io {
namespace {

constexpr std::size_t kMostKeys = 1000;  // no format of ours has as many

std::string yaml_kind_of(const YamlNode& node) {
  switch (node.kind()) {
    case YamlNode::Kind::kMap: return "a mapping";
    case YamlNode::Kind::kSequence: return "a list";
    case YamlNode::Kind::kScalar: return in_quotes(node.scalar());
    default: return "nothing";
  }
}

bool is_number(const YamlNode& node, double& value) {
  if (!node.is_scalar() || node.is_quoted()) return false;
  std::string_view text = node.scalar();
  double sign = 1.0;
  if (text == ".nan" || text == ".NaN" || text == ".NAN") {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  std::string_view bare = text;
  if (!bare.empty() && (bare[0] == '-' || bare[0] == '+')) {
    sign = bare[0] == '-' ? -1.0 : 1.0;
    bare.remove_prefix(1);
  }
  if (bare == ".inf" || bare == ".Inf" || bare == ".INF") {
    value = sign * std::numeric_limits<double>::infinity();
    return true;
  }
  return parse_number(text, value) == NumberText::kNumber;
}

}  // namespace

void YamlLog::fail(const YamlNode& where, std::string found, std::string expected, std::string advice) {
  if (error) return;
  error = Error{.file = file,
                .line = where.line(),
                .column = where.column(),
                .found = std::move(found),
                .expected = std::move(expected),
                .advice = std::move(advice)};
}

void YamlLog::warn(const YamlNode& where, const std::string& text) {
  const int line = where.line();
  warnings.push_back(line > 0 ? fmt::format("{}:{}: {}", file, line, text)
                              : fmt::format("{}: {}", file, text));
}

double number_of(const YamlNode& node, const std::string& name, YamlLog& log, NumberRange range,
                 double fallback) {
  double value = 0.0;
  if (!is_number(node, value)) {
    const bool is_text = node.is_scalar() && node.is_quoted();
    log.fail(node, fmt::format("{} is {}{}", name, yaml_kind_of(node), is_text ? " in quotes" : ""),
             range.words, is_text ? "leave the quotes out" : "");
    return fallback;
  }
  if (!std::isfinite(value)) {
    log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)),
             std::string(range.words) + ", and a finite one");
    return fallback;
  }
  if (!range.contains(value)) {
    log.fail(node, fmt::format("{} is {}", name, in_quotes(node.scalar())), range.words);
    return fallback;
  }
  return value;
}

int integer_of(const YamlNode& node, const std::string& name, YamlLog& log, int low, int high, int fallback) {
  double value = 0.0;
  if (!is_number(node, value) || value != std::floor(value) || value < low || value > high) {
    log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)),
             fmt::format("a whole number from {} to {}", low, high));
    return fallback;
  }
  return static_cast<int>(value);
}

bool boolean_of(const YamlNode& node, const std::string& name, YamlLog& log, bool fallback) {
  const std::string_view word = node.is_scalar() && !node.is_quoted() ? node.scalar() : "";
  if (word == "true" || word == "True" || word == "TRUE") return true;
  if (word == "false" || word == "False" || word == "FALSE") return false;
  log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)), "true or false");
  return fallback;
}

std::string text_of(const YamlNode& node, const std::string& name, YamlLog& log) {
  if (node.is_scalar()) return std::string(node.scalar());
  log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)), "text");
  return "";
}

std::vector<YamlNode> list_of(const YamlNode& node, const std::string& name, YamlLog& log, std::size_t size) {
  const std::string expected = size > 0 ? fmt::format("a list of {}", size) : "a list";
  if (!node.is_sequence()) {
    log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)), expected);
    return {};
  }
  if (size > 0 && node.size() != size) {
    log.fail(node, fmt::format("{} has {} items", name, node.size()), expected);
    return {};
  }
  std::vector<YamlNode> items;
  for (std::size_t i = 0; i < node.size(); ++i) items.push_back(node.item(i));
  return items;
}

std::vector<double> numbers_of(const YamlNode& node, const std::string& name, YamlLog& log, std::size_t size,
                               NumberRange range) {
  std::vector<double> values;
  for (const YamlNode& item : list_of(node, name, log, size)) {
    values.push_back(number_of(item, fmt::format("{}[{}]", name, values.size()), log, range));
  }
  if (values.size() < size) values.resize(size, 0.0);  // after an error: callers may still index
  return values;
}

YamlMap::YamlMap(const YamlNode& node, std::string name, YamlLog& log)
    : node_(node), name_(std::move(name)), log_(log) {
  if (!node_.is_defined()) return;
  if (!node_.is_map()) {
    log_.fail(node_,
              fmt::format("{} is {}", name_.empty() ? "the file's content" : name_, yaml_kind_of(node_)),
              "a mapping (key: value)");
    return;
  }
  if (node_.size() > kMostKeys) {
    log_.fail(node_, fmt::format("a mapping of {} keys", node_.size()), fmt::format("at most {}", kMostKeys));
    return;
  }
  present_ = true;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    const YamlNode key = node_.key(i);
    if (!key.is_scalar()) {
      log_.fail(key, "a key that is " + yaml_kind_of(key), "a word");
      return;
    }
    if (find(key.scalar()) != nullptr) {
      log_.fail(key, fmt::format("{} is given twice", in_quotes(path(key.scalar()))), "each key once");
      return;
    }
    entries_.push_back({std::string(key.scalar()), key, node_.value(i)});
  }
}

YamlMap::KeyValue* YamlMap::find(std::string_view key) {
  for (KeyValue& entry : entries_) {
    if (entry.key == key) return &entry;
  }
  return nullptr;
}

bool YamlMap::has(std::string_view key) const {
  const KeyValue* entry = const_cast<YamlMap*>(this)->find(key);
  return entry != nullptr && !entry->value.is_null();
}

std::string YamlMap::path(std::string_view key) const {
  return name_.empty() ? std::string(key) : name_ + "." + std::string(key);
}

YamlNode YamlMap::get(std::string_view key) {
  asked_.emplace_back(key);
  KeyValue* entry = find(key);
  if (entry == nullptr) return YamlNode();
  entry->known = true;
  return entry->value;
}

YamlNode YamlMap::block(std::string_view key) {
  const YamlNode node = get(key);
  return node.is_defined() && node.is_null() ? YamlNode() : node;
}

YamlNode YamlMap::scalar(std::string_view key, const std::string& expected) {
  const YamlNode node = get(key);
  if (!node.is_defined() || !node.is_null()) return node;
  fail_missing(key, expected);
  return YamlNode();
}

double YamlMap::number(std::string_view key, double fallback, NumberRange range) {
  const YamlNode node = scalar(key, range.words);
  return node.is_defined() ? number_of(node, path(key), log_, range, fallback) : fallback;
}

double YamlMap::required_number(std::string_view key, NumberRange range) {
  const std::optional<double> value = optional_number(key, range);
  if (!value) fail_missing(key, range.words);
  return value.value_or(0.0);
}

std::optional<double> YamlMap::optional_number(std::string_view key, NumberRange range) {
  const YamlNode node = scalar(key, range.words);
  if (!node.is_defined()) return std::nullopt;
  return number_of(node, path(key), log_, range);
}

int YamlMap::integer(std::string_view key, int fallback, int low, int high) {
  const YamlNode node = scalar(key, "a whole number");
  return node.is_defined() ? integer_of(node, path(key), log_, low, high, fallback) : fallback;
}

bool YamlMap::boolean(std::string_view key, bool fallback) {
  const YamlNode node = scalar(key, "true or false");
  return node.is_defined() ? boolean_of(node, path(key), log_, fallback) : fallback;
}

std::string YamlMap::text(std::string_view key, const std::string& fallback) {
  const YamlNode node = scalar(key, "text");
  return node.is_defined() ? text_of(node, path(key), log_) : fallback;
}

std::string YamlMap::required_text(std::string_view key) {
  const YamlNode node = scalar(key, "text");
  if (node.is_defined()) return text_of(node, path(key), log_);
  fail_missing(key, "text");
  return "";
}

std::vector<YamlNode> YamlMap::list(std::string_view key) {
  const YamlNode node = block(key);
  return node.is_defined() ? list_of(node, path(key), log_) : std::vector<YamlNode>{};
}

std::vector<double> YamlMap::numbers(std::string_view key, std::size_t size, NumberRange range) {
  const YamlNode node = block(key);
  return node.is_defined() ? numbers_of(node, path(key), log_, size, range) : std::vector<double>{};
}

void YamlMap::fail(std::string_view key, std::string found, std::string expected, std::string advice) {
  const KeyValue* entry = find(key);
  log_.fail(entry != nullptr ? entry->value : node_, std::move(found), std::move(expected),
            std::move(advice));
}

void YamlMap::fail_missing(std::string_view key, const std::string& expected) {
  if (const KeyValue* entry = find(key); entry != nullptr) {
    // A null value has no position of its own.
    return log_.fail(entry->key_node, fmt::format("{} has no value", in_quotes(path(key))), expected);
  }
  std::vector<std::string> unknown;
  for (const KeyValue& entry : entries_) {
    if (!entry.known) unknown.push_back(entry.key);
  }
  // An existing key in another spelling is the most likely mistake.
  const std::string hint = suggestion(key, unknown);
  const std::string advice = hint.starts_with("did") ? "misspelt? the file says" + hint.substr(12) : "";
  log_.fail(node_, fmt::format("{} is missing", in_quotes(path(key))), expected, advice);
}

void YamlMap::finish() {
  for (const KeyValue& entry : entries_) {
    if (entry.known) continue;
    const std::string hint = suggestion(entry.key, asked_);
    // Unknown keys that resemble a position would be lost, and the file would have another meaning.
    if (hint == "did you mean 'position_m'?" && !has("position_m")) {
      log_.fail(entry.key_node, fmt::format("unknown key {}", in_quotes(path(entry.key))),
                "position_m for a place", hint);
      continue;
    }
    log_.warn(entry.key_node, fmt::format("unknown key {} is ignored; {}", in_quotes(path(entry.key)), hint));
  }
}

void YamlMap::fail_choice(const YamlNode& node, const std::string& name, const std::string& word,
                          const std::vector<std::string>& words, YamlLog& log) {
  const std::string hint = suggestion(word, words);
  log.fail(node, fmt::format("{} is {}", name, in_quotes(word)), "one of " + listed(words),
           hint.starts_with("did") ? hint : "");
}

void check_version(YamlMap& root, std::string_view version_key, YamlLog& log) {
  const YamlNode node = root.get(version_key);
  const std::string expected = fmt::format("{}: 1", version_key);
  if (!node.is_defined()) {
    const bool site = version_key != "octant_site" && root.get("octant_site").is_defined();
    log.fail(root.node(), site ? "a site file" : fmt::format("{} is missing", in_quotes(version_key)),
             expected,
             site ? fmt::format("octant schema {} says what belongs in it", version_key.substr(7))
                  : "write it in the first line");
  } else if (!node.is_scalar() || node.scalar() != "1") {
    log.fail(node, fmt::format("version {} of the format", yaml_kind_of(node)), expected,
             "a newer version needs a newer octant; see octant schema");
  }
}

}  // namespace octant::io
