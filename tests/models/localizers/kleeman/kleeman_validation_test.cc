// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_validation.h"

#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/simulator/random.h"

namespace octant::test {
namespace kleeman_validation_test {

/// Beacons in a room, and their true distances from a place, all longer by the same.
struct Heard {
  std::vector<Eigen::Vector3d> beacons;
  OffsetDistances d;

  Heard(Random& draws, int count) {
    const Eigen::Vector3d place(draws.uniform(0, 20), draws.uniform(0, 12), 0.3);
    const double offset_m = draws.uniform(-3, 50);
    for (int b = 0; b < count; ++b) {
      const auto i = static_cast<std::size_t>(b);
      beacons.emplace_back(draws.uniform(0, 20), draws.uniform(0, 12), draws.uniform(2, 3));
      d.distance_m[i] = (beacons[i] - place).norm() + offset_m;
      d.sigma_m[i] = 0.003;
      d.heard.set(i);
    }
  }
};

RC_GTEST_PROP(TriangleViolations, TrueDistancesViolateNothingWhateverTheOffset, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const Heard heard(draws, *rc::gen::inRange(1, 17));
  RC_ASSERT(triangle_violations(heard.d, heard.beacons, 0.0, 1e-9).none());
}

RC_GTEST_PROP(TriangleViolations, OnlyWhatIsTooLongIsRejected, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  Heard heard(draws, 8);
  BeaconSet late;
  for (std::size_t b = 0; b < 8; ++b)
    if (*rc::gen::inRange(0, 3) == 0) {
      heard.d.distance_m[b] += draws.uniform(0, 30);
      late.set(b);
    }
  const BeaconSet found = triangle_violations(heard.d, heard.beacons, 0.0, 1e-9);
  RC_ASSERT((found & ~late).none());
  // One that is beyond the room's size late must be found, if any beacon is good.
  for (std::size_t b = 0; b < 8; ++b) {
    if (!late[b] || late.all()) continue;
    Heard far = heard;
    far.d.distance_m[b] += 50.0;
    RC_ASSERT(late.count() == 8 || triangle_violations(far.d, far.beacons, 0.0)[b]);
  }
}

TEST(TriangleViolations, BeginBeyondTheToleranceOfTheDifference) {
  OffsetDistances d;
  const std::vector<Eigen::Vector3d> beacons = {{0, 0, 0}, {4, 0, 0}};
  d.heard.set(0).set(1);
  d.sigma_m[0] = 0.03;
  d.sigma_m[1] = 0.04;  // 0.05 of the difference
  d.distance_m[0] = 1.0;
  d.distance_m[1] = 5.0 + 0.149;
  EXPECT_TRUE(triangle_violations(d, beacons, 3.0).none());
  d.distance_m[1] = 5.0 + 0.151;
  EXPECT_EQ(triangle_violations(d, beacons, 3.0), BeaconSet().set(1)) << "the longer one";
  EXPECT_TRUE(triangle_violations(d, beacons, 3.0, 0.01).none()) << "of the array's size";
  std::swap(d.distance_m[0], d.distance_m[1]);
  EXPECT_EQ(triangle_violations(d, beacons, 3.0), BeaconSet().set(0));
}

TEST(TriangleViolations, OfWhatWasNotHeardAreNone) {
  OffsetDistances d;
  const std::vector<Eigen::Vector3d> beacons = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  d.distance_m[1] = 1e6;
  d.heard.set(0).set(2);
  EXPECT_TRUE(triangle_violations(d, beacons, 3.0).none());
  EXPECT_TRUE(triangle_violations(OffsetDistances(), {}, 3.0).none());
}

}  // namespace kleeman_validation_test
}  // namespace octant::test
