// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octant {

/// Natural logarithm of the probability that chi-square with at least one degree of freedom exceeds a value.
/// Finite even if the probability underflows. Closed form (Abramowitz and Stegun 26.4.4 and 26.4.5).
[[nodiscard]] double log_chi_square_tail(double value, int degrees_of_freedom);
/// Probability that chi-square exceeds a value.
[[nodiscard]] double chi_square_tail(double value, int degrees_of_freedom);
/// Value that chi-square exceeds with this probability. @param p  in (0, 1)
[[nodiscard]] double chi_square_beyond(double p, int degrees_of_freedom);
/// Quantile of chi-square with the probability of a normal variable below z sigmas (Wilson and Hilferty
/// 1931); 0 without degrees of freedom.
[[nodiscard]] double chi2_gate(int degrees_of_freedom, double z);

}  // namespace octant
