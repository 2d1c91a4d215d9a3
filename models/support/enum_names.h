// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace octant {

/// Names of an enumeration whose values count from zero, in order.
template <class Enum, std::size_t N>
struct EnumNames {
  std::array<const char*, N> names;

  [[nodiscard]] constexpr const char* operator[](Enum value) const {
    return names[static_cast<std::size_t>(value)];
  }
  /// Returns the value with a given name.
  [[nodiscard]] constexpr std::optional<Enum> find(std::string_view name) const {
    for (std::size_t i = 0; i < N; ++i)
      if (name == names[i]) return static_cast<Enum>(i);
    return std::nullopt;
  }
};

template <class Enum, class... Names>
[[nodiscard]] constexpr EnumNames<Enum, sizeof...(Names)> enum_names(Names... names) {
  return {{names...}};
}

}  // namespace octant
