// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include <fmt/format.h>

#include "apps/octant/session.h"
#include "apps/octant/text/layout.h"

namespace octant::app {

/// Kinds of bad lines and their counts. The number of kinds is limited, so that bad input does not fill the
/// memory.
class BadLines {
 public:
  void add(const std::string& what, std::size_t line, Session& session) {
    ++total_;
    const bool known = kinds_.contains(what);
    ++kinds_[known || kinds_.size() < kMostKinds ? what : "others"];
    if (!known && kinds_.size() < kMostKinds) session.note(fmt::format("line {}: {}", line, what));
  }
  [[nodiscard]] std::size_t total() const { return total_; }
  [[nodiscard]] const std::map<std::string, std::size_t>& kinds() const { return kinds_; }
  [[nodiscard]] std::string text() const { return counts_in_words(kinds_); }

 private:
  static constexpr std::size_t kMostKinds = 20;
  std::size_t total_ = 0;
  std::map<std::string, std::size_t> kinds_;
};

}  // namespace octant::app
