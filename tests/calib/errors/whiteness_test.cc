// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/whiteness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace whiteness_test {

TEST(Whiteness, SimulatedNoiseIsWhite) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const World world = must(simulate(hall_scenario(), seed));
    const calib::Solution solution = solution_of(world);
    const calib::Whiteness w = calib::whiteness_of(solution.trajectories, solution.state);
    EXPECT_TRUE(w.white) << "seed " << seed << ", pair ratio " << w.pair_ratio << ", correlation "
                         << w.autocorrelation;
    EXPECT_EQ(w.sigma_factor, 1.0);
    EXPECT_GT(w.pairs, 20u);
  }
}

TEST(Whiteness, ABiasThatAPairKeepsIsSeenAndWarnedOf) {
  World world = must(simulate(hall_scenario(), 6));
  for (Arrival& a : world.run.arrivals)
    a.tof_s += 2e-5 * std::sin(7.0 * a.beacon.value + 3.0 * a.receiver.value);
  const calib::Solution solution = solution_of(world);
  const calib::Whiteness w = calib::whiteness_of(solution.trajectories, solution.state);
  EXPECT_FALSE(w.white);
  EXPECT_GT(w.pair_ratio, 2.0);
  EXPECT_THAT(solution.warnings, testing::Contains(testing::HasSubstr("correlated")));
}

}  // namespace whiteness_test
}  // namespace octant::test
