// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace octant::test {

/// A function that a source defines.
struct FunctionShape {
  std::string head;  ///< from its first token to the brace, white space folded
  int first_line = 0, last_line = 0;
  int data_lines = 0;  ///< number of these inside raw string literals
  [[nodiscard]] int lines() const { return last_line - first_line + 1 - data_lines; }
};

/// Functions of C++ text. Lambdas count as part of the enclosing function. A function is recognised by braces
/// and the parentheses before them, so the text must be formatted by clang-format and without macros that
/// contain braces.
[[nodiscard]] std::vector<FunctionShape> functions_of(std::string_view text);

/// Lines of a text.
[[nodiscard]] int lines_of(std::string_view text);

}  // namespace octant::test
