// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/result.h"

namespace octant {

std::string Error::message() const {
  std::string text = file;
  if (line > 0) text.append(":").append(std::to_string(line));
  if (line > 0 && column > 0) text.append(":").append(std::to_string(column));
  if (!text.empty()) text += ": ";
  text += found;
  if (!expected.empty()) text += "; expected " + expected;
  if (!advice.empty()) text += "; " + advice;
  return text;
}

}  // namespace octant
