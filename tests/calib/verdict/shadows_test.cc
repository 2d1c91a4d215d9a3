// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/shadows.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/calibrator.h"
#include "calib/log/subsampled_log.h"
#include "calib/problem/subsample.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/statements/adjusted.h"

namespace octant::test {
namespace shadows_test {

using ::testing::Contains;
using ::testing::HasSubstr;

/// A hall in which two receivers receive few beacons at a stop, and one arrival in seven is an echo.
World quiet_corners(std::uint64_t seed, double echoes = 0.15) {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  s.range_m = 10.0;
  s.hearing_half_angle_rad = 3.2;
  s.echo_fraction = echoes;
  s.site.receivers.resize(2);
  const Eigen::Vector3d places[2] = {{0.3, 0.1, 0.3}, {-0.2, -0.2, 0.6}};
  for (std::size_t i = 0; i < 2; ++i) {
    s.site.receivers[i].position_m = places[i];
    s.site.receivers[i].axis.reset();
  }
  s.site.vehicles[0].receiver_count = 2;
  s.site.vehicles[0].array.reset();
  return must(simulate(s, seed));
}

calib::ShadowRisk risk_of(const World& world, const calib::Solution& solution) {
  const Adjusted adjusted(world, solution);
  return calib::shadow_risk(solution.trajectories, solution.state, adjusted.parameters());
}

/// Squares of errors over their variances, of free beacon coordinates.
struct Squares {
  double sum = 0.0, count = 0.0, largest = 0.0;
  void add(double error, double variance) {
    const double square = error * error / variance;
    sum += square;
    count += 1.0;
    largest = std::max(largest, square);
  }
};

// Their mean is one where sigmas hold. By those of the noise alone it is beyond that, with single beacons
// many sigmas off, and Good.
TEST(Shadows, SigmasHoldAmongEchoesThatNoResidualShows) {
  Squares stated, of_noise;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const World world = quiet_corners(seed);
    const calib::Solution solution = solution_of(world);
    if (solution.status != calib::SolveStatus::kConverged) continue;
    const Adjusted adjusted(world, solution);
    for (std::size_t b = 0; b < world.truth.beacons.size(); ++b)
      for (int i = 0; i < 3; ++i) {
        const ParameterId id = parameters::beacon_position(b, static_cast<std::size_t>(i));
        const int at = solution.covariance.index_of(id), column = adjusted.layout.column_of(id);
        if (at < 0 || column < 0) continue;
        const double error = solution.state.beacon_p_map_m[b][i] - world.truth.beacons[b].position_m[i];
        stated.add(error, solution.covariance.matrix(at, at));
        of_noise.add(error, adjusted.covariance(column, column));
      }
  }
  EXPECT_GT(stated.count, 300);
  EXPECT_LT(stated.sum / stated.count, 1.4);
  EXPECT_GT(stated.sum / stated.count, 0.6);
  EXPECT_LT(std::sqrt(stated.largest), 5.0);
  EXPECT_GT(of_noise.sum / of_noise.count, 1.3 * stated.sum / stated.count);
  EXPECT_GT(std::sqrt(of_noise.largest), 6.0);
}

TEST(Shadows, AreNoneWhereNothingWasLate) {
  const World world = quiet_corners(3, 0.0);
  const calib::Solution solution = solution_of(world);
  EXPECT_EQ(risk_of(world, solution).covariance.size(), 0);
  EXPECT_THAT(solution.warnings, ::testing::Not(Contains(HasSubstr("came late at all receivers"))));
}

// The octagon receives each beacon at about 120 stops, so a single one has little effect.
TEST(Shadows, CostLittleWhereMuchIsHeard) {
  Scenario s = hall_scenario();
  s.path.epochs = 150;
  s.echo_fraction = 0.1;
  const World world = must(simulate(s, 4));
  const calib::Solution solution = solution_of(world);
  const Adjusted adjusted(world, solution);
  const calib::ShadowRisk risk = risk_of(world, solution);
  ASSERT_GT(risk.covariance.size(), 0);
  EXPECT_GT(risk.share, 0.02);
  EXPECT_LT(risk.share, 0.12);
  for (Eigen::Index i = 0; i < risk.covariance.rows(); ++i)
    EXPECT_LT(risk.covariance(i, i), 0.15 * adjusted.covariance(i, i)) << i;
}

bool is_told(const calib::Solution& solution) {
  return std::ranges::any_of(solution.warnings, [](const std::string& warning) {
    return warning.find("came late at all receivers") != std::string::npos;
  });
}

TEST(Shadows, AreToldWhereTheyWeigh) {
  int told = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) told += is_told(solution_of(quiet_corners(seed)));
  EXPECT_GE(told, 2);
}

// Its verdict is computed again for all arrivals, without the shadows: octant check once reported sigmas of
// another calibration.
TEST(Shadows, AreNotToldOfASubsampledLog) {
  const calib::SolveOptions options;
  int of_the_part = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const World world = quiet_corners(seed);
    const calib::Problem few =
        must(calib::make_problem(world.site, {calib::subsample(world.run, world.site, {.instants = 58})}));
    calib::ProgressMonitor monitor(options);
    const calib::LogCounts counts(problem_of(world));
    calib::SubsampledLog log(few, counts, options, monitor);
    EXPECT_FALSE(is_told(must(calib::solve_log(log, options, monitor)))) << seed;
    of_the_part += is_told(calib::solve(few));
  }
  EXPECT_GE(of_the_part, 2) << "there is nothing to be told";
}

}  // namespace shadows_test
}  // namespace octant::test
