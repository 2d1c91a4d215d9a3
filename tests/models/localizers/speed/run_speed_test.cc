// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/speed/run_speed.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "models/localizers/methods.h"
#include "models/simulator/synthetic.h"
#include "tests/support/statistics.h"
#include "tests/support/worlds.h"

namespace octant {
namespace run_speed_test {

using test::must;

constexpr double kWarmer_mps = 5.9;  ///< some ten degrees

/// The calibrated hall, and a run without a temperature in air in which sound is faster by kWarmer_mps.
struct WarmRun {
  Deployment deployment;
  MeasurementLog run;
};
WarmRun warm_run(std::uint64_t seed, Scenario scenario) {
  scenario.true_temperature_offset_degC.reset();
  scenario.true_speed_offset_mps = 0.0;
  WarmRun out{must(simulate(scenario, seed)).truth, {}};
  scenario.true_speed_offset_mps = kWarmer_mps;
  out.run = must(simulate(scenario, seed)).heldout;
  return out;
}

Scenario driving(Scenario scenario) {
  scenario.heldout_path.kind = PathKind::kDrive;
  scenario.heldout_path.duration_s = 60.0;
  return scenario;
}

TEST(RunSpeed, IsAskedForWhereNothingIsKnownOfTheTemperature) {
  WarmRun w = warm_run(1, test::hall_scenario());
  EXPECT_TRUE(speed_is_unknown(w.deployment, w.run));
  w.run.temperature_degC = 21.0;
  EXPECT_FALSE(speed_is_unknown(w.deployment, w.run));
  w.run.temperature_degC = 45.0;  // beyond the validity
  EXPECT_TRUE(speed_is_unknown(w.deployment, w.run));
  w.run.temperature_degC.reset();
  w.deployment.medium = {.model = MediumModel::kConstant, .speed_mps = 343.0};
  EXPECT_FALSE(speed_is_unknown(w.deployment, w.run));
}

/// Squares of the offsets' errors in their sigmas are chi-square.
TEST(RunSpeed, StopsTellIt) {
  const int worlds = 12;
  double nees = 0.0;
  for (std::uint64_t seed = 1; seed <= worlds; ++seed) {
    const WarmRun w = warm_run(seed, test::hall_scenario());
    const RunSpeed found = estimate_run_speed(w.deployment, w.run);
    ASSERT_TRUE(found.determined) << "seed " << seed;
    EXPECT_NEAR(found.offset_mps, kWarmer_mps, 5 * found.sigma_mps) << "seed " << seed;
    EXPECT_LT(found.sigma_mps, 0.3);
    EXPECT_NEAR(found.temperature_degC, 31.0, 1.0);
    nees += std::pow((found.offset_mps - kWarmer_mps) / found.sigma_mps, 2);
  }
  EXPECT_LT(nees, test::chi2_quantile(0.999, worlds));
  EXPECT_GT(nees, test::chi2_quantile(0.001, worlds));
}

TEST(RunSpeed, EchoesDoNotBendIt) {
  Scenario scenario = test::hall_scenario();
  scenario.echo_fraction = 0.1;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const WarmRun w = warm_run(seed, scenario);
    const RunSpeed found = estimate_run_speed(w.deployment, w.run);
    ASSERT_TRUE(found.determined) << "seed " << seed;
    EXPECT_NEAR(found.offset_mps, kWarmer_mps, 5 * found.sigma_mps) << "seed " << seed;
  }
}

TEST(RunSpeed, ADriveTellsIt) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const WarmRun w = warm_run(seed, driving(test::hall_scenario()));
    const RunSpeed found = estimate_run_speed(w.deployment, w.run);
    ASSERT_TRUE(found.determined) << "seed " << seed;
    EXPECT_NEAR(found.offset_mps, kWarmer_mps, 5 * found.sigma_mps) << "seed " << seed;
  }
}

/// Three arrivals at one receiver determine a position only.
TEST(RunSpeed, IsNotToldByArrivalsThatArePositionsAlone) {
  WarmRun w = warm_run(1, test::hall_scenario());
  std::map<std::int64_t, std::size_t> heard;
  std::erase_if(w.run.arrivals,
                [&](const Arrival& a) { return a.receiver.index() != 0 || ++heard[a.epoch] > 3; });
  EXPECT_FALSE(estimate_run_speed(w.deployment, w.run).determined);
  w.run.arrivals.clear();
  EXPECT_FALSE(estimate_run_speed(w.deployment, w.run).determined);
}

/// At the speed found poses are as good as with a thermometer, and its sigma is part of theirs.
TEST(RunSpeed, MakesFixes) {
  const WarmRun w = warm_run(3, test::hall_scenario());
  const RunSpeed found = estimate_run_speed(w.deployment, w.run);
  ASSERT_TRUE(found.determined);
  const Deployment told = at_speed(w.deployment, found);
  EXPECT_DOUBLE_EQ(told.speed_offset_mps, w.deployment.speed_offset_mps + found.offset_mps);
  EXPECT_DOUBLE_EQ(told.speed_sigma_mps, found.sigma_mps);
  const auto count = [&](const Deployment& d) {
    const auto fixes = must(locate_run(Method::kLeastSquares, d, w.run));
    return std::count_if(fixes.begin(), fixes.end(), [](const Fix& f) { return f.ok(); });
  };
  const auto with = count(told), without = count(w.deployment);
  EXPECT_EQ(with, static_cast<std::ptrdiff_t>(found.poses));
  EXPECT_LT(without, with / 2);
}

TEST(RunSpeed, ItsSigmaTakesThePlaceOfTheCalibrations) {
  Deployment d = warm_run(1, test::hall_scenario()).deployment;
  const RunSpeed speed{.determined = true, .offset_mps = 2.0, .sigma_mps = 0.2};
  d.covariance.parameters = {parameters::beacon_position(0, 0), parameters::speed()};
  d.covariance.matrix = (Eigen::Matrix2d() << 1e-4, 1e-3, 1e-3, 0.04).finished();
  Deployment at = at_speed(d, speed);
  EXPECT_TRUE(at.covariance.matrix.isApprox((Eigen::Matrix2d() << 1e-4, 0.0, 0.0, 0.04).finished()));
  d.covariance.parameters = {parameters::beacon_position(0, 0)};  // the speed was held
  d.covariance.matrix = Eigen::MatrixXd::Constant(1, 1, 1e-4);
  at = at_speed(d, speed);
  ASSERT_EQ(at.covariance.index_of(parameters::speed()), 1);
  EXPECT_TRUE(at.covariance.matrix.isApprox((Eigen::Matrix2d() << 1e-4, 0.0, 0.0, 0.04).finished()));
}

}  // namespace run_speed_test
}  // namespace octant
