// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/simulator/random.h"

#include <algorithm>
#include <cmath>

namespace octant {

// Finalizer of splitmix64, so that neighbouring seeds give unrelated states.
std::uint64_t Random::mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

double Random::uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

double Random::uniform(double low, double high) { return low + (high - low) * uniform(); }

double Random::log_uniform(double low, double high) {
  return low * std::exp(uniform() * std::log(high / low));
}

// Box and Muller 1958. The second value is discarded, so that a draw never depends on the number of draws
// before it.
double Random::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * M_PI * uniform());
}

double Random::clipped_normal(double limit) { return std::clamp(normal(), -limit, limit); }

Eigen::Vector3d Random::normal3() {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = normal();
  return v;
}

}  // namespace octant
