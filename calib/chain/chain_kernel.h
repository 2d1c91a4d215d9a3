// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace octant::calib {

/// Columns of a border are padded to a multiple of this.
inline constexpr std::size_t kBorderPad = 8;

/// Some states of a chain that follow each other, with a border of columns that all of them couple to. All
/// arrays are row by row.
struct ChainWindow {
  int block = 3;           ///< unknowns of a state: 3, 4, 6 or 7
  std::size_t states = 0;  ///< to be eliminated; one more follows them
  std::size_t width = 0;   ///< width of the border, a multiple of kBorderPad
  double* D = nullptr;     ///< (states + 1) x block x block: diagonal blocks, both triangles
  double* U = nullptr;     ///< states x block x block: coupling to the next state
  double* G = nullptr;     ///< (states + 1) x block x width: coupling to the border
  double* H = nullptr;     ///< width x width: the border's own; only the lower triangle is meant
  /// For each state, true if no column of the border except `gradient` couples to it; null: unknown. The
  /// first state never counts as such.
  const char* is_plain = nullptr;
  std::size_t gradient = 0;
};

/// Eliminates the states front to back: with D = L L', W = L^-1 U, Y = L^-1 G of each,
///   D_next -= W'W,   G_next -= W'Y,   H -= Y'Y
/// (Schur complement of a bordered block-tridiagonal matrix). D and G of the next state have the result; D, U
/// and G of the others are overwritten. States that do not couple to the border (odometry more often than
/// arrivals) are eliminated before the others, onto their neighbours.
/// @param floor  share of its largest element by which a diagonal grows before it is factored; if it is not
/// positive definite, 100 times `spare_floor` is added
void eliminate(const ChainWindow& window, double floor_of_last, double spare_floor);

}  // namespace octant::calib
