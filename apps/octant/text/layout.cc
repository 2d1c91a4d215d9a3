// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/layout.h"

#include <algorithm>

#include <fmt/format.h>

namespace octant::app {

std::size_t columns_of(std::string_view text) {
  // Counts the bytes that begin a UTF-8 character.
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string paragraph(std::string_view text, std::size_t columns, std::size_t indent, std::size_t used) {
  std::string out;
  std::size_t at = used;
  bool fresh = true;  // the current line is still empty
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of(" \n"), text.size());
    const std::string_view word = text.substr(0, end);
    const bool line_ends = end < text.size() && text[end] == '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!word.empty()) {
      const std::size_t width = columns_of(word);
      if (!fresh && at + 1 + width > columns) {
        out += "\n" + std::string(indent, ' ');
        at = indent;
        fresh = true;
      }
      if (!fresh) out += ' ';
      out += word;
      at += width + (fresh ? 0 : 1);
      fresh = false;
    }
    if (line_ends && !text.empty()) {
      out += "\n" + std::string(indent, ' ');
      at = indent;
      fresh = true;
    }
  }
  return out + "\n";
}

std::string named_line(std::string_view name, std::string_view what) {
  constexpr std::size_t kName = 17;
  return fmt::format("{:<{}}", name, kName) + paragraph(what, kTextColumns, kName, kName);
}

std::string Table::text() const {
  std::vector<std::size_t> widths(align.size(), 0);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i)
      widths[i] = std::max(widths[i], columns_of(row[i]));
  std::string out;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i) {
      const std::string pad(widths[i] - columns_of(row[i]), ' ');
      line += align[i] == 'r' ? pad + row[i] : row[i] + pad;
      line += "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace octant::app
