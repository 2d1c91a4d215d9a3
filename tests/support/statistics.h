// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Distributions, so that statistical tests compute their bounds instead of tuning them.

#include <cmath>

namespace octant::test {

/// Regularised lower incomplete gamma function P(a, x): series below a + 1, Lentz's continued fraction above
/// (Abramowitz and Stegun 6.5.29 and 6.5.31).
inline double gamma_p(double a, double x) {
  if (x <= 0) return 0.0;
  const double scale = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 100000 && term > sum * 1e-16; ++n) sum += term *= x / (a + n);
    return scale * sum;
  }
  double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
  for (int i = 1; i < 100000; ++i) {
    const double an = -i * (i - a);
    b += 2;
    d = 1 / (an * d + b);
    c = b + an / c;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return 1 - scale * h;
}

inline double chi2_cdf(double x, double dof) { return gamma_p(dof / 2, x / 2); }

/// Value below which a chi-square variable of dof degrees of freedom stays with a probability.
inline double chi2_quantile(double probability, double dof) {
  double low = 0, high = dof + 50 * std::sqrt(dof) + 100;
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (chi2_cdf(middle, dof) < probability ? low : high) = middle;
  }
  return (low + high) / 2;
}

inline double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

/// Kolmogorov's bound of the largest distance between the distribution of n samples and the true one,
/// exceeded with a probability of alpha (asymptotic; Stephens' correction for small n).
inline double kolmogorov_bound(double n, double alpha) {
  const double root = std::sqrt(n);
  return std::sqrt(-0.5 * std::log(alpha / 2)) / (root + 0.12 + 0.11 / root);
}

}  // namespace octant::test
