// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/schema/schema_words.h"

#include <array>
#include <functional>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/schema/schema.h"
#include "io/schema/schema_texts.h"
#include "io/text/json_reader.h"

namespace octant::io {
namespace {

using WordsJson = nlohmann::ordered_json;

struct KeyWords {
  std::string example, description;
};

std::string stripped(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string_view::npos
             ? std::string()
             : std::string(text.substr(first, text.find_last_not_of(' ') - first + 1));
}

/// Lines of key_words(): path | example | description.
std::map<std::string, KeyWords> words_of(std::string_view format) {
  std::map<std::string, KeyWords> words;
  std::string_view text = key_words(format);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t first = line.find('|'), second = line.find('|', first + 1);
    if (second == std::string_view::npos) continue;
    words[stripped(line.substr(0, first))] = {stripped(line.substr(first + 1, second - first - 1)),
                                              stripped(line.substr(second + 1))};
  }
  return words;
}

/// A JSON value where it is one, else the text.
WordsJson example_of(const std::string& text) {
  WordsJson value = WordsJson::parse(text, nullptr, false);
  return value.is_discarded() ? WordsJson(text) : value;
}

/// As JSON Schema lists them. By array(): compilers differ in what {x} is.
WordsJson examples_of(const KeyWords& words) { return WordsJson::array({example_of(words.example)}); }

/// Walks over all keys of a schema. visit(path, key's schema, is it required)
class SchemaWalk {
 public:
  using Visit = std::function<void(const std::string& path, WordsJson& key, bool required)>;
  explicit SchemaWalk(Visit visit) : visit_(std::move(visit)) {}

  void walk(WordsJson& node, const std::string& path) const {
    if (!node.is_object()) return;
    const WordsJson required = node.value("required", WordsJson::array());
    if (node.contains("properties"))
      for (auto& [name, key] : node["properties"].items()) {
        const std::string below = path.empty() ? name : path + "." + name;
        visit_(below, key, std::find(required.begin(), required.end(), WordsJson(name)) != required.end());
        walk(key, below);
      }
    if (node.contains("items")) walk(node["items"], path + "[]");
    if (node.contains("oneOf"))
      for (auto& choice : node["oneOf"]) walk(choice, path);
    if (node.contains("$defs"))
      for (auto& [name, definition] : node["$defs"].items()) walk(definition, "$" + name);
  }

 private:
  Visit visit_;
};

/// A description of key_words(): "+ ..." goes behind that of the schema.
std::string joined(const std::string& schemas, const std::string& words) {
  constexpr std::string_view kBehind = "+ ";
  if (words.empty()) return schemas;
  if (!words.starts_with(kBehind)) return words;
  const std::string more = words.substr(kBehind.size());
  return schemas.empty() ? more : schemas + "; " + more;
}

/// Of a number whose name states no unit: it is a count or a ratio.
bool is_numeric_key(const WordsJson& key, const WordsJson& root) {
  if (key.contains("$ref")) {
    const std::string to = key["$ref"].get<std::string>().substr(1);
    return is_numeric_key(root.at(nlohmann::json::json_pointer(to)), root);
  }
  const auto numeric = [](const WordsJson& type) { return type == "number" || type == "integer"; };
  if (!key.contains("type")) return false;
  if (!key["type"].is_array()) return numeric(key["type"]);
  bool any = false;
  for (const WordsJson& type : key["type"]) {
    if (!numeric(type) && type != "null") return false;
    any = any || numeric(type);
  }
  return any;
}

/// Of a column of a file; those of routes.csv that have no words of their own are the ones of cells.csv.
const KeyWords* column_words(const std::map<std::string, KeyWords>& words, const std::string& file,
                             const std::string& column) {
  auto found = words.find(file + ":" + column);
  if (found == words.end() && file == "routes.csv") found = words.find("cells.csv:" + column);
  return found == words.end() ? nullptr : &found->second;
}

/// Columns of the files of a run: a text becomes an object.
void describe_columns(WordsJson& files, const std::map<std::string, KeyWords>& words) {
  constexpr std::string_view kOptional = "optional";
  for (auto& [file, about] : files.items()) {
    if (!about.contains("columns")) continue;
    for (auto& [name, column] : about["columns"].items()) {
      std::string text = column.get<std::string>();
      const bool optional = text.starts_with(kOptional);
      if (optional)
        text = stripped(std::string_view(text).substr(std::min(text.size(), kOptional.size() + 1)));
      const KeyWords* found = column_words(words, file, name);
      if (found != nullptr) text = joined(text, found->description);
      column = {{"description", text}, {"required", !optional}};
      const std::string first(name.substr(0, name.find(',')));
      if (const std::string_view unit = unit_of_key(first); !unit.empty()) column["x-unit"] = unit;
      if (found != nullptr) column["examples"] = examples_of(*found);
    }
  }
}

constexpr std::string_view kInScene = "scene.";  // of a site file

/// Of x-files one file alone, and none of the keys, which are of another; all where it is none of them.
void keep_file(WordsJson& root, std::string_view file) {
  if (!root.contains("x-files") || !root["x-files"].contains(file)) return;
  const WordsJson kept = {{file, root["x-files"][std::string(file)]}};
  root = {{"title", fmt::format("{}: {}", file, root["title"].get<std::string>())}, {"x-files", kept}};
}

WordsJson described(std::string_view format, std::string_view file) {
  WordsJson root = WordsJson::parse(schema(format));
  const auto words = words_of(format), scene_words = words_of("scene");
  SchemaWalk([&](const std::string& path, WordsJson& key, bool) {
    const std::string name = path.substr(path.rfind('.') == std::string::npos ? 0 : path.rfind('.') + 1);
    if (const std::string_view unit = unit_of_key(name); !unit.empty())
      key["x-unit"] = unit;
    else if (is_numeric_key(key, root))
      key["x-unit"] = "1";
    const bool in_scene = path.starts_with(kInScene);
    const auto& all = in_scene ? scene_words : words;
    const auto found = all.find(in_scene ? path.substr(kInScene.size()) : path);
    if (found == all.end()) return;
    key["description"] = joined(key.value("description", ""), found->second.description);
    if (!found->second.example.empty()) key["examples"] = examples_of(found->second);
  }).walk(root, "");
  if (root.contains("x-files")) describe_columns(root["x-files"], words);
  keep_file(root, file);
  return root;
}

/// Text of a table's cell.
std::string cell(const WordsJson& object, const char* key) {
  if (!object.contains(key)) return "";
  const WordsJson& value =
      object[key].is_array() && std::string_view(key) == "examples" ? object[key][0] : object[key];
  std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

constexpr const char* kHeading = "| {} | unit | default | example | what it is |\n|---|---|---|---|---|\n";

std::string row(const std::string& name, const WordsJson& key, bool required) {
  return fmt::format("| `{}` | {} | {} | `{}` | {} |\n", name, cell(key, "x-unit"),
                     required ? "required" : cell(key, "default"), cell(key, "examples"),
                     cell(key, "description"));
}

}  // namespace

std::string_view unit_of_key(std::string_view key) {
  using Unit = std::pair<std::string_view, std::string_view>;
  static constexpr std::array<Unit, 23> kUnits = {{{"_m_per_sqrt_m", "m per root of m"},
                                                   {"_rad_per_m", "rad/m"},
                                                   {"_rad_per_sqrt_m", "rad per root of m"},
                                                   {"_rad_per_s2", "rad/s2"},
                                                   {"_rad_per_s", "rad/s"},
                                                   {"_per_rad", "rad per rad"},
                                                   {"_np_per_m", "Np/m"},
                                                   {"_m_per_m", "m per m"},
                                                   {"_mps2", "m/s2"},
                                                   {"_mps", "m/s"},
                                                   {"_degC", "degC"},
                                                   {"_dbm", "dBm"},
                                                   {"_ppm", "1e-6"},
                                                   {"_rad", "rad"},
                                                   {"_hz", "Hz"},
                                                   {"_pa", "Pa"},
                                                   {"_m2", "m2"},
                                                   {"_s", "s"},
                                                   {"_m", "m"},
                                                   {"_v", "V"},
                                                   {"_humidity", "fraction, 0 to 1"},
                                                   {"_fraction", "fraction, 0 to 1"},
                                                   {"_relative_sigma", "fraction of the amplitude"}}};
  for (const auto& [ending, unit] : kUnits)
    if (key.ends_with(ending)) return unit;
  return "";
}

std::string schema_with_words(std::string_view format, std::string_view file) {
  return pretty(described(format, file));
}

std::string schema_page(std::string_view format, std::string_view file) {
  WordsJson root = described(format, file);
  std::string page = fmt::format("# {}\n", cell(root, "title"));
  if (root.contains("properties")) {
    page += fmt::format("\n{}\n\n", cell(root, "description")) + fmt::format(kHeading, "key");
    SchemaWalk([&page](const std::string& path, WordsJson& key, bool required) {
      page += row(path, key, required);
    }).walk(root, "");
  }
  if (!root.contains("x-files")) return page;
  for (auto& [name, about] : root["x-files"].items()) {
    page += fmt::format("\n## {}\n\n{}\n", name, cell(about, "description"));
    if (!about.contains("columns")) continue;
    page += "\n" + fmt::format(kHeading, "column");
    for (auto& [of, column] : about["columns"].items())
      page += row(of, column, column["required"].get<bool>());
  }
  return page;
}

}  // namespace octant::io
