// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Weight of the priors under the errors as found.
#include <array>
#include <cmath>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace weights_test {

using testing::IsEmpty;

constexpr double kPriorSigma_m = 0.05;

/// A hall in which each beacon has a prior, and errors depend on the beacon and the part of the hall.
World with_local_errors(std::uint64_t seed, double error_s) {
  Scenario s = hall_scenario();
  for (SiteBeacon& b : s.site.beacons)
    if (!b.is_control_point()) b.sigma_m = {kPriorSigma_m, kPriorSigma_m, kPriorSigma_m};
  World world = must(simulate(s, seed));
  Random random(seed, 5);
  std::map<std::array<int, 3>, double> errors_s;
  for (Arrival& a : world.run.arrivals) {
    Pose pose;
    EXPECT_TRUE(interpolate_poses(world.run.truth, a.time_s, 10.0, pose));
    const std::array<int, 3> cell = {a.beacon.value, static_cast<int>(pose.translation_m.x() / 10.0),
                                     static_cast<int>(pose.translation_m.y() / 6.0)};
    a.tof_s += errors_s.try_emplace(cell, error_s * random.normal()).first->second;
  }
  return world;
}

// Posterior sigmas were up to eight times the priors, because arrivals were weighted as white.
TEST(Weights, CorrelatedErrorsDoNotOverruleAPrior) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const World world = with_local_errors(seed, 1e-4);
    const calib::Solution solution = solution_of(world);
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged);
    EXPECT_THAT(solution.contradictions, IsEmpty()) << "seed " << seed;
    for (std::size_t b = 0; b < world.site.beacons.size(); ++b) {
      if (world.site.beacons[b].is_control_point()) continue;
      for (const char* axis : {"x_m", "y_m", "z_m"})
        // An optimal estimate has at most the sigma of its prior; a twentieth for approximate weights.
        EXPECT_LT(sigma_of(solution, world.site, "beacon/" + world.site.beacons[b].name + "/" + axis),
                  1.05 * kPriorSigma_m)
            << "seed " << seed;
    }
  }
}

}  // namespace weights_test
}  // namespace octant::test
