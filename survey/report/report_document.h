// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace octant::survey {

/// Importance of a line. It is never expressed by colour alone: the words express it too.
enum class Tone { kPlain, kGood, kAttention, kBad };

struct ReportText {
  std::string text;
  Tone tone = Tone::kPlain;
};

struct ReportList {
  std::vector<std::string> items;
  bool numbered = false;
};

struct ReportColumn {
  std::string name;    ///< with its unit: "x [m]"
  bool words = false;  ///< true: left-aligned words; false: right-aligned numbers
};

/// The first cell of a row is its heading.
struct ReportTable {
  std::string id;
  std::string caption;
  std::vector<ReportColumn> columns;
  std::vector<std::vector<ReportText>> rows{};
  bool folded = false;  ///< figures of a drawing: shown on demand
};

/// A table of facts, each a row: what it is, and its value.
struct FactTable : ReportTable {
  FactTable(std::string table_id, std::string table_caption)
      : ReportTable{std::move(table_id), std::move(table_caption), {{"what", true}, {"value", true}}} {}
  void add(std::string what, std::string value) { rows.push_back({{std::move(what)}, {std::move(value)}}); }
};

/// A drawing, whole without a script, and if there is one the same as a figure of plotly.js.
struct ReportFigure {
  std::string id;
  std::string caption;
  std::string svg;            ///< trusted: made by this room
  std::string interactive{};  ///< JSON object {data, layout}; empty: no interactive figure
  /// Layers of the SVG (elements of class "layer layer-0", "layer layer-1", ...), of which the reader chooses
  /// one. In the interactive figure, the key "layer" of a trace names the layer to which it belongs.
  std::string legend{};
  std::vector<std::string> layers{};
};

using ReportBlock = std::variant<ReportText, ReportList, ReportTable, ReportFigure>;

struct ReportSection {
  std::string id;
  std::string title;
  std::vector<ReportBlock> blocks{};
};

/// The content of a report; report_html.h and report_markdown.h write it.
struct ReportDocument {
  std::string title;
  std::string subtitle;
  Tone tone = Tone::kPlain;
  std::string grade;     ///< the verdict in a word or two
  std::string sentence;  ///< and in a sentence
  std::vector<ReportSection> sections;
};

}  // namespace octant::survey
