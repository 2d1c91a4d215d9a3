// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/yaml/yaml_reader.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {

/// The names under `ignore` of a mapping: a neighbour's beacons, which are left out and counted. Private to io.
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
