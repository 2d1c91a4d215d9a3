// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Natural logarithm of the probability that chi-square with this many degrees of freedom (at least 1)
/// exceeds a value; finite where the probability itself is below what a double holds. Closed form (Abramowitz
/// and Stegun 26.4.4 and 26.4.5).
[[nodiscard]] double log_chi_square_tail(double value, int degrees_of_freedom);
/// The probability.
[[nodiscard]] double chi_square_tail(double value, int degrees_of_freedom);
/// The value that chi-square exceeds with this probability. @param p  in (0, 1)
[[nodiscard]] double chi_square_beyond(double p, int degrees_of_freedom);
/// What a chi-square variable stays below as often as a normal one below z sigmas (Wilson and Hilferty 1931);
/// 0 without freedom.
[[nodiscard]] double chi2_gate(int degrees_of_freedom, double z);

}  // namespace octant
