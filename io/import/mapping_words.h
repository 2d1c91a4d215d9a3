// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Private to io: common parts of the mappings of tables and bags.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "io/yaml/yaml_reader.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {

/// `target=source`; the source is empty without an equals sign.
struct MappingWord {
  std::string_view whole, target, source;
};

/// Words of `a=b,c=d`; they are valid as long as the text.
[[nodiscard]] inline std::vector<MappingWord> mapping_words(std::string_view words) {
  std::vector<MappingWord> found;
  while (!words.empty()) {
    const std::string_view word = words.substr(0, words.find(','));
    words.remove_prefix(std::min(words.size(), word.size() + 1));
    const std::size_t equals = word.find('=');
    found.push_back({word, word.substr(0, equals),
                     equals == std::string_view::npos ? std::string_view() : word.substr(equals + 1)});
  }
  return found;
}

[[nodiscard]] inline bool is_ignored(const std::vector<std::string>& ignored, std::string_view name) {
  return std::ranges::find(ignored, name) != ignored.end();
}

/// Names under `ignore` of a mapping: beacons of a neighbour, whose rows are left out and counted.
[[nodiscard]] inline std::vector<std::string> read_ignored(YamlMap& mapping, YamlLog& log) {
  std::vector<std::string> names;
  for (const YamlNode& name : mapping.list("ignore")) names.push_back(text_of(name, "ignore", log));
  return names;
}

inline void write_ignored(YamlWriter& yaml, const std::vector<std::string>& names) {
  yaml.text("ignore");
  yaml.begin_list(true);
  for (const std::string& name : names) yaml.text(name, true);
  yaml.end_list();
}

}  // namespace octant::io
