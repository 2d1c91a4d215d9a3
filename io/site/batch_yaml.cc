// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/batch_yaml.h"

#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "io/text/atomic_file.h"
#include "io/yaml/yaml_reader.h"

namespace octant::io {
namespace {

namespace fs = std::filesystem;

class BatchReader {
 public:
  BatchReader(const std::string& path, const std::string& output_folder, YamlLog& log) : log_(log) {
    const fs::path parent = fs::path(path).parent_path();
    inputs_ = parent.empty() ? fs::path(".") : parent;
    outputs_ = output_folder.empty() ? inputs_ : fs::path(output_folder);
  }

  void read(YamlMap& root, Batch& batch) {
    root.each("sites", batch.sites, [this](YamlMap& map, BatchSite& site) { read_site(map, site); });
    if (batch.sites.empty()) root.fail_missing("sites", "a list of sites");
  }

 private:
  void read_site(YamlMap& map, BatchSite& site) {
    const std::string file = map.required_text("site");
    site.name = map.text("name", file);
    site.site = below(inputs_, file);
    const std::vector<YamlNode> runs = map.list("runs");
    if (runs.empty()) map.fail_missing("runs", "a list of run folders");
    for (const YamlNode& run : runs)
      site.runs.push_back(below(inputs_, text_of(run, map.path("runs"), log_)));
    site.output = output(map, "output", map.required_text("output"));
    if (map.has("report")) site.report = output(map, "report", map.required_text("report"));
  }

  /// An output path; an error if it is empty, or if another site writes to it.
  std::string output(YamlMap& map, const char* key, const std::string& text) {
    if (log_.error) return {};
    if (text.empty() || text == "-")
      map.fail(key, fmt::format("{} is {}", map.path(key), in_quotes(text)), "the name of a file");
    std::string path = below(outputs_, text);
    const auto [before, fresh] = written_.emplace(fs::path(path).lexically_normal().string(), map.path(key));
    if (!fresh)
      map.fail(key, fmt::format("{} is the same file as {}", map.path(key), before->second),
               "a file for each site");
    return path;
  }

  static std::string below(const fs::path& folder, const std::string& name) {
    return (folder / name).string();
  }

  YamlLog& log_;
  fs::path inputs_, outputs_;
  std::map<std::string, std::string> written_;  // keys by the path they name
};

}  // namespace

Result<Batch> read_batch(const std::string& path, const std::string& output_folder) {
  return read_yaml_content<Batch>(path, "octant_batch", [&](YamlMap& root, YamlLog& log, Batch& batch) {
    if (!log.error) BatchReader(path, output_folder, log).read(root, batch);
  });
}

}  // namespace octant::io
