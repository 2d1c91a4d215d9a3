// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: typed access to a YAML document.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Core>

#include "io/text/text.h"
#include "io/yaml/yaml_node.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

/// State of reading one YAML file. The first error is kept: getters continue with fallback values, and the
/// caller checks `error` once at the end. Readers are therefore lists of keys.
struct YamlLog {
  std::string file;
  std::optional<Error> error;
  std::vector<std::string> warnings;  ///< each "file:line: ..."

  explicit YamlLog(std::string file_name) : file(std::move(file_name)) {}
  void fail(const YamlNode& where, std::string found, std::string expected, std::string advice = "");
  void warn(const YamlNode& where, const std::string& text);
};

// Values of a node. `name` is its path in messages, e.g. "medium.sigma_mps". On failure they log and return
// the fallback.
[[nodiscard]] double number_of(const YamlNode& node, const std::string& name, YamlLog& log,
                               NumberRange range = kAnyNumber, double fallback = 0.0);
[[nodiscard]] int integer_of(const YamlNode& node, const std::string& name, YamlLog& log, int low, int high,
                             int fallback = 0);
[[nodiscard]] bool boolean_of(const YamlNode& node, const std::string& name, YamlLog& log,
                              bool fallback = false);
/// Any scalar but null, as it is written.
[[nodiscard]] std::string text_of(const YamlNode& node, const std::string& name, YamlLog& log);
/// Items of a list; size 0: any number of them.
[[nodiscard]] std::vector<YamlNode> list_of(const YamlNode& node, const std::string& name, YamlLog& log,
                                            std::size_t size = 0);
[[nodiscard]] std::vector<double> numbers_of(const YamlNode& node, const std::string& name, YamlLog& log,
                                             std::size_t size = 0, NumberRange range = kAnyNumber);

/// Points of a list, each of N numbers; after an error those before it.
template <int N>
[[nodiscard]] std::vector<Eigen::Matrix<double, N, 1>> points_of(const YamlNode& node,
                                                                 const std::string& name, YamlLog& log) {
  std::vector<Eigen::Matrix<double, N, 1>> points;
  for (const YamlNode& item : list_of(node, name, log)) {
    const std::vector<double> p = numbers_of(item, fmt::format("{}[{}]", name, points.size()), log, N);
    if (log.error) break;
    points.push_back(Eigen::Map<const Eigen::Matrix<double, N, 1>>(p.data()));
  }
  return points;
}

/// A mapping and its keys. Each getter marks its key as known; finish() warns about the others. A key whose
/// value is null counts as absent for blocks and lists; a scalar with a null value is an error.
///   YamlMap path(root.block("path"), "path", log);  // an absent block is undefined: all getters fall back
///   scenario.path.epochs = path.integer("epochs", 120, 1, 10'000'000);
///   scenario.path.speed_mps = path.number("speed_mps", 0.6, kPositive);
///   path.finish();
///   if (log.error) return fail(*log.error);
class YamlMap {
 public:
  YamlMap(const YamlNode& node, std::string name, YamlLog& log);

  [[nodiscard]] bool present() const { return present_; }  ///< false: there is no such block
  [[nodiscard]] bool has(std::string_view key) const;      ///< key is there, with a value that is not null
  [[nodiscard]] const YamlNode& node() const { return node_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::string path(std::string_view key) const;  ///< "medium.sigma_mps"

  /// Value of a key, undefined node if absent; marks the key as known.
  YamlNode get(std::string_view key);
  /// Block or list of a key; undefined if the key is absent or null.
  YamlNode block(std::string_view key);

  // Values; absent keys give the fallback, a null is an error.
  double number(std::string_view key, double fallback, NumberRange range = kAnyNumber);
  double required_number(std::string_view key, NumberRange range = kAnyNumber);
  std::optional<double> optional_number(std::string_view key, NumberRange range = kAnyNumber);
  int integer(std::string_view key, int fallback, int low, int high);
  bool boolean(std::string_view key, bool fallback);
  std::string text(std::string_view key, const std::string& fallback);
  std::string required_text(std::string_view key);
  /// Items of a list; empty where it is absent.
  std::vector<YamlNode> list(std::string_view key);
  std::vector<double> numbers(std::string_view key, std::size_t size, NumberRange range = kAnyNumber);
  /// Reads the mappings of a list with read(map, item) and appends the items to `items`, until the first
  /// error.
  template <class Item, class Read>
  void each(std::string_view key, std::vector<Item>& items, const Read& read) {
    const std::vector<YamlNode> nodes = list(key);
    for (std::size_t i = 0; i < nodes.size() && !log_.error; ++i) {
      YamlMap map(nodes[i], fmt::format("{}[{}]", path(key), i), log_);
      Item item;
      if constexpr (requires { item.line; }) item.line = nodes[i].line();
      read(map, item);
      map.finish();
      items.push_back(std::move(item));
    }
  }

  template <class Enum>
  Enum choice(std::string_view key, const std::vector<std::pair<std::string, Enum>>& choices, Enum fallback) {
    const YamlNode node = scalar(key, "a word");
    if (!node.is_defined()) return fallback;
    return choice_of(node, path(key), choices, fallback, log_);
  }
  template <class Enum>
  static Enum choice_of(const YamlNode& node, const std::string& name,
                        const std::vector<std::pair<std::string, Enum>>& choices, Enum fallback,
                        YamlLog& log) {
    const std::string word = text_of(node, name, log);
    std::vector<std::string> words;
    for (const auto& [spelling, value] : choices) {
      if (spelling == word) return value;
      words.push_back(spelling);
    }
    fail_choice(node, name, word, words, log);
    return fallback;
  }

  void fail(std::string_view key, std::string found, std::string expected, std::string advice = "");
  void fail_missing(std::string_view key, const std::string& expected);
  /// Warns about unknown keys, with suggestions.
  void finish();

 private:
  struct KeyValue {
    std::string key;
    YamlNode key_node, value;
    bool known = false;
  };
  KeyValue* find(std::string_view key);
  /// Value of a key, undefined node if absent; null is an error.
  YamlNode scalar(std::string_view key, const std::string& expected);
  static void fail_choice(const YamlNode& node, const std::string& name, const std::string& word,
                          const std::vector<std::string>& words, YamlLog& log);

  YamlNode node_;
  std::string name_;
  YamlLog& log_;
  bool present_ = false;
  std::vector<KeyValue> entries_;
  std::vector<std::string> asked_;  ///< requested keys: what an unknown key may have meant
};

/// The `version_key: 1` at the head of a file. Errors: missing, or another version, with the line.
void check_version(YamlMap& root, std::string_view version_key, YamlLog& log);

/// Content of a document of an Octant format: checks its version, then calls read(root, log, content).
/// Unknown keys are warnings, if the content has any.
template <class Content, class Read>
[[nodiscard]] Result<Content> yaml_content(const Result<YamlNode>& node, const std::string& path,
                                           std::string_view version_key, const Read& read) {
  if (!node) return fail(node.error());
  YamlLog log(path);
  YamlMap root(*node, "", log);
  check_version(root, version_key, log);
  Content content;
  read(root, log, content);
  root.finish();
  if (log.error) return fail(*log.error);
  if constexpr (requires { content.warnings; }) content.warnings = std::move(log.warnings);
  return content;
}
template <class Content, class Read>
[[nodiscard]] Result<Content> read_yaml_content(const std::string& path, std::string_view version_key,
                                                const Read& read) {
  return yaml_content<Content>(read_yaml(path), path, version_key, read);
}

/// A site from the content of a site file, or from the `site:` block of another file (then octant_site may be
/// left out). Warnings are in Site::warnings, lines are those of `file`.
[[nodiscard]] Result<Site> site_from_yaml(const YamlNode& node, const std::string& file,
                                          bool version_required = true);

}  // namespace octant::io
