// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/log/held_log.h"

#include <gtest/gtest.h>

#include "calib/adjust/priors.h"
#include "calib/adjust/reject.h"
#include "calib/start/approach.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace held_log_test {

World hall(int epochs, std::uint64_t seed) {
  Scenario s = hall_scenario();
  s.path.epochs = epochs;
  s.echo_fraction = 0.05;
  return must(simulate(s, seed));
}

TEST(HeldLog, OffersAPartOfALongLogAndThenTheWhole) {
  for (const bool is_long : {false, true}) {
    const World world = hall(is_long ? 4100 : 40, 1);
    const calib::Problem problem = problem_of(world);
    const calib::SolveOptions options;
    calib::ProgressMonitor monitor(options);
    calib::HeldLog log(problem, options, monitor);
    auto sample = must(log.next_sample());
    if (is_long) {
      EXPECT_FALSE(sample.is_complete);
      EXPECT_LT(sample.problem->runs[0].arrivals.size(), world.run.arrivals.size() / 4);
      sample = must(log.next_sample());
    }
    EXPECT_EQ(sample.problem, &problem);
    EXPECT_TRUE(sample.is_complete);
    EXPECT_EQ(must(log.next_sample()).problem, nullptr);
  }
}

// At the end all arrivals in use are within the limit, and all rejected ones are near or beyond it. The noise
// of all arrivals follows the scale, and a wrong scale shows in the statistics.
TEST(HeldLog, AdjustsTheArrivalsThatAgree) {
  const World world = hall(60, 2);
  const calib::Problem problem = problem_of(world);
  const calib::SolveOptions options;
  calib::ProgressMonitor monitor(options);
  calib::HeldLog log(problem, options, monitor);
  const auto sample = must(log.next_sample());
  calib::Approach start = calib::approach(*sample.problem, options, monitor);
  ASSERT_TRUE(start.ok);
  const double sigma = calib::agreeing_sigma(start.trajectories, start.estimate.state());
  EXPECT_EQ(must(log.place(start, sigma)), sigma) << "the states are those of the start";
  calib::Estimate estimate = start.estimate;
  const calib::DataSquares first = must(log.adjust_inliers(estimate));
  EXPECT_TRUE(estimate.last.converged);
  EXPECT_NEAR(2 * first.cost / first.redundancy, 1.0, 0.3);
  log.scale_noise(estimate, {.arrivals = 2.0});
  EXPECT_EQ(estimate.noise_factor, 2.0);
  EXPECT_FALSE(estimate.last.data);
  const calib::DataSquares second = must(log.adjust_inliers(estimate));
  EXPECT_LT(second.cost / second.redundancy, 0.4 * first.cost / first.redundancy);
  const calib::Findings found = must(log.findings(estimate));
  EXPECT_TRUE(found.as_complete.empty());
  std::size_t used = 0;
  for (const Trajectory& t : found.trajectories)
    for (const ArrivalObservation& a : t.arrivals) {
      EXPECT_NEAR(a.sigma_s, 2.0 * world.site.noise.tof_sigma_s, 1e-12);
      const double off = std::abs(arrival_residual(t, a, estimate.state()));
      if (a.rejection == Rejection::kUsed) {
        ++used;
        EXPECT_LE(off, options.rejection_sigmas);
      } else if (a.rejection == Rejection::kLate || a.rejection == Rejection::kEarly) {
        EXPECT_GT(off, 0.85 * options.rejection_sigmas);
      }
    }
  EXPECT_EQ(used, found.statistics.arrivals);
}

}  // namespace held_log_test
}  // namespace octant::test
