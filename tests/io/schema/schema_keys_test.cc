// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Schemas and readers are written separately. Here each key of a schema is written to a file with its
// example, and the reader must know it.
#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/network/network_file.h"
#include "io/run/run_folder.h"
#include "io/schema/schema.h"
#include "io/site/scene_yaml.h"
#include "io/site/site_yaml.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace schema_keys_test {

using test::TemporaryFolder;
using KeysJson = nlohmann::json;

/// Paths and examples as the page of a format lists them, in its order.
std::vector<std::pair<std::string, KeysJson>> keys_of(std::string_view format) {
  std::vector<std::pair<std::string, KeysJson>> keys;
  std::string page = schema_page(format);
  page.resize(std::min(page.size(), page.find("\n## ")));
  const std::regex row(R"(\| `([^`]*)` \| [^|]* \| [^|]* \| `(.*?)` \| .*)");
  for (std::sregex_iterator at(page.begin(), page.end(), row), end; at != end; ++at) {
    if ((*at)[1].str().starts_with("scene.")) continue;  // a reader of its own
    const std::string text = (*at)[2];
    KeysJson example = KeysJson::parse(text, nullptr, false);
    keys.emplace_back((*at)[1], example.is_discarded() ? KeysJson(text) : example);
  }
  return keys;
}

KeysJson::json_pointer pointer_to(const std::string& path) {
  std::string text = "/";
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path.compare(i, 2, "[]") == 0) {
      text += "/0";
      ++i;
    } else {
      text += path[i] == '.' ? '/' : path[i];
    }
  }
  return KeysJson::json_pointer(text);
}

/// A file with this key and its containers with their examples; no value if these do not fit.
std::optional<KeysJson> with_key(KeysJson file, const std::map<std::string, KeysJson>& examples,
                                 const std::string& path, const std::string& name, const KeysJson& value) {
  std::size_t dot = 0;
  while ((dot = path.find('.', dot)) != std::string::npos) {
    std::string container = path.substr(0, dot++);
    const bool list = container.ends_with("[]");
    if (list) container.resize(container.size() - 2);
    const auto at = pointer_to(container);
    if (file.contains(at) && file[at].is_array() == list) continue;
    const auto found = examples.find(container);
    if (found == examples.end() || found->second.is_array() != list) return std::nullopt;
    file[at] = found->second;
  }
  dot = path.rfind('.');
  file[pointer_to((dot == std::string::npos ? "" : path.substr(0, dot + 1)) + name)] = value;
  return file;
}

/// Warnings of a file; no value if it is refused, because keys exclude each other.
using Warnings = std::optional<std::vector<std::string>>;

bool says_unknown(const std::vector<std::string>& warnings) {
  return std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find("unknown key") != std::string::npos;
  });
}

/// @param company  other content of the file, for keys that have a meaning only together with others
void expect_known(std::string_view format, const KeysJson& file,
                  const std::function<Warnings(const std::string&)>& read,
                  const std::map<std::string, KeysJson>& company = {}) {
  const auto keys = keys_of(format);
  const std::map<std::string, KeysJson> examples(keys.begin(), keys.end());
  std::size_t tried = 0, told = 0;
  for (const auto& [path, example] : keys) {
    KeysJson base = file;
    if (const auto with = company.find(path); with != company.end()) base.update(with->second);
    const std::string name = path.substr(path.find_last_of('.') + 1);
    if (const auto right = with_key(base, examples, path, name, example)) {
      if (const Warnings warnings = read(right->dump())) {
        ++tried;
        EXPECT_FALSE(says_unknown(*warnings)) << path << ": " << ::testing::PrintToString(*warnings);
      }
    }
    const auto wrong = with_key(base, examples, path, "zzz_" + name, example);
    if (!wrong) continue;
    if (const Warnings warnings = read(wrong->dump())) told += says_unknown(*warnings);
  }
  // The rest are refused: of their container's example they exclude a key.
  EXPECT_GT(tried, 3 * keys.size() / 4) << "of " << keys.size();
  EXPECT_GT(told, 3 * keys.size() / 4) << "a key that is none is told in any place";
}

TEST(SchemaKeys, OfASiteAreKnownToItsReader) {
  const KeysJson site = KeysJson::parse(R"({"octant_site": 1, "motion": "planar",
    "medium": {"model": "cramer1993"}, "timing": {"delay_per": "beacon"}, "noise": {"tof_sigma_s": 1e-5},
    "beacons": [{"id": "B0", "position_m": [0, 0, 2.5]}, {"id": "B1", "position_m": [9, 0, 2.5]}],
    "vehicles": [{"id": "robot", "receivers": [{"id": "r0", "position_m": [0, 0, 0.3]}]}]})");
  const TemporaryFolder folder;
  expect_known("site", site, [&](const std::string& text) -> Warnings {
    const auto read = read_site(folder.write("site.yaml", text));
    if (!read) return std::nullopt;
    return read->warnings;
  });
}

TEST(SchemaKeys, OfASceneAreKnownToItsReader) {
  const TemporaryFolder folder;
  const auto power = KeysJson::parse(R"({"patterns": [{"id": "p", "kind": "cosine_power", "exponent": 1}]})");
  const auto table = KeysJson::parse(
      R"({"patterns": [{"id": "p", "kind": "table", "angle_rad": [0, 1], "gain": [1, 0.5]}]})");
  expect_known("scene", KeysJson::parse(R"({"octant_scene": 1})"),
               [&](const std::string& text) -> Warnings {
                 const auto read = read_scene(folder.write("scene.yaml", text));
                 if (!read) return std::nullopt;
                 return read->warnings;
               },
               {{"patterns[].exponent", power}, {"patterns[].angle_rad", table}, {"patterns[].gain", table}});
}

TEST(SchemaKeys, OfASurveyAreKnownToItsReader) {
  const TemporaryFolder folder;
  const auto points = KeysJson::parse(R"({"points": [{"id": "P1", "position_m": [0, 0, 0], "fixed": "xyz"},
    {"id": "A"}, {"id": "B"}, {"id": "B1"}, {"id": "B2"}]})");
  const auto correlated = KeysJson::parse(R"({"distances": [
    {"id": "o1", "from": "A", "to": "B", "slope_m": 5, "sigma_m": 0.1},
    {"id": "o2", "from": "A", "to": "B", "slope_m": 5, "sigma_m": 0.1}]})");
  auto survey = points;
  survey["octant_survey"] = 1;
  expect_known("survey", survey,
               [&](const std::string& text) -> Warnings {
                 const auto read = read_survey(folder.write("survey.yaml", text));
                 if (!read) return std::nullopt;
                 return read->warnings;
               },
               {{"correlations", correlated},
                {"correlations[].observations", correlated},
                {"correlations[].correlation", correlated}});
}

TEST(SchemaKeys, OfARunAreKnownToItsReader) {
  const TemporaryFolder folder;
  NameTable names;
  names.beacons = {"B0"};
  names.vehicles = {"robot"};
  names.receivers = {{"r0", VehicleId(0)}};
  folder.write("run/tof.csv", "time_s,beacon,tof_s\n0.1,B0,0.01\n");
  expect_known("run", KeysJson::parse(R"({"octant_run": 1})"), [&](const std::string& text) -> Warnings {
    folder.write("run/run.yaml", text);
    const auto read = read_run(folder.path("run"), names, {});
    if (!read) return std::nullopt;
    return read->warnings;
  });
}

}  // namespace schema_keys_test
}  // namespace octant::io
