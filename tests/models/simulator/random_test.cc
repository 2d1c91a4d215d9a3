// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/simulator/random.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/statistics.h"

namespace octant {
namespace random_test {

/// Largest distance between the distribution of samples and a cumulative distribution function.
template <class Cdf>
double kolmogorov_distance(std::vector<double> x, const Cdf& cdf) {
  std::sort(x.begin(), x.end());
  double largest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double n = static_cast<double>(x.size()), f = cdf(x[i]);
    largest = std::max(
        {largest, std::abs(f - static_cast<double>(i) / n), std::abs(f - static_cast<double>(i + 1) / n)});
  }
  return largest;
}

template <class Draw>
std::vector<double> samples(std::uint64_t seed, const Draw& draw) {
  Random draws(seed);
  std::vector<double> x(20000);
  for (double& value : x) value = draw(draws);
  return x;
}

TEST(Random, DrawsHaveTheirDistributions) {
  const double bound = test::kolmogorov_bound(20000, 1e-4);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    EXPECT_LT(
        kolmogorov_distance(samples(seed, [](Random& r) { return r.uniform(); }), [](double x) { return x; }),
        bound)
        << seed;
    EXPECT_LT(kolmogorov_distance(samples(seed, [](Random& r) { return r.normal(); }), test::normal_cdf),
              bound)
        << seed;
    EXPECT_LT(kolmogorov_distance(samples(seed, [](Random& r) { return r.log_uniform(1e-4, 1e-2); }),
                                  [](double x) { return std::log(x / 1e-4) / std::log(100.0); }),
              bound)
        << seed;
  }
}

TEST(Random, NeighbouringSeedsAndStreamsAreUncorrelated) {
  const auto correlation = [](Random a, Random b) {
    double sum = 0;
    for (int i = 0; i < 10000; ++i) sum += a.normal() * b.normal();
    return sum / 100;  // standard normal for independent draws
  };
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    EXPECT_LT(std::abs(correlation(Random(seed), Random(seed + 1))), 4.5) << seed;
    EXPECT_LT(std::abs(correlation(Random(seed, 0), Random(seed, 1))), 4.5) << seed;
    EXPECT_LT(std::abs(correlation(Random(seed, 1), Random(seed + 1, 0))), 4.5) << seed;
  }
}

TEST(Random, ClippedDrawsStayWithin) {
  for (double x : samples(1, [](Random& r) { return r.clipped_normal(1.5); })) EXPECT_LE(std::abs(x), 1.5);
}

}  // namespace random_test
}  // namespace octant
