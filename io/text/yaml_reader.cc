// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/yaml_reader.h"

#include <cmath>

#include <fmt/format.h>
#include <yaml-cpp/depthguard.h>

namespace octant::io {
namespace {

constexpr std::size_t kLargestYaml = 64u << 20;
constexpr std::size_t kMostKeys = 1000;  // no format of ours has as many

std::string yaml_kind_of(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Map: return "a mapping";
    case YAML::NodeType::Sequence: return "a list";
    case YAML::NodeType::Scalar: return in_quotes(node.Scalar());
    default: return "nothing";
  }
}

/// yaml-cpp gives scalars that were written in quotes the tag "!".
bool is_quoted(const YAML::Node& node) { return node.Tag() == "!"; }

bool is_number(const YAML::Node& node, double& value) {
  if (!node.IsScalar() || is_quoted(node)) return false;
  std::string_view text = node.Scalar();
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

namespace {

/// Line up to the given one, and near to it, that is indented with a tab; 0: none.
int tab_in_indentation(std::string_view text, int wrong_line) {
  constexpr int kNear = 3;
  int line = 1, found = 0;
  for (std::size_t begin = 0; begin < text.size() && line <= wrong_line; ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::size_t first = text.find_first_not_of(' ', begin);
    if (first < end && text[first] == '\t' && line + kNear >= wrong_line) found = line;
    begin = end + 1;
  }
  return found;
}

}  // namespace

void YamlLog::fail(const YAML::Node& where, std::string found, std::string expected, std::string advice) {
  if (error) return;
  const YAML::Mark mark = where.IsDefined() ? where.Mark() : YAML::Mark::null_mark();
  error = Error{.file = file,
                .line = mark.line + 1,
                .column = mark.column + 1,
                .found = std::move(found),
                .expected = std::move(expected),
                .advice = std::move(advice)};
}

void YamlLog::warn(const YAML::Node& where, const std::string& text) {
  const int line = line_of(where);
  warnings.push_back(line > 0 ? fmt::format("{}:{}: {}", file, line, text)
                              : fmt::format("{}: {}", file, text));
}

int line_of(const YAML::Node& node) { return node.IsDefined() ? node.Mark().line + 1 : 0; }

Result<YAML::Node> parse_yaml(std::string_view text, const std::string& file) {
  if (text.size() > kLargestYaml) {
    return fail({.file = file,
                 .found = fmt::format("{} bytes", text.size()),
                 .expected = "a YAML file of less than 64 MB"});
  }
  if (auto ok = check_utf8(text, file); !ok) return fail(ok.error());
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(std::string(without_bom(text)));
    if (documents.empty() || documents.front().IsNull())
      return fail({.file = file, .found = "the file is empty"});
    if (documents.size() > 1) {
      return fail({.file = file,
                   .line = line_of(documents[1]),
                   .found = "a second document",
                   .expected = "one YAML document"});
    }
    return documents.front();
  } catch (const YAML::DeepRecursion& e) {
    return fail({.file = file,
                 .line = e.mark.line + 1,
                 .found = "brackets or indentation hundreds of levels deep",
                 .expected = "a few"});
  } catch (const YAML::Exception& e) {
    if (const int line = tab_in_indentation(text, e.mark.line + 1); line > 0)
      return fail({.file = file,
                   .line = line,
                   .column = 1,
                   .found = "not YAML: a tab in the indentation",
                   .expected = "blanks: YAML is not indented by tabs",
                   .advice = "have the editor replace tabs by blanks"});
    return fail({.file = file,
                 .line = e.mark.line + 1,
                 .column = e.mark.column + 1,
                 .found = "not YAML: " + e.msg,
                 .advice = "check indentation, brackets and quotes here and in the line above"});
  } catch (const std::exception& e) {
    return fail({.file = file, .found = std::string("not YAML: ") + e.what()});
  }
}

double number_of(const YAML::Node& node, const std::string& name, YamlLog& log, NumberRange range,
                 double fallback) {
  double value = 0.0;
  if (!is_number(node, value)) {
    const bool is_text = node.IsScalar() && is_quoted(node);
    log.fail(node, fmt::format("{} is {}{}", name, yaml_kind_of(node), is_text ? " in quotes" : ""),
             range.words, is_text ? "leave the quotes out" : "");
    return fallback;
  }
  if (!std::isfinite(value)) {
    log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)),
             std::string(range.words) + ", and a finite one");
    return fallback;
  }
  if (value < range.low || value > range.high || (range.low_excluded && value == range.low)) {
    log.fail(node, fmt::format("{} is {}", name, in_quotes(node.Scalar())), range.words);
    return fallback;
  }
  return value;
}

int integer_of(const YAML::Node& node, const std::string& name, YamlLog& log, int low, int high,
               int fallback) {
  double value = 0.0;
  if (!is_number(node, value) || value != std::floor(value) || value < low || value > high) {
    log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)),
             fmt::format("a whole number from {} to {}", low, high));
    return fallback;
  }
  return static_cast<int>(value);
}

bool boolean_of(const YAML::Node& node, const std::string& name, YamlLog& log, bool fallback) {
  const std::string word = node.IsScalar() && !is_quoted(node) ? node.Scalar() : "";
  if (word == "true" || word == "True" || word == "TRUE") return true;
  if (word == "false" || word == "False" || word == "FALSE") return false;
  log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)), "true or false");
  return fallback;
}

std::string text_of(const YAML::Node& node, const std::string& name, YamlLog& log) {
  if (node.IsScalar()) return node.Scalar();
  log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)), "text");
  return "";
}

std::vector<YAML::Node> list_of(const YAML::Node& node, const std::string& name, YamlLog& log,
                                std::size_t size) {
  const std::string expected = size > 0 ? fmt::format("a list of {}", size) : "a list";
  if (!node.IsSequence()) {
    log.fail(node, fmt::format("{} is {}", name, yaml_kind_of(node)), expected);
    return {};
  }
  if (size > 0 && node.size() != size) {
    log.fail(node, fmt::format("{} has {} items", name, node.size()), expected);
    return {};
  }
  return {node.begin(), node.end()};
}

std::vector<double> numbers_of(const YAML::Node& node, const std::string& name, YamlLog& log,
                               std::size_t size, NumberRange range) {
  std::vector<double> values;
  for (const YAML::Node& item : list_of(node, name, log, size)) {
    values.push_back(number_of(item, fmt::format("{}[{}]", name, values.size()), log, range));
  }
  if (values.size() < size) values.resize(size, 0.0);  // after an error: callers may still index
  return values;
}

YamlMap::YamlMap(const YAML::Node& node, std::string name, YamlLog& log)
    : node_(node), name_(std::move(name)), log_(log) {
  if (!node_.IsDefined()) return;
  if (!node_.IsMap()) {
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
  for (const auto& item : node_) {
    if (!item.first.IsScalar()) {
      log_.fail(item.first, "a key that is " + yaml_kind_of(item.first), "a word");
      return;
    }
    if (find(item.first.Scalar()) != nullptr) {
      log_.fail(item.first, fmt::format("{} is given twice", in_quotes(path(item.first.Scalar()))),
                "each key once");
      return;
    }
    entries_.push_back({item.first.Scalar(), item.first, item.second});
  }
}

YamlMap::Entry* YamlMap::find(std::string_view key) {
  for (Entry& entry : entries_) {
    if (entry.key == key) return &entry;
  }
  return nullptr;
}

bool YamlMap::has(std::string_view key) const {
  const Entry* entry = const_cast<YamlMap*>(this)->find(key);
  return entry != nullptr && !entry->value.IsNull();
}

std::string YamlMap::path(std::string_view key) const {
  return name_.empty() ? std::string(key) : name_ + "." + std::string(key);
}

YAML::Node YamlMap::get(std::string_view key) {
  asked_.emplace_back(key);
  Entry* entry = find(key);
  if (entry == nullptr) return YAML::Node(YAML::NodeType::Undefined);
  entry->known = true;
  return entry->value;
}

YAML::Node YamlMap::block(std::string_view key) {
  const YAML::Node node = get(key);
  return node.IsDefined() && node.IsNull() ? YAML::Node(YAML::NodeType::Undefined) : node;
}

YAML::Node YamlMap::scalar(std::string_view key, const std::string& expected) {
  const YAML::Node node = get(key);
  if (!node.IsDefined() || !node.IsNull()) return node;
  fail_missing(key, expected);
  return YAML::Node(YAML::NodeType::Undefined);
}

double YamlMap::number(std::string_view key, double fallback, NumberRange range) {
  const YAML::Node node = scalar(key, range.words);
  return node.IsDefined() ? number_of(node, path(key), log_, range, fallback) : fallback;
}

double YamlMap::required_number(std::string_view key, NumberRange range) {
  const std::optional<double> value = optional_number(key, range);
  if (!value) fail_missing(key, range.words);
  return value.value_or(0.0);
}

std::optional<double> YamlMap::optional_number(std::string_view key, NumberRange range) {
  const YAML::Node node = scalar(key, range.words);
  if (!node.IsDefined()) return std::nullopt;
  return number_of(node, path(key), log_, range);
}

int YamlMap::integer(std::string_view key, int fallback, int low, int high) {
  const YAML::Node node = scalar(key, "a whole number");
  return node.IsDefined() ? integer_of(node, path(key), log_, low, high, fallback) : fallback;
}

bool YamlMap::boolean(std::string_view key, bool fallback) {
  const YAML::Node node = scalar(key, "true or false");
  return node.IsDefined() ? boolean_of(node, path(key), log_, fallback) : fallback;
}

std::string YamlMap::text(std::string_view key, const std::string& fallback) {
  const YAML::Node node = scalar(key, "text");
  return node.IsDefined() ? text_of(node, path(key), log_) : fallback;
}

std::string YamlMap::required_text(std::string_view key) {
  const YAML::Node node = scalar(key, "text");
  if (node.IsDefined()) return text_of(node, path(key), log_);
  fail_missing(key, "text");
  return "";
}

std::vector<YAML::Node> YamlMap::list(std::string_view key) {
  const YAML::Node node = block(key);
  return node.IsDefined() ? list_of(node, path(key), log_) : std::vector<YAML::Node>{};
}

std::vector<double> YamlMap::numbers(std::string_view key, std::size_t size, NumberRange range) {
  const YAML::Node node = block(key);
  return node.IsDefined() ? numbers_of(node, path(key), log_, size, range) : std::vector<double>{};
}

void YamlMap::fail(std::string_view key, std::string found, std::string expected, std::string advice) {
  const Entry* entry = find(key);
  log_.fail(entry != nullptr ? entry->value : node_, std::move(found), std::move(expected),
            std::move(advice));
}

void YamlMap::fail_missing(std::string_view key, const std::string& expected) {
  if (const Entry* entry = find(key); entry != nullptr) {
    // A null has no place of its own: yaml-cpp gives it that of what comes next.
    return log_.fail(entry->key_node, fmt::format("{} has no value", in_quotes(path(key))), expected);
  }
  std::vector<std::string> unknown;
  for (const Entry& entry : entries_) {
    if (!entry.known) unknown.push_back(entry.key);
  }
  // A key that is there in another spelling is what is most likely wrong.
  const std::string hint = suggestion(key, unknown);
  const std::string advice = hint.starts_with("did") ? "misspelt? the file says" + hint.substr(12) : "";
  log_.fail(node_, fmt::format("{} is missing", in_quotes(path(key))), expected, advice);
}

void YamlMap::finish() {
  for (const Entry& entry : entries_) {
    if (entry.known) continue;
    const std::string hint = suggestion(entry.key, asked_);
    // What looks like a place in another spelling would be lost; without it the file means something else.
    if (hint == "did you mean 'position_m'?" && !has("position_m")) {
      log_.fail(entry.key_node, fmt::format("unknown key {}", in_quotes(path(entry.key))),
                "position_m for a place", hint);
      continue;
    }
    log_.warn(entry.key_node, fmt::format("unknown key {} is ignored; {}", in_quotes(path(entry.key)), hint));
  }
}

void YamlMap::fail_choice(const YAML::Node& node, const std::string& name, const std::string& word,
                          const std::vector<std::string>& words, YamlLog& log) {
  const std::string hint = suggestion(word, words);
  log.fail(node, fmt::format("{} is {}", name, in_quotes(word)), "one of " + listed(words),
           hint.starts_with("did") ? hint : "");
}

void check_version(YamlMap& root, std::string_view version_key, YamlLog& log) {
  const YAML::Node node = root.get(version_key);
  const std::string expected = fmt::format("{}: 1", version_key);
  if (!node.IsDefined()) {
    log.fail(root.node(), fmt::format("{} is missing", in_quotes(version_key)), expected,
             "write it in the first line");
  } else if (!node.IsScalar() || node.Scalar() != "1") {
    log.fail(node, fmt::format("version {} of the format", yaml_kind_of(node)), expected,
             "a newer version needs a newer octant; see octant schema");
  }
}

}  // namespace octant::io
