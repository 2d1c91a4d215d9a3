// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/bounds.h"

#include <algorithm>

#include <fmt/format.h>

#include "io/text/open_file.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr std::size_t kWindow = std::size_t{1} << 20;

/// Follows quotes and brackets through a JSON text that comes in pieces.
class JsonWatch {
 public:
  /// Offset of the first excess in the piece; the size of the piece if there is no excess.
  std::size_t add(std::string_view piece) {
    std::size_t i = 0;
    for (; i < piece.size() && within(); ++i) {
      const char c = piece[i];
      if (in_text_) {
        in_text_ = escaped_ || c != '"';
        escaped_ = !escaped_ && c == '\\';
        ++text_;
        continue;
      }
      in_text_ = c == '"';
      if (in_text_) text_ = 0;
      if (c == '{' || c == '[') ++depth_;
      if ((c == '}' || c == ']') && depth_ > 0) --depth_;
      members_ += static_cast<std::size_t>(c == '{' || c == '[' || c == '"');
      values_ += static_cast<std::size_t>(c == ',');
    }
    return within() ? piece.size() : i - 1;
  }
  [[nodiscard]] bool within() const {
    return depth_ <= kDeepestJson && text_ <= kLongestJsonText && members_ <= kMostJsonMembers &&
           values_ <= kMostJsonValues;
  }
  [[nodiscard]] std::string found() const {
    if (depth_ > kDeepestJson) return fmt::format("brackets {} levels deep", depth_);
    if (text_ > kLongestJsonText) return fmt::format("a text of more than {} MB", kLongestJsonText >> 20U);
    return values_ > kMostJsonValues ? fmt::format("more than {} values", kMostJsonValues)
                                     : fmt::format("more than {} texts, lists and objects", kMostJsonMembers);
  }

 private:
  bool in_text_ = false, escaped_ = false;
  std::size_t depth_ = 0, text_ = 0, members_ = 0, values_ = 0;
};

Error beyond(const JsonWatch& watch, std::string_view text, std::size_t at, const std::string& file) {
  const TextPosition place = position_of(text, at);
  return {.file = file,
          .line = place.line,
          .column = place.column,
          .found = watch.found(),
          .expected = "a document that octant wrote",
          .advice = "the file was not written by octant, or was altered"};
}

}  // namespace

Result<void> check_lines(std::string_view text, const std::string& file) {
  int line = 1;
  std::size_t begin = 0;
  while (begin < text.size()) {
    // Whole lines, some at once: a window that ends with one.
    const std::string_view window = text.substr(begin, kWindow);
    std::size_t size = window.size();
    if (begin + size < text.size()) {
      const std::size_t last = window.rfind('\n');
      const bool none = last == std::string_view::npos;
      size = none ? std::min(kLongestLine + 1, text.size() - begin) : last + 1;
      if (none && is_utf8(window.substr(0, window.size() - 4)))
        return fail({.file = file,
                     .line = line,
                     .found = fmt::format("a line of more than {} bytes", kLongestLine),
                     .expected = "lines of some hundreds",
                     .advice = "the file is of another kind, or has lost its newlines"});
    }
    const std::string_view lines = text.substr(begin, size);
    if (!is_utf8(lines)) {
      auto error = check_utf8(lines, file).error();
      error.line += line - 1;
      return fail(error);
    }
    line += static_cast<int>(std::ranges::count(lines, '\n'));
    begin += size;
  }
  return {};
}

Result<void> check_json(std::string_view text, const std::string& file) {
  JsonWatch watch;
  const std::size_t at = watch.add(text);
  return watch.within() ? Result<void>() : fail(beyond(watch, text, at, file));
}

Result<std::string> read_document(const std::string& path) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  const std::string_view text = map->text();
  const std::string_view head = without_bom(text.substr(0, kWindow));
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || head[first] != '{') {
    if (text.size() <= kLargestYaml) return std::string(text);
    return fail({.file = path,
                 .found = fmt::format("{} bytes that do not begin like JSON", text.size()),
                 .expected = fmt::format("a text of at most {} MB", kLargestYaml >> 20U)});
  }
  JsonWatch watch;
  for (std::size_t begin = 0; begin < text.size(); begin += kWindow) {
    const std::string_view piece = text.substr(begin, kWindow);
    const std::size_t at = watch.add(piece);
    if (!watch.within()) return fail(beyond(watch, text, begin + at, path));
    if (piece.find('\0') != std::string_view::npos)
      return fail(check_utf8(text.substr(0, begin + piece.size()), path).error());
    map->release(begin, begin + piece.size());
  }
  return std::string(text);
}

}  // namespace octant::io
