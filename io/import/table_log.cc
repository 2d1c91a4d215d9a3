// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/table_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "io/import/mapping_words.h"
#include "io/run/last_row.h"
#include "io/text/bounds.h"
#include "io/text/open_file.h"
#include "io/text/text.h"
#include "io/tof/run_parts.h"
#include "io/tof/tof_columns.h"
#include "io/yaml/yaml_reader.h"
#include "io/yaml/yaml_writer.h"

namespace octant::io {
namespace {

constexpr std::array<std::pair<std::string_view, double>, 8> kUnitSuffixes = {{{"_ms", 1e-3},
                                                                               {"_us", 1e-6},
                                                                               {"_ns", 1e-9},
                                                                               {"_cm", 1e-2},
                                                                               {"_mm", 1e-3},
                                                                               {"_km", 1e3},
                                                                               {"_ft", 0.3048},
                                                                               {"_mv", 1e-3}}};

constexpr std::size_t kHeadBytes = 65536;   // a header and what is commented above it stand within
constexpr std::size_t kHeaderBytes = 4096;  // longer lines are no header that people wrote

const TofColumn* tof_column(std::string_view name) {
  for (const TofColumn& c : kTofColumns)
    if (name == c.name || name == c.short_name) return &c;
  return nullptr;
}

Result<ColumnRule> rule_of(std::string_view target, std::string_view source) {
  const TofColumn* column = tof_column(without_blanks(target));
  if (column == nullptr)
    return fail(
        {.code = Errc::kUsage,
         .found = fmt::format("{} is no column of tof.csv", in_quotes(target)),
         .expected = "time, beacon, tof or distance, epoch, vehicle, receiver, amplitude, temperature"});
  ColumnRule rule{std::string(column->name), std::string(without_blanks(source))};
  if (const auto star = source.rfind('*'); star != std::string_view::npos) {
    rule.source = without_blanks(source.substr(0, star));
    if (parse_number(without_blanks(source.substr(star + 1)), rule.factor) != NumberText::kNumber ||
        !std::isfinite(rule.factor) || rule.factor == 0.0)
      return fail({.code = Errc::kUsage,
                   .found = fmt::format("{} is no factor", in_quotes(source.substr(star + 1))),
                   .expected = "a number, as in timestamp_ms*1e-3"});
  } else if (!column->is_id) {
    const std::string lower = lower_case(rule.source);
    for (const auto& [suffix, factor] : kUnitSuffixes)
      if (lower.ends_with(suffix)) rule.factor = factor;
  }
  if (rule.source.empty())
    return fail({.code = Errc::kUsage,
                 .found = fmt::format("{} has no column of the table", in_quotes(target)),
                 .expected = "TARGET=COLUMN or TARGET=COLUMN*FACTOR"});
  return rule;
}

Result<void> check_mapping(const TableMapping& mapping) {
  const auto has = [&](std::string_view name) {
    return std::ranges::count(mapping.columns, name, &ColumnRule::target);
  };
  for (const TofColumn& c : kTofColumns)
    if (has(c.name) > 1)
      return fail({.code = Errc::kUsage, .found = fmt::format("{} is there twice", c.name)});
  if (has("time_s") == 1 && has("beacon") == 1 && has("tof_s") + has("distance_m") == 1) return {};
  return fail({.code = Errc::kUsage,
               .found = "the columns do not say what was heard when",
               .expected = "time, beacon and one of tof and distance, as in "
                           "time=timestamp_ms*1e-3,beacon=anchor,distance=distance_cm*1e-2"});
}

/// One line's cells. Quotes as in RFC 4180; several blanks are one delimiter.
/// @param open  whether a quote does not end on the line
std::vector<std::string> cells_of(std::string_view line, char delimiter, bool* open = nullptr) {
  std::vector<std::string> cells;
  std::string cell;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted) {
      if (c != '"') {
        cell += c;
      } else if (i + 1 < line.size() && line[i + 1] == '"') {
        cell += line[++i];
      } else {
        quoted = false;
      }
    } else if (c == '"' && without_blanks(cell).empty()) {
      quoted = true;
      cell.clear();
    } else if (c == delimiter) {
      if (delimiter != ' ' || !cell.empty()) cells.push_back(std::exchange(cell, {}));
    } else {
      cell += c;
    }
  }
  if (delimiter != ' ' || !cell.empty()) cells.push_back(cell);
  if (open != nullptr) *open = quoted;
  for (std::string& text : cells) text = without_blanks(text);
  return cells;
}

/// The delimiter by which the header holds all columns that are asked for; of several the one with most
/// cells.
char delimiter_of(std::string_view header, const TableMapping& mapping) {
  char best = ',';
  std::size_t most_found = 0, most_cells = 0;
  for (const char delimiter : {',', ';', '\t', '|', ' '}) {
    const auto cells = cells_of(header, delimiter);
    std::size_t found = 0;
    for (const ColumnRule& r : mapping.columns) found += std::ranges::count(cells, r.source) > 0 ? 1 : 0;
    if (std::pair(found, cells.size()) <= std::pair(most_found, most_cells)) continue;
    best = delimiter;
    most_found = found;
    most_cells = cells.size();
  }
  return best;
}

struct TableRow {
  double time_s = 0.0;
  std::string text;
};

class TableReader {
 public:
  TableReader(const std::string& path, const TableMapping& mapping) : path_(path), mapping_(mapping) {}

  Result<ConvertedTable> read(std::string_view text) {
    std::vector<TableRow> rows;
    while (!text.empty()) {
      const std::string_view line = without_blanks(take_line(text));
      ++line_;
      if (line.empty() || line.front() == '#') continue;
      if (sources_.empty()) {
        if (auto known = read_header(line); !known) return fail(known.error());
        continue;
      }
      TableRow row;
      const auto kept = read_row(line, row);
      if (!kept) return fail(kept.error());
      if (*kept) rows.push_back(std::move(row));
    }
    if (sources_.empty())
      return fail({.code = Errc::kBadInput, .file = path_, .found = "the table is empty"});
    if (rows.empty() && out_.dropped == 0 && out_.ignored == 0)
      return fail({.code = Errc::kBadInput,
                   .file = path_,
                   .line = line_,
                   .found = "the table has no rows under its header",
                   .expected = "a row an arrival"});
    return finish(rows);
  }

 private:
  Result<std::vector<std::string>> cells_in(std::string_view line) const {
    bool open = false;
    auto cells = cells_of(line, out_.delimiter, &open);
    if (!open) return cells;
    return fail({.code = Errc::kBadInput,
                 .file = path_,
                 .line = line_,
                 .found = "a quote that does not end on its line",
                 .expected = "quotes in pairs, and a row a line"});
  }

  Result<void> read_header(std::string_view line) {
    out_.delimiter = delimiter_of(line, mapping_);
    auto header = cells_in(line);
    if (!header) return fail(header.error());
    header_ = std::move(*header);
    std::vector<std::string> missing;
    for (const ColumnRule& rule : mapping_.columns) {
      const auto at = std::ranges::find(header_, rule.source);
      if (at == header_.end()) missing.push_back(in_quotes(rule.source));
      sources_.push_back(static_cast<std::size_t>(at - header_.begin()));
    }
    if (missing.empty()) return {};
    return fail({.code = Errc::kBadInput,
                 .file = path_,
                 .line = line_,
                 .found = fmt::format("the table has no column {}", listed(missing)),
                 .expected = fmt::format("columns of its header: {}", listed(header_, 20))});
  }

  /// 1,5 is a number where commas do not part the cells.
  bool number(std::string text, double& value) {
    if (out_.delimiter != ',' && std::ranges::count(text, ',') == 1 && text.find('.') == std::string::npos) {
      std::ranges::replace(text, ',', '.');
      out_.decimal_comma = true;
    }
    return parse_number(text, value) == NumberText::kNumber;
  }

  /// False: the row is none of ours.
  Result<bool> read_row(std::string_view line, TableRow& row) {
    const auto cells = cells_in(line);
    if (!cells) return fail(cells.error());
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const ColumnRule& rule = mapping_.columns[i];
      const std::string cell = sources_[i] < cells->size() ? (*cells)[sources_[i]] : "";
      row.text += i == 0 ? "" : ",";
      if (rule.target == "beacon") {
        if (cell.empty()) return ++out_.dropped, false;
        if (is_ignored(mapping_.ignore, cell)) return ++out_.ignored, false;
      }
      if (tof_column(rule.target)->is_id) {
        row.text += csv_field(cell);
        continue;
      }
      double value = std::nan("");
      if (!cell.empty() && !number(cell, value))
        return fail(
            {.code = Errc::kBadInput,
             .file = path_,
             .line = line_,
             .found = fmt::format("{} in column {}", in_quotes(cell), in_quotes(rule.source)),
             .expected = "a number",
             .advice = cell.find(',') == std::string::npos || out_.delimiter != ','
                           ? ""
                           : "a decimal comma is read where semicolons or tabulators part the cells"});
      value *= rule.factor;
      if (rule.target == "time_s") {
        if (!std::isfinite(value))
          return fail({.code = Errc::kBadInput,
                       .file = path_,
                       .line = line_,
                       .found = "a row without a time",
                       .expected = "a number"});
        row.time_s = value;
      }
      row.text += number_field(value);
    }
    return true;
  }

  ConvertedTable finish(std::vector<TableRow>& rows) {
    for (const ColumnRule& rule : mapping_.columns) out_.csv += (out_.csv.empty() ? "" : ",") + rule.target;
    out_.csv += '\n';
    const auto earlier = [](const TableRow& a, const TableRow& b) { return a.time_s < b.time_s; };
    if (!std::ranges::is_sorted(rows, earlier)) {
      out_.warnings.push_back(path_ + ": the rows are not in the order of time; they were put into it");
      std::ranges::stable_sort(rows, earlier);
    }
    if (out_.dropped > 0)
      out_.warnings.push_back(fmt::format("{}: {} rows without a beacon were left out", path_, out_.dropped));
    for (const TableRow& row : rows) out_.csv += row.text + '\n';
    out_.rows = rows.size();
    return std::move(out_);
  }

  const std::string& path_;
  const TableMapping& mapping_;
  int line_ = 0;
  std::vector<std::string> header_;
  std::vector<std::size_t> sources_;
  ConvertedTable out_;
};

}  // namespace

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

std::optional<TableMapping> mapping_of_header(const std::string& path) {
  const auto map = MappedFile::open(path);
  if (!map) return std::nullopt;
  std::string_view text = without_bom(map->text().substr(0, kHeadBytes));
  std::string_view header;
  while (!text.empty() && (header.empty() || header.front() == '#')) header = without_blanks(take_line(text));
  TableMapping all;
  for (const TofColumn& c : kTofColumns) all.columns.push_back({std::string(c.name), std::string(c.name)});
  const auto cells =
      cells_of(header.substr(0, kHeaderBytes), delimiter_of(header.substr(0, kHeaderBytes), all));
  TableMapping own;
  for (const ColumnRule& rule : all.columns)
    if (std::ranges::count(cells, rule.source) == 1) own.columns.push_back(rule);
  return check_mapping(own) ? std::optional(own) : std::nullopt;
}

Result<TableMapping> read_mapping(const std::string& path) {
  auto mapping = read_yaml_content<TableMapping>(
      path, "octant_columns", [](YamlMap& root, YamlLog& log, TableMapping& table) {
        YamlMap columns(root.block("columns"), "columns", log);
        for (const TofColumn& column : kTofColumns) {
          if (!columns.has(column.name)) continue;
          auto rule = rule_of(column.name, columns.required_text(column.name));
          if (!rule) {
            columns.fail(column.name, rule.error().found, rule.error().expected);
          } else {
            table.columns.push_back(std::move(*rule));
          }
        }
        table.ignore = read_ignored(root, log);
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

std::string mapping_to_yaml(const TableMapping& mapping) {
  YamlWriter yaml;
  yaml.begin_map(false);
  yaml.text("octant_columns");
  yaml.text("1");
  yaml.text("columns");
  yaml.begin_map(false);
  for (const ColumnRule& rule : mapping.columns) {
    yaml.text(rule.target);
    yaml.text(tof_column(rule.target)->is_id ? rule.source : rule.source + "*" + exact(rule.factor), true);
  }
  yaml.end_map();
  write_ignored(yaml, mapping.ignore);
  yaml.end_map();
  return yaml.finish();
}

Result<ConvertedTable> convert_table(const std::string& path, const TableMapping& mapping) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  if (auto text = check_lines(map->text(), path); !text) return fail(text.error());
  std::vector<std::string> warnings;
  const std::string_view whole = without_cut_row(map->text(), path, warnings);
  auto table = TableReader(path, mapping).read(without_bom(whole));
  if (table) table->warnings.insert(table->warnings.begin(), warnings.begin(), warnings.end());
  return table;
}

}  // namespace octant::io
