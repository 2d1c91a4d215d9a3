// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/fix_shift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace fix_shift_test {

using calib::SolveStatus;
using testing::Contains;
using testing::HasSubstr;

/// All beacons are control points at the height of the receivers, which only its prior determines.
Scenario level_hall(double height_sigma_m) {
  Scenario s = hall_scenario();
  for (SiteBeacon& b : s.site.beacons) {
    b.position_m[2] = 0.35;
    b.sigma_m.fill(0.0);
  }
  for (SiteReceiver& r : s.site.receivers) {
    r.position_m.z() = 0.35;
    r.sigma_m = {0.002, 0.002, height_sigma_m};
  }
  s.site.noise.tof_sigma_s = 1e-4;
  s.path.epochs = 40;
  return s;
}

TEST(FixShift, IsThatOfAMovedMap) {
  const World world = must(simulate(hall_scenario(), 4));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  calib::Problem all_free = problem;
  for (SiteBeacon& b : all_free.site.beacons) b.sigma_m.fill(1.0);
  const calib::ParameterLayout layout = calib::make_layout(all_free, solution.state);
  const Eigen::VectorXd x = layout.vector_of(solution.state);
  EXPECT_LT(calib::fix_shift_m(layout, x, x, solution.trajectories).value(), 1e-6);
  Eigen::VectorXd y = x;
  for (const auto& columns : layout.beacon) y[columns[0]] += 0.01;
  EXPECT_NEAR(calib::fix_shift_m(layout, x, y, solution.trajectories).value(), 0.01, 1e-4);
}

TEST(FixShift, AHeightThatNoFixFeelsRefusesNothing) {
  const World world = must(simulate(level_hall(0.1), 1));
  const calib::Solution solution = solution_of(world);
  EXPECT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  std::vector<std::string> descriptions;
  for (const calib::WeakDirection& w : solution.weak) {
    EXPECT_FALSE(w.blocking);
    descriptions.push_back(w.description);
    if (w.description.find("receiver") == 0) {
      EXPECT_GT(w.sigma_m, 0.05);
      EXPECT_LT(w.consequence_m, 0.05);
    }
  }
  EXPECT_THAT(descriptions, Contains(HasSubstr("receiver r0")));
}

TEST(FixShift, AReceiverThatEveryFixFeelsRefuses) {
  Scenario s = level_hall(0.002);
  s.site.receivers.resize(1);
  s.site.receivers[0].position_m = {0.0, 0.0, 0.35};
  s.site.receivers[0].sigma_m = {0.5, 0.5,
                                 0.002};  // and nothing but ranges to it: fixes are off by all of that
  s.site.receivers[0].axis.reset();
  s.site.vehicles[0].receiver_count = 1;
  s.hearing_half_angle_rad = 3.2;
  const calib::Solution solution = solution_of(must(simulate(s, 2)));
  EXPECT_EQ(solution.status, SolveStatus::kUndetermined);
  EXPECT_THAT(solution.message, HasSubstr("receiver r0"));
}

}  // namespace fix_shift_test
}  // namespace octant::test
