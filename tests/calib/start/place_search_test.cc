// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/place_search.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/simulator/random.h"

namespace octant::test {
namespace place_search_test {

using calib::PlaceAndDelay;
using calib::PlacePrior;
using calib::RangeFrom;

constexpr double kSigmaM = 0.004, kRejectionSigmas = 4.0;
const Eigen::Vector3d kBeacon(10.0, 0.0, 3.0);

/// Ranges from positions in a hall of 20 m x 12 m, at 0.3 and 0.5 m; the given number of the first ones is
/// late.
std::vector<RangeFrom> ranges_of(Random& draws, int count, int late, double late_m) {
  std::vector<RangeFrom> ranges;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p(draws.uniform(1, 19), draws.uniform(1, 11), i % 2 == 0 ? 0.3 : 0.5);
    ranges.push_back({p, (kBeacon - p).norm() + kSigmaM * draws.normal() + (i < late ? late_m : 0.0)});
  }
  return ranges;
}

PlacePrior stated() {
  PlacePrior prior;
  prior.mean << 10.1, 0.1, 2.9, 0.0;
  prior.sigma << 0.3, 0.3, 0.3, 0.01;
  return prior;
}

RC_GTEST_PROP(PlaceOfLargestConsensus, IsThatOfTheDirectArrivals, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const auto ranges = ranges_of(draws, 160, *rc::gen::inRange(64, 89), draws.uniform(0.2, 0.4));
  PlaceAndDelay start;  // where a descent may have ended
  start << kBeacon + Eigen::Vector3d(draws.uniform(-0.2, 0.2), draws.uniform(-0.3, 0.3), 0.15), 0.0;
  const auto found = calib::place_of_largest_consensus(ranges, stated(), start, kSigmaM, kRejectionSigmas);
  RC_ASSERT(found.has_value());
  // Height and delay go together: known to some centimetre.
  RC_ASSERT((found->head<2>() - kBeacon.head<2>()).norm() < 0.01);
  RC_ASSERT(std::abs((*found)[2] - kBeacon.z()) < 0.05);
}

TEST(PlaceOfLargestConsensus, IsNoneWhereTheBeaconIsThere) {
  for (const int late : {0, 40, 70}) {
    Random draws(7);
    const auto ranges = ranges_of(draws, 160, late, 0.3);
    PlaceAndDelay start;
    start << kBeacon, 0.0;
    EXPECT_FALSE(calib::place_of_largest_consensus(ranges, stated(), start, kSigmaM, kRejectionSigmas))
        << late << " late";
  }
}

TEST(PlaceOfLargestConsensus, KeepsWhatIsHeld) {
  Random draws(3);
  const auto ranges = ranges_of(draws, 160, 60, 0.3);
  PlacePrior prior = stated();
  prior.sigma[2] = prior.sigma[3] = 0.0;
  PlaceAndDelay start;
  start << kBeacon + Eigen::Vector3d(0.2, -0.2, 0.0), 0.0;
  const auto found = calib::place_of_largest_consensus(ranges, prior, start, kSigmaM, kRejectionSigmas);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ((*found)[2], start[2]);
  EXPECT_EQ((*found)[3], 0.0);
  EXPECT_LT((found->head<2>() - kBeacon.head<2>()).norm(), 0.01);
}

TEST(PlaceOfLargestConsensus, HasLateArrivalsRatherThanEarlyOnes) {
  // Equally many agree with either position; for one the others are late, for the other early, as echoes
  // never are.
  std::vector<RangeFrom> ranges;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d p(1.0 + 0.3 * i, 4.0 + i % 7, i % 2 == 0 ? 0.3 : 0.5);
    ranges.push_back({p, (kBeacon - p).norm()});
    ranges.push_back({p, (kBeacon - p).norm() + 0.3});
  }
  PlacePrior prior = stated();
  prior.sigma[3] = INFINITY;  // the delay may be 0.3 m as well
  PlaceAndDelay start;
  start << kBeacon, 0.3;
  const auto found = calib::place_of_largest_consensus(ranges, prior, start, kSigmaM, kRejectionSigmas);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR((*found)[3], 0.0, 1e-3);
  start[3] = 0.0;
  EXPECT_FALSE(calib::place_of_largest_consensus(ranges, prior, start, kSigmaM, kRejectionSigmas));
}

TEST(PlaceOfLargestConsensus, IsNoneOfThreeRanges) {
  Random draws(1);
  PlaceAndDelay start;
  start << kBeacon, 0.0;
  EXPECT_FALSE(calib::place_of_largest_consensus(ranges_of(draws, 3, 0, 0.0), stated(), start, kSigmaM,
                                                 kRejectionSigmas));
}

}  // namespace place_search_test
}  // namespace octant::test
