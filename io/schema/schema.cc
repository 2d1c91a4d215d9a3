// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema.h"

#include <algorithm>
#include <functional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/schema/schema_data.h"
#include "io/text/json_reader.h"

namespace octant::io {
namespace {

using SchemaJson = nlohmann::ordered_json;

/// A site file holds a scene as a scene file does, but for the version.
std::string_view site_schema_with_scene() {
  static const std::string text = [] {
    SchemaJson site = SchemaJson::parse(site_schema()),
               keys = SchemaJson::parse(scene_schema())["properties"];
    keys.erase("octant_scene");
    site["properties"]["scene"]["properties"] = std::move(keys);
    return pretty(site);
  }();
  return text;
}

/// @param file  if it is one of the format's x-files, only this file is kept, without the keys of the format
SchemaJson parsed_schema(std::string_view format, std::string_view file) {
  SchemaJson root = SchemaJson::parse(schema(format));
  if (!root.contains("x-files") || !root["x-files"].contains(file)) return root;
  return {{"title", fmt::format("{}: {}", file, root["title"].get<std::string>())},
          {"x-files", {{file, root["x-files"][std::string(file)]}}}};
}

/// Walks over all keys of a schema. visit(path, key's schema, is it required)
class SchemaWalk {
 public:
  using Visit = std::function<void(const std::string& path, const SchemaJson& key, bool required)>;
  explicit SchemaWalk(Visit visit) : visit_(std::move(visit)) {}

  void walk(const SchemaJson& node, const std::string& path) const {
    if (!node.is_object()) return;
    const SchemaJson required = node.value("required", SchemaJson::array());
    if (node.contains("properties"))
      for (const auto& [name, key] : node["properties"].items()) {
        const std::string below = path.empty() ? name : fmt::format("{}.{}", path, name);
        visit_(below, key, std::ranges::find(required, SchemaJson(name)) != required.end());
        walk(key, below);
      }
    if (node.contains("items")) walk(node["items"], path + "[]");
    if (node.contains("oneOf"))
      for (const auto& choice : node["oneOf"]) walk(choice, path);
    if (node.contains("$defs"))
      for (const auto& [name, definition] : node["$defs"].items()) walk(definition, "$" + name);
  }

 private:
  Visit visit_;
};

/// Text of a table's cell.
std::string cell(const SchemaJson& object, const char* key) {
  if (!object.contains(key)) return "";
  const SchemaJson& value =
      object[key].is_array() && std::string_view(key) == "examples" ? object[key][0] : object[key];
  std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

constexpr const char* kHeading = "| {} | unit | default | example | what it is |\n|---|---|---|---|---|\n";

std::string row(const std::string& name, const SchemaJson& key, bool required) {
  return fmt::format("| `{}` | {} | {} | `{}` | {} |\n", name, cell(key, "x-unit"),
                     required ? "required" : cell(key, "default"), cell(key, "examples"),
                     cell(key, "description"));
}

}  // namespace

std::string_view schema(std::string_view format) {
  if (format == "site") return site_schema_with_scene();
  if (format == "run") return run_schema();
  if (format == "deployment") return deployment_schema();
  if (format == "scenario") return scenario_schema();
  if (format == "batch") return batch_schema();
  if (format == "scene") return scene_schema();
  if (format == "live") return live_schema();
  if (format == "fixes") return fixes_schema();
  if (format == "survey") return survey_schema();
  if (format == "columns") return columns_schema();
  if (format == "topics") return topics_schema();
  if (format == "cockpit") return cockpit_schema();
  if (format == "defaults") return defaults_schema();
  return {};
}

std::string schema_of_file(std::string_view format, std::string_view file) {
  return pretty(parsed_schema(format, file));
}

std::string schema_page(std::string_view format, std::string_view file) {
  const SchemaJson root = parsed_schema(format, file);
  std::string page = fmt::format("# {}\n", cell(root, "title"));
  if (root.contains("properties")) {
    page += fmt::format("\n{}\n\n", cell(root, "description")) + fmt::format(kHeading, "key");
    SchemaWalk([&page](const std::string& path, const SchemaJson& key, bool required) {
      page += row(path, key, required);
    }).walk(root, "");
  }
  if (!root.contains("x-files")) return page;
  for (const auto& [name, about] : root["x-files"].items()) {
    page += fmt::format("\n## {}\n\n{}\n", name, cell(about, "description"));
    if (!about.contains("columns")) continue;
    page += "\n" + fmt::format(kHeading, "column");
    for (const auto& [of, column] : about["columns"].items())
      page += row(of, column, column["required"].get<bool>());
  }
  return page;
}

}  // namespace octant::io
