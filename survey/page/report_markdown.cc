// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/report_markdown.h"

#include <fmt/format.h>

#include "survey/drawing/escape.h"
#include "survey/report/report.h"

namespace octant::survey {
namespace {

struct MarkdownWriter {
  std::string text;

  void operator()(const ReportText& paragraph) { text += escape_markdown(paragraph.text) + "\n\n"; }

  void operator()(const ReportList& list) {
    for (std::size_t i = 0; i < list.items.size(); ++i)
      text += (list.numbered ? fmt::format("{}. ", i + 1) : std::string("- ")) +
              escape_markdown(list.items[i]) + "\n";
    text += "\n";
  }

  void operator()(const ReportTable& table) {
    text += escape_markdown(table.caption) + (table.caption.ends_with('.') ? "" : ":") + "\n\n|";
    for (const auto& column : table.columns) text += " " + escape_markdown(column.name) + " |";
    text += "\n|";
    for (const auto& column : table.columns) text += column.words ? ":---|" : "---:|";
    text += "\n";
    for (const auto& row : table.rows) {
      text += "|";
      for (const auto& cell : row) text += " " + escape_markdown(cell.text) + " |";
      text += "\n";
    }
    text += "\n";
  }

  void operator()(const ReportFigure& figure) {
    // Words only: the drawing is in the page.
    text += "Drawing in the HTML report: " + escape_markdown(figure.caption);
    if (!figure.layers.empty()) {
      text += " " + escape_markdown(figure.legend) + ":";
      for (const auto& layer : figure.layers)
        text += " " + escape_markdown(layer) + (&layer == &figure.layers.back() ? "." : ",");
    }
    text += "\n\n";
  }
};

}  // namespace

std::string to_markdown(const ReportDocument& document) {
  MarkdownWriter writer;
  writer.text = fmt::format("# {}\n\n{}\n\n**{}.** {}\n\n", escape_markdown(document.title),
                            escape_markdown(document.subtitle), escape_markdown(document.grade),
                            escape_markdown(document.sentence));
  for (const auto& section : document.sections) {
    writer.text += "## " + escape_markdown(section.title) + "\n\n";
    for (const auto& block : section.blocks) std::visit(writer, block);
  }
  while (writer.text.size() > 1 && writer.text[writer.text.size() - 2] == '\n') writer.text.pop_back();
  return writer.text;
}

std::string report_markdown(const ReportInput& input) { return to_markdown(report_document(input)); }

}  // namespace octant::survey
