// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/chi_square.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace octant {
namespace {

/// e^(z^2) erfc(z) for z >= 0; by a continued fraction where erfc would underflow.
double scaled_erfc(double z) {
  constexpr double kFar = 5.0;
  if (z < kFar) return std::exp(z * z) * std::erfc(z);
  double fraction = z;
  for (int k = 30; k > 0; --k) fraction = z + 0.5 * k / fraction;
  return std::numbers::inv_sqrtpi / fraction;
}

}  // namespace

double log_chi_square_tail(double value, int degrees_of_freedom) {
  const double half = 0.5 * std::max(0.0, value);
  const bool odd = degrees_of_freedom % 2 == 1;
  // e^(-x/2) (erfcx(sqrt(x/2)) + sum (x/2)^(j - 1/2) / Gamma(j + 1/2)), or without the first term and the
  // halves.
  double sum = odd ? scaled_erfc(std::sqrt(half)) : 0.0;
  double term = odd ? 2.0 * std::sqrt(half) * std::numbers::inv_sqrtpi : 1.0;
  for (int j = 0; j < degrees_of_freedom / 2; ++j) {
    sum += term;
    term *= half / (odd ? j + 1.5 : j + 1.0);
  }
  return std::min(0.0, std::log(sum) - half);
}

double chi_square_tail(double value, int degrees_of_freedom) {
  return std::exp(log_chi_square_tail(value, degrees_of_freedom));
}

double chi_square_beyond(double p, int degrees_of_freedom) {
  const double wanted = std::log(p);
  double low = 0.0, high = 1.0;
  while (log_chi_square_tail(high, degrees_of_freedom) > wanted) high *= 2;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (log_chi_square_tail(middle, degrees_of_freedom) > wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double chi2_gate(int degrees_of_freedom, double z) {
  if (degrees_of_freedom <= 0) return 0.0;
  const double v = 2.0 / (9.0 * degrees_of_freedom);
  return degrees_of_freedom * std::pow(1 - v + z * std::sqrt(v), 3);
}

}  // namespace octant
