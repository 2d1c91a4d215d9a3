// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/cusum.h"

#include <cmath>

namespace octant {

double run_length(double k, double h) {
  // One side: (exp(2 k b) - 1 - 2 k b) / (2 k^2), b = h + 1.166 for the overshoot; both together alarm twice
  // as often.
  const double x = 2.0 * k * (h + 1.166);
  return 0.5 * (std::expm1(x) - x) / (2.0 * k * k);
}

double cusum_threshold(double k, double length) {
  double low = 0.0, high = 1.0;
  while (run_length(k, high) < length) high *= 2.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (run_length(k, middle) < length ? low : high) = middle;
  }
  return high;
}

}  // namespace octant
