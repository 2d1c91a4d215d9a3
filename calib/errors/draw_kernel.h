// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace octant::calib {

/// Simulated values of one observation, one for each draw. Single precision is sufficient, because the result
/// is accurate to a tenth only, and twice as many draws are computed at a time.
inline constexpr std::size_t kDrawsAbreast = 16;
struct alignas(64) DrawLine {
  float of[kDrawsAbreast] = {};
};
/// One coordinate of a vehicle state for each draw; states of long chains are solved in double precision.
struct alignas(64) StateLine {
  double of[kDrawsAbreast] = {};
};

/// Derivatives of observations by states, row by row.
struct StateTaps {
  struct Tap {
    std::uint32_t state = 0;  ///< coordinate
    float by = 0.0F;
  };
  std::vector<std::uint32_t> first;  ///< start of each row, and the end
  std::vector<Tap> taps;
};

/// Chains of states after block-tridiagonal elimination: A = D - U'A_before^-1 U.
struct StateChains {
  struct Link {
    std::uint32_t first = 0;  ///< coordinate
    int size = 0;
    int next_size = 0;        ///< size of the next state; 0: the last one of the chain
    std::size_t inverse = 0;  ///< in blocks: A^-1, size x size by columns
    std::size_t onward = 0;   ///< in blocks: A^-1 U, size x next_size by columns
  };
  std::vector<Link> links;  ///< links of one chain after the other, front to back
  std::vector<double> blocks;
  std::uint32_t coordinates = 0;
};

/// e -= J x with x = (J'J)^-1 J'e: removes the part of errors that states absorb.
/// @param x  scratch memory
void subtract_states(const StateTaps& J, const StateChains& chains, std::vector<DrawLine>& e,
                     std::vector<StateLine>& x);

/// t += F'e  @param F  rows x rank by rows
void add_projection(const float* F, std::size_t rows, std::size_t rank, const DrawLine* e, DrawLine* t);
/// e -= F t
void subtract_product(const float* F, std::size_t rows, std::size_t rank, const DrawLine* t, DrawLine* e);

/// sums[cell[i]] += values[i]
void add_to_cells(const std::vector<std::int32_t>& cell, const DrawLine* values, DrawLine* sums);
/// squares += |values|^2 of each draw
void add_squares(const DrawLine* values, std::size_t count, double* squares);

}  // namespace octant::calib
