// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/yaml/yaml_text.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace octant::io {
namespace {

bool is_plain_scalar(std::string_view text) {
  double value = 0.0;
  if (text.empty() || !std::isalpha(static_cast<unsigned char>(text[0])) ||
      parse_number(text, value) == NumberText::kNumber)
    return false;
  if (!std::ranges::all_of(
          text, [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-' || c == '.'; })) {
    return false;
  }
  constexpr std::string_view kWords[] = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"};
  return std::ranges::find(kWords, lower_case(text)) == std::end(kWords);
}

/// Characters beyond ASCII that YAML takes for the end of a line, or does not allow as they are
/// (YAML 1.1, 5.1 and 5.4), with what stands for them in double quotes.
struct OddCharacter {
  std::string_view bytes, escape;
};
constexpr OddCharacter kOdd[] = {{"\xE2\x80\xA8", "\\u2028"},
                                 {"\xE2\x80\xA9", "\\u2029"},
                                 {"\xEF\xBB\xBF", "\\uFEFF"},
                                 {"\xEF\xBF\xBE", "\\uFFFE"},
                                 {"\xEF\xBF\xBF", "\\uFFFF"}};

/// The escape of the character that a text begins with, and how many bytes it takes; 0: it may stand as it
/// is.
std::size_t escape_odd(std::string_view text, std::string& out) {
  // C1 control characters, U+0080 to U+009F.
  if (text.size() >= 2 && text[0] == '\xC2' && static_cast<unsigned char>(text[1]) < 0xA0) {
    out += fmt::format("\\x{:02X}", static_cast<unsigned char>(text[1]));
    return 2;
  }
  for (const OddCharacter& odd : kOdd)
    if (text.starts_with(odd.bytes)) {
      out += odd.escape;
      return odd.bytes.size();
    }
  return 0;
}

}  // namespace

std::string yaml_text(std::string_view text) {
  if (is_plain_scalar(text)) return std::string(text);
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      out += fmt::format("\\x{:02X}", static_cast<unsigned char>(c));
    } else if (const std::size_t bytes = escape_odd(text.substr(i), out); bytes > 0) {
      i += bytes - 1;
    } else {
      out += c;
    }
  }
  return out + "\"";
}

}  // namespace octant::io
