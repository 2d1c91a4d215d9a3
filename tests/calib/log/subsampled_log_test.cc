// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/log/subsampled_log.h"

#include <cmath>

#include <gtest/gtest.h>

#include "calib/calibrator.h"
#include "calib/problem/subsample.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace subsampled_log_test {

TEST(LogCounts, AreOfEachBeacon) {
  const World world = must(simulate(hall_scenario(), 1));
  const calib::LogCounts counts(problem_of(world));
  for (std::size_t b = 0; b < world.site.beacons.size(); ++b)
    EXPECT_EQ(counts.arrivals[b],
              static_cast<double>(std::count_if(world.run.arrivals.begin(), world.run.arrivals.end(),
                                                [b](const Arrival& a) { return a.beacon.index() == b; })));
  EXPECT_EQ(counts.all_arrivals(), static_cast<double>(world.run.arrivals.size()));
  EXPECT_EQ(counts.states, 120U);
  EXPECT_EQ(counts.poses, 0.0);
}

// A quarter of the epochs: values and residuals are those of the part. The sigmas are those of all epochs,
// half as large, predicted within a tenth.
TEST(SubsampledLog, HasTheVerdictOfTheWhole) {
  Scenario s = hall_scenario();
  s.path.epochs = 480;
  const World world = must(simulate(s, 2));
  const calib::Problem whole = problem_of(world),
                       few = must(calib::make_problem(
                           world.site, {calib::subsample(world.run, world.site, {.instants = 120})}));
  const calib::SolveOptions options;
  calib::ProgressMonitor monitor(options);
  const calib::LogCounts all(whole);
  calib::SubsampledLog log(few, all, options, monitor);
  const calib::Solution foretold = must(calib::solve_log(log, options, monitor)), part = calib::solve(few),
                        of_all = calib::solve(whole);
  ASSERT_EQ(foretold.status, calib::SolveStatus::kConverged) << foretold.message;
  EXPECT_EQ(foretold.statistics.arrivals, part.statistics.arrivals);
  EXPECT_EQ(foretold.warnings, part.warnings);
  ASSERT_EQ(foretold.covariance.parameters, of_all.covariance.parameters);
  double ratio = 0.0;
  int count = 0;
  for (std::size_t b = 0; b < world.site.beacons.size(); ++b) {
    EXPECT_EQ(foretold.state.beacon_p_map_m[b], part.state.beacon_p_map_m[b]);
    for (std::size_t i = 0; i < 2; ++i) {
      const int at = of_all.covariance.index_of(parameters::beacon_position(b, i));
      if (at < 0) continue;
      const double sigma = std::sqrt(foretold.covariance.matrix(at, at));
      ratio += sigma / std::sqrt(of_all.covariance.matrix(at, at));
      ++count;
      EXPECT_LT(sigma, 0.75 * std::sqrt(part.covariance.matrix(at, at)));
    }
  }
  EXPECT_NEAR(ratio / count, 1.0, 0.1);
}

// Without subsampling there are no weights.
TEST(SubsampledLog, OfAllIsTheLog) {
  const World world = must(simulate(hall_scenario(), 3));
  const calib::Problem problem = problem_of(world);
  const calib::SolveOptions options;
  calib::ProgressMonitor monitor(options);
  const calib::LogCounts all(problem);
  calib::SubsampledLog log(problem, all, options, monitor);
  const calib::Solution a = must(calib::solve_log(log, options, monitor)), b = calib::solve(problem);
  EXPECT_EQ(a.covariance.matrix, b.covariance.matrix);
}

}  // namespace subsampled_log_test
}  // namespace octant::test
