// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/source_shape.h"

#include <algorithm>
#include <cctype>
#include <regex>

namespace octant::test {
namespace {

/// Text with comments and literals replaced by spaces, line by line.
struct Plain {
  std::string code;
  std::vector<bool> data;  ///< for each line: it is inside a raw literal
};

std::size_t end_of_literal(std::string_view text, std::size_t at) {
  const char quote = text[at];
  for (++at; at < text.size() && text[at] != quote; ++at)
    if (text[at] == '\\') ++at;
  return std::min(at + 1, text.size());
}

std::size_t end_of_raw_literal(std::string_view text, std::size_t quote) {
  const std::size_t open = text.find('(', quote);
  std::string close = ")";
  close += text.substr(quote + 1, open - quote - 1);
  close += '"';
  const std::size_t end = text.find(close, open);
  return end == std::string_view::npos ? text.size() : end + close.size();
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Where what begins at `at` ends, if that is a comment, a literal or a directive; else `at`.
std::size_t end_of_no_code(std::string_view text, std::size_t at) {
  const bool line_begins = at == 0 || text[at - 1] == '\n';
  const std::string_view two = text.substr(at, 2);
  if (two == "//" || (line_begins && text[at] == '#')) {
    std::size_t end = text.find('\n', at);
    while (end != std::string_view::npos && text[end - 1] == '\\') end = text.find('\n', end + 1);
    return std::min(end, text.size());
  }
  if (two == "/*") return std::min(text.find("*/", at) + 2, text.size());
  if (two == "R\"" && (at == 0 || !is_word(text[at - 1]))) return end_of_raw_literal(text, at + 1);
  if (text[at] == '"') return end_of_literal(text, at);
  // A quote within a number parts its digits.
  if (text[at] == '\'' && (at == 0 || !is_word(text[at - 1]))) return end_of_literal(text, at);
  return at;
}

Plain plain(std::string_view text) {
  Plain p;
  p.data.push_back(false);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = end_of_no_code(text, at);
    if (end == at) {
      p.code += text[at];
      if (text[at++] == '\n') p.data.push_back(false);
      continue;
    }
    const bool raw = text.substr(at, 2) == "R\"";
    for (; at < end; ++at) {
      p.code += text[at] == '\n' ? '\n' : ' ';
      if (text[at] == '\n') p.data.push_back(raw);
    }
  }
  return p;
}

/// Text before a brace without the content of parentheses and angle brackets.
std::string outside_brackets(std::string_view head) {
  std::string outside;
  int depth = 0;
  for (std::size_t i = 0; i < head.size(); ++i) {
    const bool arrow = i > 0 && head[i - 1] == '-' && head[i] == '>';
    const bool opens = head[i] == '(' || head[i] == '<',
               closes = !arrow && (head[i] == ')' || head[i] == '>');
    if (depth == 0 || (closes && depth == 1)) outside += head[i];
    depth += opens - closes;
  }
  return outside;
}

/// Returns true if a brace after this text, in a namespace or a class, opens a function's body: there are
/// parameters, and it is neither a type (alignas has parentheses too) nor an initial value.
bool opens_function(std::string_view head) {
  if (head.find("operator") != std::string_view::npos) return true;
  const std::string outside = outside_brackets(head);
  static const std::regex type(R"(^(template ?<>)? ?(inline )?(namespace|extern|class|struct|union|enum)\b)");
  return outside.find('(') != std::string::npos && outside.find('=') == std::string::npos &&
         !std::regex_search(outside, type);
}

/// Replaces white space by single spaces, and removes it at the ends.
std::string folded(std::string_view text) {
  std::string out;
  for (const char c : text)
    if (std::isspace(static_cast<unsigned char>(c)) == 0)
      out += c;
    else if (!out.empty() && out.back() != ' ')
      out += ' ';
  if (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

std::size_t closing_brace(std::string_view code, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < code.size(); ++i) {
    depth += (code[i] == '{') - (code[i] == '}');
    if (depth == 0) return i;
  }
  return code.size();
}

}  // namespace

int lines_of(std::string_view text) { return static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

std::vector<FunctionShape> functions_of(std::string_view text) {
  const Plain p = plain(text);
  const std::string_view code = p.code;
  std::vector<FunctionShape> found;
  std::size_t head_from = 0;
  for (std::size_t i = 0; i < code.size(); ++i) {
    const char c = code[i];
    if (c == ':' && i > 0 &&
        std::regex_match(folded(code.substr(head_from, i - head_from)),
                         std::regex("public|private|protected")))
      head_from = i + 1;
    if (c == ';' || c == '}') head_from = i + 1;
    if (c != '{') continue;
    FunctionShape f;
    f.head = folded(code.substr(head_from, i - head_from));
    if (opens_function(f.head)) {
      const std::size_t begin = code.find_first_not_of(" \n", head_from), end = closing_brace(code, i);
      f.first_line = lines_of(code.substr(0, begin)) + 1;
      f.last_line = lines_of(code.substr(0, end)) + 1;
      f.data_lines =
          static_cast<int>(std::count(p.data.begin() + f.first_line - 1, p.data.begin() + f.last_line, true));
      found.push_back(std::move(f));
      i = end;
    }
    head_from = i + 1;
  }
  return found;
}

}  // namespace octant::test
