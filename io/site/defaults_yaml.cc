// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/defaults_yaml.h"

#include "io/yaml/yaml_reader.h"

namespace octant::io {

Result<Defaults> read_defaults(const std::string& path) {
  const auto read = [](YamlMap& root, YamlLog&, Defaults& defaults) {
    if (root.has("threads")) defaults.threads = root.integer("threads", 0, 0, 1024);
    if (root.has("progress")) {
      const std::vector<std::pair<std::string, std::string>> styles = {
          {"auto", "auto"}, {"plain", "plain"}, {"json", "json"}, {"none", "none"}};
      defaults.progress = root.choice<std::string>("progress", styles, "auto");
    }
    if (root.has("quiet")) defaults.quiet = root.boolean("quiet", false);
    if (root.has("verbose")) defaults.verbose = root.boolean("verbose", false);
  };
  return read_yaml_content<Defaults>(path, "octant_defaults", read);
}

}  // namespace octant::io
