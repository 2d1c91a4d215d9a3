// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/mapping_text.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "io/import/mapping_words.h"
#include "io/import/name_pattern.h"
#include "io/table/column_unit.h"
#include "io/table/table_cells.h"
#include "io/text/open_file.h"
#include "io/text/text.h"
#include "io/yaml/yaml_reader.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {
namespace {

constexpr std::string_view kRelations[] = {"!=", "<=", ">=", "=", "<", ">"};  // the longer ones first

constexpr const char* kTargets =
    "time, beacon, tof or distance (distance:A1 for a column of beacon A1), epoch, vehicle, receiver, "
    "amplitude, temperature, received";

/// The beacon and receiver of "distance:A1" or "distance:A1:front".
void read_names(std::string_view names, ColumnRule& rule) {
  const std::size_t colon = names.find(':');
  rule.beacon = without_blanks(names.substr(0, colon));
  if (colon != std::string_view::npos) rule.receiver = without_blanks(names.substr(colon + 1));
}

Result<ColumnRule> rule_of(std::string_view target, std::string_view source) {
  const std::size_t colon = target.find(':');
  const TofColumn* column = tof_column(without_blanks(target.substr(0, colon)));
  const bool is_value = column != nullptr && (column->name == "tof_s" || column->name == "distance_m");
  if (column == nullptr || (colon != std::string_view::npos && !is_value))
    return fail({.code = Errc::kUsage,
                 .found = fmt::format("{} is no column of tof.csv", in_quotes(target)),
                 .expected = kTargets});
  ColumnRule rule{std::string(column->name), std::string(without_blanks(source))};
  const auto refuse = [&target](std::string found, std::string expected) {
    return fail({.code = Errc::kUsage,
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .advice = fmt::format("see {}=... in --columns", target)});
  };
  if (colon != std::string_view::npos) {
    read_names(target.substr(colon + 1), rule);
    if (rule.beacon.empty())
      return refuse(fmt::format("{} names no beacon", in_quotes(target)), "distance:A1=COLUMN");
  }
  if (const auto star = source.rfind('*'); star != std::string_view::npos) {
    rule.source = without_blanks(source.substr(0, star));
    double factor = 0.0;
    if (parse_number(without_blanks(source.substr(star + 1)), factor) != NumberText::kNumber ||
        !std::isfinite(factor) || factor == 0.0)
      return refuse(fmt::format("{} is no factor", in_quotes(source.substr(star + 1))),
                    "a number, as in timestamp_ms*1e-3");
    rule.factor = factor;
  }
  if (rule.source.empty())
    return refuse(fmt::format("{} has no column of the table", in_quotes(target)),
                  "TARGET=COLUMN or TARGET=COLUMN*FACTOR");
  if (!is_pattern(rule)) return rule;
  if (const std::string fault = fault_of_pattern(rule.source); !fault.empty())
    return refuse(fault, "{beacon} or {receiver} in the name of a column");
  if (rule.beacon.empty() && rule.source.find("{beacon}") == std::string::npos)
    return refuse(fmt::format("{} does not name the beacon", in_quotes(rule.source)),
                  "a pattern such as r_{beacon}");
  return rule;
}

std::string source_text(const ColumnRule& rule) {
  return rule.factor ? rule.source + "*" + exact(*rule.factor) : rule.source;
}

void write_list(YamlWriter& yaml, const char* key, const std::vector<std::string>& words) {
  if (words.empty()) return;
  yaml.text(key);
  yaml.begin_list(true);
  for (const std::string& word : words) yaml.text(word, true);
  yaml.end_list();
}

/// Keys about the rows and cells, as far as they are not the default.
void write_rows(YamlWriter& yaml, const TableMapping& mapping) {
  std::vector<std::string> where;
  for (const RowCondition& c : mapping.where) where.push_back(c.column + c.relation + c.value);
  write_list(yaml, "where", where);
  write_list(yaml, "no_value", mapping.no_value);
  const auto text = [&yaml](const char* key, const std::string& value) {
    if (value.empty()) return;
    yaml.text(key);
    yaml.text(value);
  };
  text("header", mapping.no_header ? "none" : "");
  text("time_format", mapping.time_format);
  text("decimal", mapping.decimal);
  text("period_s", mapping.period_s ? exact(*mapping.period_s) : "");
}

void read_rows(YamlMap& root, YamlLog& log, TableMapping& table) {
  for (const YamlNode& word : root.list("where")) {
    auto condition = condition_from_word(text_of(word, "where", log));
    if (!condition) return root.fail("where", condition.error().found, condition.error().expected);
    table.where.push_back(std::move(*condition));
  }
  for (const YamlNode& word : root.list("no_value")) table.no_value.push_back(text_of(word, "no_value", log));
  std::vector<std::pair<std::string, std::string>> formats;
  for (const char* format : kTimeFormats) formats.emplace_back(format, format);
  table.no_header = root.choice<bool>("header", {{"none", true}}, false);
  table.time_format = root.choice<std::string>("time_format", formats, "");
  table.decimal = root.choice<std::string>("decimal", {{"point", "point"}, {"comma", "comma"}}, "");
  table.period_s = root.optional_number("period_s", kPositive);
}

void add_rule(YamlMap& columns, std::string_view key, const std::string& target, const std::string& source,
              TableMapping& table) {
  auto rule = rule_of(target, source);
  if (rule) return table.columns.push_back(std::move(*rule));
  columns.fail(key, rule.error().found, rule.error().expected);
}

}  // namespace

Result<void> check_mapping(const TableMapping& mapping) {
  const auto refuse = [](std::string found, std::string expected) {
    return fail({.code = Errc::kUsage, .found = std::move(found), .expected = std::move(expected)});
  };
  const auto has = [&](std::string_view name) {
    return std::ranges::count(mapping.columns, name, &ColumnRule::target);
  };
  const auto wide = std::ranges::count_if(mapping.columns, names_beacon);
  for (const TofColumn& c : kTofColumns)
    if (has(c.name) > 1 && (wide == 0 || has(c.name) != wide))
      return refuse(fmt::format("{} is there twice", c.name), "each column once");
  for (const ColumnRule& rule : mapping.columns) {
    if (!names_beacon(rule)) continue;
    const bool alone = !rule.beacon.empty() || wide == 1;
    const auto same = std::ranges::count_if(mapping.columns, [&](const ColumnRule& other) {
      return other.beacon == rule.beacon && other.receiver == rule.receiver && names_beacon(other);
    });
    if (!alone || same > 1)
      return refuse(fmt::format("several columns for {}", rule.beacon.empty() ? rule.source : rule.beacon),
                    "one pattern, or one column for each beacon and receiver");
  }
  const auto values = has("tof_s") + has("distance_m");
  if (wide > 0 && (has("beacon") > 0 || values != wide))
    return refuse("both a column of beacons and columns of one beacon",
                  "beacon=COLUMN and one column of values, or a column for each beacon");
  const bool wide_receivers = std::ranges::any_of(mapping.columns, [](const ColumnRule& rule) {
    return !rule.receiver.empty() ||
           (is_pattern(rule) && rule.source.find("{receiver}") != std::string::npos);
  });
  if (wide_receivers && has("receiver") > 0)
    return refuse("both a column of receivers and columns of one receiver", "one of the two");
  if (has("time_s") <= 1 && (wide > 0 || (has("beacon") == 1 && values == 1)) &&
      (has("tof_s") == 0 || has("distance_m") == 0))
    return {};
  return refuse("the columns do not say what was heard when",
                "time, beacon and one of tof and distance, as in "
                "time=timestamp_ms*1e-3,beacon=anchor,distance=distance_cm*1e-2; or, with a column for each "
                "beacon, time=t,distance=r_{beacon}");
}

Result<RowCondition> condition_from_word(std::string_view word) {
  std::size_t at = word.find_first_of("=<>!");
  for (const std::string_view relation : kRelations) {
    if (at == std::string_view::npos || !word.substr(at).starts_with(relation)) continue;
    std::string_view value = word.substr(at + relation.size());
    if (relation == "=" && value.starts_with('=')) value.remove_prefix(1);
    RowCondition condition{std::string(without_blanks(word.substr(0, at))), std::string(relation),
                           std::string(without_blanks(value))};
    if (!condition.column.empty()) return condition;
  }
  return fail({.code = Errc::kUsage,
               .found = fmt::format("{} is no condition", in_quotes(word)),
               .expected = "COLUMN=VALUE, or with != < <= > >=, as in --where valid=1"});
}

Result<TableMapping> mapping_from_words(std::string_view words) {
  TableMapping mapping;
  if (!is_utf8(words))
    return fail({.code = Errc::kUsage,
                 .found = "--columns is no UTF-8 text",
                 .expected = "names of columns in UTF-8, as the table is to be"});
  for (const MappingWord& word : mapping_words(words)) {
    auto rule = rule_of(word.target, word.source);
    if (!rule) return fail(rule.error());
    mapping.columns.push_back(std::move(*rule));
  }
  if (auto whole = check_mapping(mapping); !whole) return fail(whole.error());
  return mapping;
}

Result<TableMapping> read_mapping(const std::string& path) {
  auto mapping = read_yaml_content<TableMapping>(
      path, "octant_columns", [](YamlMap& root, YamlLog& log, TableMapping& table) {
        YamlMap columns(root.block("columns"), "columns", log);
        for (const TofColumn& column : kTofColumns) {
          if (!columns.has(column.name)) continue;
          const std::string target(column.name);
          const YamlNode node = columns.get(column.name);
          if (!node.is_map()) {
            add_rule(columns, column.name, target, columns.required_text(column.name), table);
            continue;
          }
          for (std::size_t i = 0; i < node.size() && !log.error; ++i)
            add_rule(columns, column.name, target + ":" + std::string(node.key(i).scalar()),
                     text_of(node.value(i), columns.path(column.name), log), table);
        }
        table.ignore = read_ignored(root, log);
        read_rows(root, log, table);
        columns.finish();
      });
  if (!mapping) return mapping;
  if (auto whole = check_mapping(*mapping); !whole) {
    Error error = whole.error();
    error.code = Errc::kBadInput;
    error.file = path;
    return fail(error);
  }
  return mapping;
}

std::string mapping_to_words(const TableMapping& mapping) {
  std::string words;
  for (const ColumnRule& rule : mapping.columns) {
    std::string target(tof_column(rule.target)->short_name);
    if (!rule.beacon.empty()) target += ":" + rule.beacon;
    if (!rule.receiver.empty()) target += ":" + rule.receiver;
    words += (words.empty() ? "" : ",") + target + "=" + source_text(rule);
  }
  return words.find_first_of(" #{}()[]*;&'\"") == std::string::npos ? words : "'" + words + "'";
}

std::string mapping_to_options(const TableMapping& mapping) {
  std::string options = "--columns " + mapping_to_words(mapping);
  if (!mapping.time_format.empty()) options += " --time-format " + mapping.time_format;
  if (!mapping.decimal.empty()) options += " --decimal " + mapping.decimal;
  return options;
}

std::string mapping_to_yaml(const TableMapping& mapping) {
  YamlWriter yaml;
  yaml.begin_map(false);
  yaml.text("octant_columns");
  yaml.text("1");
  yaml.text("columns");
  yaml.begin_map(false);
  bool in_block = false;
  for (const ColumnRule& rule : mapping.columns) {
    if (rule.beacon.empty()) {
      yaml.text(rule.target);
      yaml.text(source_text(rule), true);
      continue;
    }
    if (std::exchange(in_block, true)) continue;
    yaml.text(rule.target);
    yaml.begin_map(false);
    for (const ColumnRule& of_beacon : mapping.columns) {
      if (of_beacon.beacon.empty()) continue;
      yaml.text(of_beacon.receiver.empty() ? of_beacon.beacon : of_beacon.beacon + ":" + of_beacon.receiver,
                true);
      yaml.text(source_text(of_beacon), true);
    }
    yaml.end_map();
  }
  yaml.end_map();
  write_ignored(yaml, mapping.ignore);
  write_rows(yaml, mapping);
  yaml.end_map();
  return yaml.finish();
}

}  // namespace octant::io
