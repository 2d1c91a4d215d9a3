// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <fast_float/fast_float.h>
#include <fmt/format.h>

namespace octant::io {
namespace {

constexpr std::size_t kShown = 40;        // characters of a value that a message repeats
constexpr std::size_t kLongestName = 64;  // beyond it nobody has mistyped a name

/// Levenshtein's distance, neighbouring letters exchanged counting once.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

/// Length of the UTF-8 sequence at p; 0 if it is invalid (Unicode 15, table 3-7).
std::size_t sequence_length(const unsigned char* p, std::size_t left) {
  const auto tail = [&](std::size_t i, unsigned char low = 0x80, unsigned char high = 0xBF) {
    return i < left && p[i] >= low && p[i] <= high;
  };
  const unsigned char c = p[0];
  if (c < 0x80) return c == 0 ? 0 : 1;
  if (c >= 0xC2 && c <= 0xDF) return tail(1) ? 2 : 0;
  if (c == 0xE0) return tail(1, 0xA0) && tail(2) ? 3 : 0;
  if (c == 0xED) return tail(1, 0x80, 0x9F) && tail(2) ? 3 : 0;
  if (c >= 0xE1 && c <= 0xEF) return tail(1) && tail(2) ? 3 : 0;
  if (c == 0xF0) return tail(1, 0x90) && tail(2) && tail(3) ? 4 : 0;
  if (c >= 0xF1 && c <= 0xF3) return tail(1) && tail(2) && tail(3) ? 4 : 0;
  if (c == 0xF4) return tail(1, 0x80, 0x8F) && tail(2) && tail(3) ? 4 : 0;
  return 0;
}

/// Bytes at the beginning that are ASCII and not NUL, in whole blocks: the compiler makes vectors of it.
std::size_t plain_blocks(std::string_view text) {
  constexpr std::size_t kWords = 16;
  std::array<std::uint64_t, kWords> words;
  std::size_t i = 0;
  for (; i + sizeof words <= text.size(); i += sizeof words) {
    std::memcpy(words.data(), text.data() + i, sizeof words);
    std::uint64_t odd = 0;
    for (const std::uint64_t word : words) odd |= word | (word - 0x0101010101010101ULL);
    if ((odd & 0x8080808080808080ULL) != 0) break;
  }
  return i;
}

/// Offset of the first byte that is not UTF-8 text, or the size of the text. Eight ASCII bytes at a time.
std::size_t find_invalid(std::string_view text) {
  const auto* p = reinterpret_cast<const unsigned char*>(text.data());
  std::size_t i = plain_blocks(text);
  while (i < text.size()) {
    if (i + 8 <= text.size()) {
      std::uint64_t word = 0;
      std::memcpy(&word, p + i, 8);
      // High bit anywhere, or a zero byte (no borrow can come from a byte without high bit that is not zero).
      if (((word | (word - 0x0101010101010101ULL)) & 0x8080808080808080ULL) == 0) {
        i += 8;
        continue;
      }
    }
    const std::size_t length = sequence_length(p + i, text.size() - i);
    if (length == 0) return i;
    i += length;
  }
  return text.size();
}

}  // namespace

std::string in_quotes(std::string_view text) {
  std::string shown(text.substr(0, kShown));
  // Do not cut a character in two.
  if (text.size() > kShown) {
    while (!shown.empty() && (static_cast<unsigned char>(text[shown.size()]) & 0xC0) == 0x80)
      shown.pop_back();
  }
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return text.size() > kShown ? fmt::format("'{}...' ({} characters)", shown, text.size())
                              : fmt::format("'{}'", shown);
}

std::string listed(const std::vector<std::string>& items, std::size_t most) {
  std::string out;
  for (std::size_t i = 0; i < std::min(items.size(), most); ++i) {
    const std::string shown = in_quotes(items[i]);
    if (i > 0) out += ", ";
    out += items[i].size() > kShown ? shown : shown.substr(1, shown.size() - 2);
  }
  if (items.size() > most) out += fmt::format(", ... ({} in all)", items.size());
  return out;
}

std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  if (candidates.empty()) return "";
  std::vector<std::pair<std::size_t, std::string>> close;
  if (name.size() <= kLongestName) {
    const std::string wanted = lower_case(name);
    const std::size_t limit = std::max<std::size_t>(1, name.size() / 3);
    for (const std::string& candidate : candidates) {
      if (candidate.size() > kLongestName) continue;
      const std::string have = lower_case(candidate);
      std::size_t distance = edit_distance(wanted, have);
      // A name that lacks its unit, or that has a wrong one behind it.
      if (wanted.size() >= 3 && (have.starts_with(wanted) || wanted.starts_with(have + "_")))
        distance = std::min<std::size_t>(distance, 1);
      if (distance <= limit && distance < have.size()) close.emplace_back(distance, candidate);
    }
  }
  if (close.empty()) return "known: " + listed(candidates);
  std::ranges::stable_sort(close, [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string out = "did you mean ";
  for (std::size_t i = 0; i < std::min<std::size_t>(3, close.size()) && close[i].first == close[0].first;
       ++i) {
    if (i > 0) out += " or ";
    out += in_quotes(close[i].second);
  }
  return out += "?";
}

std::string_view without_blanks(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string csv_field(std::string_view text) {
  const bool plain = text.find_first_of(",\"\n\r#") == std::string_view::npos && !text.empty() &&
                     text.front() != ' ' && text.back() != ' ';
  if (plain || text.empty()) return std::string(text);
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out += '"';
}

std::string exact(double value) { return fmt::format("{}", value); }

std::string number_field(double value) { return std::isfinite(value) ? exact(value) : ""; }

NumberText parse_number(std::string_view text, double& value) {
  if (text.empty()) return NumberText::kEmpty;
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (*begin == '+' && text.size() > 1 && begin[1] != '-') ++begin;
  const auto [stop, status] = fast_float::from_chars(begin, end, value);
  if (status == std::errc::result_out_of_range && stop == end)
    return NumberText::kNumber;  // infinity or zero
  return status == std::errc() && stop == end ? NumberText::kNumber : NumberText::kNotNumber;
}

bool parse_integer(std::string_view text, std::int64_t& value) {
  // Digits alone are the rule; the general way costs three times as much.
  if (!text.empty() && text.size() <= 18 && text[0] >= '0' && text[0] <= '9') {
    std::int64_t sum = 0;
    std::size_t i = 0;
    for (; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i) sum = 10 * sum + (text[i] - '0');
    if (i == text.size()) {
      value = sum;
      return true;
    }
  }
  double number = 0.0;
  constexpr double kExact = 9007199254740992.0;  // 2^53: whole numbers beyond it are not exact
  if (parse_number(text, number) != NumberText::kNumber || number != std::floor(number) ||
      std::abs(number) > kExact)
    return false;
  value = static_cast<std::int64_t>(number);
  return true;
}

TextPosition position_of(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const std::size_t newline = before.rfind('\n');
  return {static_cast<int>(1 + std::ranges::count(before, '\n')),
          static_cast<int>(1 + before.size() - (newline == std::string_view::npos ? 0 : newline + 1))};
}

std::string_view without_bom(std::string_view text) {
  return text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
}

bool is_utf8(std::string_view text) { return find_invalid(text) == text.size(); }

Result<void> check_utf8(std::string_view text, const std::string& file) {
  const std::size_t offset = find_invalid(text);
  if (offset == text.size()) return {};
  const TextPosition at = position_of(text, offset);
  const bool utf16 = text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF");
  const auto byte = static_cast<unsigned char>(text[offset]);
  return fail({.file = file,
               .line = at.line,
               .column = at.column,
               .found = utf16 ? "the file is UTF-16" : fmt::format("byte 0x{:02X} is not UTF-8 text", byte),
               .expected = "UTF-8 text",
               .advice = utf16         ? "save it as UTF-8"
                         : byte < 0x80 ? "this looks like a binary or a damaged file"
                                       : "a spreadsheet writes it as 'CSV UTF-8'; or this is a binary or a "
                                         "damaged file"});
}

}  // namespace octant::io
