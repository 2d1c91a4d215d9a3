// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/calibrator.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "calib/log/held_log.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace calibrator_test {

/// An in-memory log that records the calls, and may offer another sample for the start.
class WatchedLog : public calib::HeldLog {
 public:
  WatchedLog(const calib::Problem& problem, const calib::SolveOptions& options,
             calib::ProgressMonitor& monitor, const calib::Problem* offered = nullptr)
      : HeldLog(problem, options, monitor), offered_(offered) {}

  Result<Sample> next_sample() override {
    asked.emplace_back("sample");
    if (fails_at == asked.back()) return failed();
    if (offered_ != nullptr) return Sample{std::exchange(offered_, nullptr)};
    return HeldLog::next_sample();
  }
  Result<double> place(calib::Approach& start, double sigma) override {
    asked.emplace_back("place");
    if (fails_at == asked.back()) return failed();
    return HeldLog::place(start, sigma);
  }
  Result<calib::DataSquares> adjust_inliers(calib::Estimate& estimate) override {
    asked.emplace_back("adjust");
    if (fails_at == asked.back()) return failed();
    return HeldLog::adjust_inliers(estimate);
  }
  void scale_noise(calib::Estimate& estimate, const calib::NoiseFactors& factors) override {
    asked.emplace_back("scale");
    HeldLog::scale_noise(estimate, factors);
  }
  Result<calib::Findings> findings(const calib::Estimate& estimate) override {
    asked.emplace_back("findings");
    if (fails_at == asked.back()) return failed();
    return HeldLog::findings(estimate);
  }

  std::vector<std::string> asked;
  std::string fails_at;
  Errc code = Errc::kBadInput;

 private:
  [[nodiscard]] tl::unexpected<Error> failed() const { return fail({.code = code, .found = "a bad sector"}); }
  const calib::Problem* offered_;
};

Scenario small_hall() {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  return s;
}

using Asked = std::vector<std::string>;

TEST(Calibrator, AsksALogForItsStepsInTurn) {
  World world = must(simulate(small_hall(), 1));
  for (const double stated : {1.0, 1.3, 0.2}) {
    world.site.noise.tof_sigma_s = stated * 1e-5;
    const calib::Problem problem = problem_of(world);
    const calib::SolveOptions options;
    calib::ProgressMonitor monitor(options);
    WatchedLog log(problem, options, monitor);
    const calib::Solution solution = must(calib::solve_log(log, options, monitor));
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
    // Once before the inliers are known if it is far off, then as often as their squares require.
    Asked steps = {"sample", "place"};
    if (stated == 0.2) steps.emplace_back("scale");
    steps.emplace_back("adjust");
    const auto rounds = std::count(log.asked.begin(), log.asked.end(), "scale") - (stated == 0.2 ? 1 : 0);
    EXPECT_EQ(rounds > 0, stated != 1.0);
    EXPECT_LE(rounds, stated == 1.3 ? 1 : 2);
    for (auto k = rounds; k-- > 0;) steps.insert(steps.end(), {"scale", "adjust"});
    steps.emplace_back("findings");
    EXPECT_EQ(log.asked, steps) << stated;
    if (stated != 0.2) EXPECT_NEAR(solution.tof_sigma_s, 1e-5, 1e-6);
    EXPECT_EQ(solution.iterations, monitor.iterations);
    EXPECT_EQ(solution.trajectories.size(), problem.trajectories.size());
  }
}

// A sample without information does not refuse an in-memory log.
TEST(Calibrator, StartsFromTheWholeWhereAPartGivesNoStart) {
  const World world = must(simulate(small_hall(), 2));
  const calib::Problem problem = problem_of(world);
  MeasurementLog one = world.run;
  std::erase_if(one.arrivals, [](const Arrival& a) { return a.beacon.value != 1; });
  const calib::Problem of_one_beacon = must(calib::make_problem(world.site, {one}));
  const calib::SolveOptions options;
  calib::ProgressMonitor monitor(options);
  WatchedLog log(problem, options, monitor, &of_one_beacon);
  const calib::Solution solution = must(calib::solve_log(log, options, monitor));
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  EXPECT_EQ(log.asked, (Asked{"sample", "sample", "place", "adjust", "findings"}));
  const calib::Solution whole = calib::solve(problem, {});
  for (std::size_t b = 0; b < whole.state.beacon_p_map_m.size(); ++b)
    EXPECT_EQ(solution.state.beacon_p_map_m[b], whole.state.beacon_p_map_m[b]);
  EXPECT_EQ(solution.warnings, whole.warnings);
}

TEST(Calibrator, ErrorsOfReadingAreErrorsAndAnInterruptionIsAnOutcome) {
  const World world = must(simulate(small_hall(), 3));
  const calib::Problem problem = problem_of(world);
  for (const char* step : {"sample", "place", "adjust", "findings"})
    for (const Errc code : {Errc::kBadInput, Errc::kInterrupted}) {
      const calib::SolveOptions options;
      calib::ProgressMonitor monitor(options);
      WatchedLog log(problem, options, monitor);
      log.fails_at = step;
      log.code = code;
      const auto solution = calib::solve_log(log, options, monitor);
      EXPECT_EQ(log.asked.back(), step);
      if (code == Errc::kInterrupted) {
        ASSERT_TRUE(solution);
        EXPECT_EQ(solution->status, calib::SolveStatus::kInterrupted);
      } else {
        ASSERT_FALSE(solution);
        EXPECT_EQ(solution.error().found, "a bad sector");
      }
    }
}

// The scale is undetermined: the reason for the refusal comes with the earlier warnings.
TEST(Calibrator, ARefusalKeepsWarnings) {
  World world = must(simulate(small_hall(), 4));
  for (SiteBeacon& b : world.site.beacons) b.position_m = {}, b.sigma_m = {};
  world.site.speed_sigma_mps = 200.0;
  for (SiteReceiver& r : world.site.receivers) r.sigma_m.setConstant(1.0);
  calib::Problem problem = problem_of(world);
  problem.warnings = {"of the problem"};
  const calib::Solution solution = calib::solve(problem, {});
  EXPECT_EQ(solution.status, calib::SolveStatus::kUndetermined);
  ASSERT_FALSE(solution.warnings.empty());
  EXPECT_EQ(solution.warnings.front(), "of the problem");
}

}  // namespace calibrator_test
}  // namespace octant::test
