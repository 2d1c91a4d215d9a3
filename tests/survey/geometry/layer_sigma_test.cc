// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Vector lanes against a dense inverse.
#include "survey/geometry/layer_sigma.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"
#include "survey/geometry/geometry_map.h"

namespace octant::survey {
namespace layer_sigma_test {

constexpr std::size_t kStride = 40;

/// Information of a few ranges for each of some poses, packed as layers are.
struct Layer {
  std::vector<Eigen::MatrixXd> dense;
  std::vector<double> packed;
};

Layer some_layer(int unknowns, std::size_t poses, int ranges, Random& draws) {
  Layer layer;
  layer.packed.assign(static_cast<std::size_t>(unknowns * (unknowns + 1) / 2) * kStride, -1e300);
  for (std::size_t i = 0; i < poses; ++i) {
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(unknowns, unknowns);
    for (int r = 0; r < ranges; ++r) {
      Eigen::VectorXd row(unknowns);
      for (int k = 0; k < unknowns; ++k) row[k] = draws.normal();
      A += row * row.transpose() * 1e4;
    }
    std::size_t e = 0;
    for (int p = 0; p < unknowns; ++p)
      for (int q = p; q < unknowns; ++q) layer.packed[e++ * kStride + i] = A(p, q);
    layer.dense.push_back(A);
  }
  return layer;
}

double horizontal(const Eigen::MatrixXd& information) {
  const Eigen::MatrixXd C = information.inverse();
  return std::sqrt(C(0, 0) + C(1, 1));
}

TEST(LayerSigma, IsTheDenseInversesWithNoneOneAndTwoLayersTakenAway) {
  Random draws(20261125);
  for (const int unknowns : {2, 3, 4, 6, 7})
    // Counts that fill no vector, one and several, with and without a rest.
    for (const std::size_t poses : {1, 3, 8, 13, 40}) {
      const Layer all = some_layer(unknowns, poses, 5 * unknowns, draws);
      Layer one = some_layer(unknowns, poses, 2, draws), two = some_layer(unknowns, poses, 2, draws);
      Layer sum = all;
      for (std::size_t i = 0; i < poses; ++i) sum.dense[i] += one.dense[i] + two.dense[i];
      for (std::size_t e = 0; e < sum.packed.size(); ++e)
        if (e % kStride < poses) sum.packed[e] += one.packed[e] + two.packed[e];
      std::vector<double> none_m(poses), one_m(poses), two_m(poses);
      sigma_of_packed(unknowns, sum.packed.data(), nullptr, nullptr, kStride, poses, none_m.data());
      sigma_of_packed(unknowns, sum.packed.data(), one.packed.data(), nullptr, kStride, poses, one_m.data());
      sigma_of_packed(unknowns, sum.packed.data(), one.packed.data(), two.packed.data(), kStride, poses,
                      two_m.data());
      for (std::size_t i = 0; i < poses; ++i) {
        // Random rows are conditioned to some 1e2, so that rounding stays below 1e-11 of the value.
        EXPECT_NEAR(none_m[i] / horizontal(sum.dense[i]), 1.0, 1e-10) << unknowns;
        EXPECT_NEAR(one_m[i] / horizontal(all.dense[i] + two.dense[i]), 1.0, 1e-10) << unknowns;
        EXPECT_NEAR(two_m[i] / horizontal(all.dense[i]), 1.0, 1e-10) << unknowns;
      }
    }
}

TEST(LayerSigma, WhatLosesItsLastRangeHasNoFix) {
  Random draws(7);
  for (const int unknowns : {2, 3, 4, 6, 7}) {
    // Too few ranges by one without the layer, and enough with it.
    const Layer rest = some_layer(unknowns, 9, unknowns - 1, draws), gone = some_layer(unknowns, 9, 2, draws);
    std::vector<double> all = rest.packed, sigma_m(9);
    for (std::size_t e = 0; e < all.size(); ++e)
      if (e % kStride < 9) all[e] += gone.packed[e];
    sigma_of_packed(unknowns, all.data(), nullptr, nullptr, kStride, 9, sigma_m.data());
    for (const double s : sigma_m) EXPECT_TRUE(std::isfinite(s)) << unknowns;
    sigma_of_packed(unknowns, all.data(), gone.packed.data(), nullptr, kStride, 9, sigma_m.data());
    for (const double s : sigma_m) EXPECT_EQ(s, kNoFix) << unknowns;
  }
}

TEST(LayerSigma, NothingAtAllIsNoFix) {
  const std::vector<double> zeros(28 * kStride, 0.0);
  for (const int unknowns : {2, 3, 4, 6, 7}) {
    std::vector<double> sigma_m(5, 0.0);
    sigma_of_packed(unknowns, zeros.data(), nullptr, nullptr, kStride, 5, sigma_m.data());
    for (const double s : sigma_m) EXPECT_EQ(s, kNoFix) << unknowns;
  }
}

TEST(LayerSigma, NothingIsWrittenBehindTheCount) {
  Random draws(8);
  const Layer layer = some_layer(3, 11, 9, draws);
  std::vector<double> sigma_m(16, -7.0);
  sigma_of_packed(3, layer.packed.data(), nullptr, nullptr, kStride, 11, sigma_m.data());
  for (std::size_t i = 0; i < 11; ++i) EXPECT_GT(sigma_m[i], 0.0);
  for (std::size_t i = 11; i < sigma_m.size(); ++i) EXPECT_EQ(sigma_m[i], -7.0) << i;
}

TEST(LayerSigma, SumsAreAddedEntryByEntry) {
  for (std::size_t count = 0; count < 35; ++count) {
    std::vector<double> sum(40), term(40);
    for (std::size_t i = 0; i < 40; ++i) sum[i] = 0.5 * static_cast<double>(i), term[i] = 1.0 + i % 3;
    const std::vector<double> before = sum;
    add_to(term.data(), count, sum.data());
    for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(sum[i], before[i] + (i < count ? term[i] : 0.0)) << count;
  }
}

}  // namespace layer_sigma_test
}  // namespace octant::survey
