// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/report_html.h"

#include <algorithm>

#include <fmt/format.h>

#include "models/support/enum_names.h"
#include "survey/drawing/escape.h"
#include "survey/drawing/plotly_js.h"
#include "survey/page/report_style.h"
#include "survey/report/report.h"

namespace octant::survey {
namespace {

const char* class_of(Tone tone) {
  static constexpr auto kNames = enum_names<Tone>("plain", "good", "attention", "bad");
  return kNames[tone];
}

/// Ids come from the program and from names of quantities, so only blanks must be replaced.
std::string id_of(std::string id) {
  std::ranges::replace(id, ' ', '-');
  return escape_xml(id);
}

/// Escaped text in which no line breaks between a number and its unit.
std::string running(const std::string& text) {
  static constexpr std::string_view kUnits[] = {"mm", "m",   "m/s",  "s",   "ms", "µs",   "us", "ns",
                                                "%",  "deg", "degC", "rad", "V",  "Np/m", "Hz", "sigma"};
  const std::string safe = escape_xml(text);
  std::string out;
  for (std::size_t i = 0; i < safe.size(); ++i) {
    const bool after_number = safe[i] == ' ' && i > 0 && safe[i - 1] >= '0' && safe[i - 1] <= '9';
    std::size_t end = i + 1;
    while (after_number && end < safe.size() &&
           std::string_view(" ,;.)(").find(safe[end]) == std::string_view::npos)
      ++end;
    const std::string_view word = std::string_view(safe).substr(i + 1, end - i - 1);
    if (after_number && std::ranges::find(kUnits, word) != std::end(kUnits))
      out += "&#160;";
    else
      out += safe[i];
  }
  return out;
}

/// Colour is never the only sign: a failed gate also has a mark.
std::string marked(const ReportText& cell) {
  const char* mark = cell.tone == Tone::kGood ? "&#10003; " : cell.tone == Tone::kBad ? "&#10007; " : "";
  return mark + running(cell.text);
}

/// Text within quotes of a style sheet: no character ends the quotes or the sheet.
std::string css_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'' || c == '"' || c == '\\' || c == '<' || c == '>' || static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\{:x} ", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out;
}

/// On a phone, a table with at least this many columns becomes a card for each row, with the name of the
/// column next to each value.
constexpr std::size_t kWideTable = 7;

class HtmlWriter {
 public:
  HtmlWriter(bool live, bool explained) : live_(live), explained_(explained) {}
  std::string html;

  void operator()(const ReportText& text) {
    html += fmt::format("<p class='{}'>{}</p>\n", class_of(text.tone), running(text.text));
  }

  void operator()(const ReportList& list) {
    html += list.numbered ? "<ol>\n" : "<ul>\n";
    for (const auto& item : list.items) html += "<li>" + running(item) + "</li>\n";
    html += list.numbered ? "</ol>\n" : "</ul>\n";
  }

  void operator()(const ReportTable& table) {
    const std::string id = id_of(table.id);
    if (table.folded) html += "<details><summary>" + escape_xml(table.caption) + " as a table</summary>\n";
    const bool wide = table.columns.size() >= kWideTable;
    html += fmt::format(
        "<div class='scroll' tabindex='0' role='region' aria-labelledby='caption-{0}'><table "
        "id='{0}'{3}>\n<caption id='caption-{0}'>{1}{2}</caption>\n"
        "<thead><tr>",
        id, escape_xml(table.caption),
        explained_ && table.columns.size() > 2 ? " <a class='words-link' href='#words'>Words</a>" : "",
        wide ? " class='wide'" : "");
    for (const auto& column : table.columns)
      html += fmt::format("<th scope='col'{}>{}</th>", column.words ? " class='words'" : "",
                          escape_xml(column.name));
    html += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) write_row(table, row);
    html += "</tbody></table></div>\n";
    if (wide) write_labels(table, id);
    if (table.folded) html += "</details>\n";
  }

  void operator()(const ReportFigure& figure) {
    const std::string id = id_of(figure.id);
    html += "<div class='drawing' id='drawing-" + id + "'>\n";
    if (!figure.layers.empty()) write_choice(figure, id);
    const bool live = live_ && !figure.interactive.empty();
    html += fmt::format(
        "<figure id='{}'{}>\n<div class='still scroll' tabindex='0' role='region' aria-label='drawing, may "
        "be scrolled'>{}</div>\n",
        id, live ? " data-live='1'" : "", figure.svg);
    if (live)
      html +=
          fmt::format("<div class='live'></div>\n<script type='application/json' id='data-{}'>{}</script>\n",
                      id, figure.interactive);
    html += "<figcaption>" + escape_xml(figure.caption) + "</figcaption>\n</figure>\n</div>\n";
  }

 private:
  /// Once for each column, not in each cell: tables of hundreds of beacons stay small.
  void write_labels(const ReportTable& table, const std::string& id) {
    html += "<style>@media screen and (max-width:640px){";
    for (std::size_t i = 1; i < table.columns.size(); ++i)
      html += fmt::format("#{} td:nth-child({})::before{{content:'{}'}}", id, i + 1,
                          css_text(table.columns[i].name));
    html += "}</style>\n";
  }

  void write_row(const ReportTable& table, const std::vector<ReportText>& row) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool words = i < table.columns.size() && table.columns[i].words;
      if (i == 0)
        html += "<th scope='row'>" + escape_xml(row[0].text) + "</th>";
      else if (row[i].tone == Tone::kPlain)
        html += fmt::format("<td{}>{}</td>", words ? " class='words'" : "", running(row[i].text));
      else
        html += fmt::format("<td class='{}{}'>{}</td>", words ? "words " : "", class_of(row[i].tone),
                            marked(row[i]));
    }
    html += "</tr>\n";
  }

  /// Radio buttons that choose a layer of the drawing by style alone: it works without a script.
  void write_choice(const ReportFigure& figure, const std::string& id) {
    std::string style = fmt::format("#drawing-{} .layer{{display:none}}", id);
    html += "<fieldset><legend>" + escape_xml(figure.legend) + "</legend>\n";
    for (std::size_t k = 0; k < figure.layers.size(); ++k) {
      html += fmt::format(
          "<span><input type='radio' name='choice-{0}' id='choice-{0}-{1}' value='{1}'{2}> <label "
          "for='choice-{0}-{1}'>{3}</label></span>\n",
          id, k, k == 0 ? " checked" : "", escape_xml(figure.layers[k]));
      style += fmt::format("#drawing-{0}:has(#choice-{0}-{1}:checked) .layer-{1}{{display:block}}", id, k);
    }
    html += "</fieldset>\n<style>" + style + "</style>\n";
  }

  bool live_;
  bool explained_;  ///< the page has a section of words
};

}  // namespace

std::string page_head(const std::string& title, const std::string& more_style, bool scripts) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
      "<meta http-equiv='Content-Security-Policy' content=\"default-src 'none'; style-src 'unsafe-inline'; "
      "img-src data:{}\">\n"
      "<meta name='viewport' content='width=device-width, initial-scale=1'>\n<meta name='referrer' "
      "content='no-referrer'>\n"
      "<title>{}</title>\n<style>\n{}{}</style>\n</head>\n<body>\n",
      scripts ? "; script-src 'unsafe-inline'" : "", escape_xml(title), page_style(), more_style);
}

std::string to_html(const ReportDocument& document, std::string_view plotly) {
  const bool explained = std::ranges::any_of(
      document.sections, [](const ReportSection& section) { return section.id == "words"; });
  HtmlWriter writer(!plotly.empty(), explained);
  std::string& html = writer.html;
  html = page_head(document.title + " – " + document.subtitle, "", !plotly.empty());
  html += "<a class='skip' href='#main'>Skip to the content</a>\n<header>\n";
  html += fmt::format("<h1>{}</h1>\n<p class='soft'>{}</p>\n", escape_xml(document.title),
                      escape_xml(document.subtitle));
  html += fmt::format("<p class='verdict {}' id='sentence'><strong>{}</strong> {}</p>\n",
                      class_of(document.tone), escape_xml(document.grade), running(document.sentence));
  html += "<nav aria-label='Contents'><ul>\n";
  for (const auto& section : document.sections)
    html += fmt::format("<li><a href='#{}'>{}</a></li>\n", id_of(section.id), escape_xml(section.title));
  html += "</ul></nav>\n";
  if (!plotly.empty())
    html +=
        "<p class='controls soft' hidden><label><input type='checkbox' id='all-live' checked> figures to "
        "point at, zoom and turn</label></p>\n";
  html += "</header>\n<main id='main' tabindex='-1'>\n";
  for (const auto& section : document.sections) {
    html += fmt::format("<section aria-labelledby='{0}'>\n<h2 id='{0}'>{1}</h2>\n", id_of(section.id),
                        escape_xml(section.title));
    for (const auto& block : section.blocks) std::visit(writer, block);
    html += "</section>\n";
  }
  html +=
      "</main>\n<footer>Made by Octant. Nothing on this page comes from elsewhere, and nothing leaves it.";
  if (!plotly.empty()) {
    html += fmt::format(
        " Figures by plotly.js {} (Copyright 2012-2021 Plotly, Inc., MIT licence), which is part of this "
        "page.",
        plotly_js_version());
  }
  html += "</footer>\n";
  if (!plotly.empty())
    html += fmt::format("<script type='text/plain' id='plotly-js'>{}</script>\n<script>\n{}</script>\n",
                        plotly, page_script());
  return html + "</body>\n</html>\n";
}

std::string report_html(const ReportInput& input, const ReportOptions& options) {
  return to_html(report_document(input), options.interactive ? plotly_js() : std::string_view{});
}

}  // namespace octant::survey
