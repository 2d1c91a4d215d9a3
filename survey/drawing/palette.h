// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace octant::survey {

/// Colours inside the tolerance (three), near it, beyond it (three). Darker is worse, for readers who do not
/// see red.
inline constexpr std::array<const char*, 7> kToleranceColours = {"#d9f0d3", "#b2dfa5", "#8cc97d", "#f6b53c",
                                                                 "#e8713c", "#bf2f2f", "#6b0f1a"};
/// Ends of these classes, as fractions of the tolerance.
inline constexpr std::array<double, 6> kToleranceParts = {0.25, 0.5, 0.75, 1.0, 1.5, 2.0};
/// Cividis (Nunez, Anderton, Renslow 2018): the same to all kinds of colour vision, and ascending in grey.
/// Low values are dark.
inline constexpr std::array<const char*, 7> kMapColours = {"#00204d", "#31446b", "#555b6c", "#7b7a77",
                                                           "#a59c74", "#d3c064", "#ffe945"};

/// @param colour  as above: "#rrggbb"  @return red, green, blue
[[nodiscard]] constexpr std::array<std::uint8_t, 3> rgb_of(const char* colour) {
  const auto digit = [&](std::size_t i) { return colour[i] <= '9' ? colour[i] - '0' : colour[i] - 'a' + 10; };
  return {static_cast<std::uint8_t>(16 * digit(1) + digit(2)),
          static_cast<std::uint8_t>(16 * digit(3) + digit(4)),
          static_cast<std::uint8_t>(16 * digit(5) + digit(6))};
}

}  // namespace octant::survey
