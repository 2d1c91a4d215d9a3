// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/escape.h"

namespace octant::survey {
namespace {

/// Position of the character to escape if the beginning of a line would be a list item or a rule in Markdown;
/// npos if no character needs it.
std::size_t markdown_mark(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos) return begin;
  const std::size_t at = text.find_first_not_of("0123456789", begin);
  if (at == std::string::npos) return at;
  const std::string marks = at > begin ? ".)" : "-+";
  if (marks.find(text[at]) == std::string::npos) return std::string::npos;
  const bool item = at + 1 < text.size() && std::string(" \t\r\n").find(text[at + 1]) != std::string::npos;
  const bool rule =
      text.compare(at, 3, "---") == 0 && text.find_first_not_of("- \t\r\n", at) == std::string::npos;
  return item || rule ? at : std::string::npos;
}

/// Replaces characters that begin markup by entities.
void append_markup(char c, std::string& safe) {
  switch (c) {
    case '&': safe += "&amp;"; break;
    case '<': safe += "&lt;"; break;
    case '>': safe += "&gt;"; break;
    default: safe += c;
  }
}

}  // namespace

std::string escape_xml(const std::string& text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
      case '<':
      case '>': append_markup(c, safe); break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default:
        // Control characters are not allowed in XML at all, not even escaped.
        safe += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  }
  return safe;
}

std::string escape_markup(const std::string& text) {
  std::string safe;
  for (const char c : text) append_markup(c, safe);
  return safe;
}

std::string escape_markdown(const std::string& text) {
  std::string safe;
  safe.reserve(text.size());
  const std::size_t mark = markdown_mark(text);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (i == mark) safe += '\\';
    // HTML in Markdown is interpreted, so its characters become entities; other characters are escaped for
    // Markdown.
    if (c == '&' || c == '<' || c == '>')
      append_markup(c, safe);
    else if (c == '\n' || c == '\r')
      safe += ' ';
    else if (std::string("\\`*_[]|~#").find(c) != std::string::npos)
      safe += std::string("\\") + c;
    else
      safe += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return safe;
}

std::string escape_script_json(const std::string& json) {
  // These characters occur only inside JSON strings, where an escape has the same meaning.
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    switch (c) {
      case '<': safe += "\\u003c"; break;
      case '>': safe += "\\u003e"; break;
      case '&': safe += "\\u0026"; break;
      default: safe += c;
    }
  }
  return safe;
}

}  // namespace octant::survey
