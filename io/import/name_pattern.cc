// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/name_pattern.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr std::size_t kMostStars = 8, kLongestPattern = 1024;

/// Backtracking that never tries the same pair of positions twice; its time is proportional to pattern times
/// text.
class PatternMatch {
 public:
  PatternMatch(std::string_view pattern, std::string_view text, PatternNames& names)
      : pattern_(pattern), text_(text), names_(names), failed_((pattern.size() + 1) * (text.size() + 1)) {}

  bool from(std::size_t p, std::size_t t) {
    if (p == pattern_.size()) return t == text_.size();
    const std::size_t place = p * (text_.size() + 1) + t;
    if (failed_[place]) return false;
    const bool matched = pattern_[p] == '*' ? star(p, t) : pattern_[p] == '{' ? name(p, t) : letter(p, t);
    failed_[place] = !matched;
    return matched;
  }

 private:
  bool star(std::size_t p, std::size_t t) { return from(p + 1, t) || (t < text_.size() && from(p, t + 1)); }
  bool letter(std::size_t p, std::size_t t) {
    return t < text_.size() && pattern_[p] == text_[t] && from(p + 1, t + 1);
  }
  /// The shortest name that lets the rest match.
  bool name(std::size_t p, std::size_t t) {
    const std::size_t close = pattern_.find('}', p);
    for (std::size_t end = t + 1;
         close != std::string_view::npos && end <= text_.size() && text_[end - 1] != '/'; ++end)
      if (from(close + 1, end)) {
        names_[std::string(pattern_.substr(p + 1, close - p - 1))] = text_.substr(t, end - t);
        return true;
      }
    return false;
  }

  std::string_view pattern_, text_;
  PatternNames& names_;
  std::vector<bool> failed_;
};

}  // namespace

std::string fault_of_pattern(std::string_view pattern) {
  if (static_cast<std::size_t>(std::ranges::count_if(pattern, [](char c) { return c == '*' || c == '{'; })) >
      kMostStars)
    return fmt::format("more than {} of * and {{...}}", kMostStars);
  if (pattern.size() > kLongestPattern) return fmt::format("a pattern of {} bytes", pattern.size());
  while (!pattern.empty()) {
    const std::size_t open = pattern.find('{');
    if (open == std::string_view::npos) return "";
    const std::size_t close = pattern.find('}', open);
    const std::string_view name =
        close == std::string_view::npos ? "" : pattern.substr(open + 1, close - open - 1);
    if (name != "beacon" && name != "receiver" && name != "vehicle")
      return fmt::format("{} where a name is to stand", in_quotes(pattern.substr(open)));
    pattern.remove_prefix(close + 1);
  }
  return "";
}

bool matches(std::string_view pattern, std::string_view text, PatternNames& names) {
  return PatternMatch(pattern, text, names).from(0, 0);
}

}  // namespace octant::io
