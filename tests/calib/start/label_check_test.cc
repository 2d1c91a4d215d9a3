// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/label_check.h"

#include <gtest/gtest.h>

#include "tests/calib/calib_support.h"

namespace octant::test {
namespace label_check_test {

TEST(LabelCheck, AFarBeaconLosesItsPriorUnlessItIsTrusted) {
  const World world = must(simulate(hall_scenario(), 1));
  const calib::Problem problem = problem_of(world);
  const SharedState state = prior_state(problem.site);
  const calib::ParameterLayout layout = calib::make_layout(problem, state);
  Eigen::VectorXd x = layout.vector_of(state);
  x[layout.beacon[1][0]] += 3.0;  // ten of its sigmas
  const auto prior_sigma = [](const calib::ParameterLayout& l) {
    return l.parameters[static_cast<std::size_t>(l.beacon[1][0])].prior_sigma;
  };

  calib::ParameterLayout doubted = layout;
  const calib::LabelCheck check = calib::check_labels(problem, doubted, x);
  EXPECT_TRUE(check.mended);
  EXPECT_EQ(check.disregarded, std::vector<std::size_t>{1});
  EXPECT_EQ(check.warnings.size(), 1U);
  EXPECT_TRUE(std::isinf(prior_sigma(doubted)));

  calib::ParameterLayout trusting = layout;
  const calib::LabelCheck trusted = calib::check_labels(problem, trusting, x, {1});
  EXPECT_TRUE(trusted.warnings.empty());
  EXPECT_TRUE(trusted.disregarded.empty());
  EXPECT_EQ(prior_sigma(trusting), prior_sigma(layout));
}

}  // namespace label_check_test
}  // namespace octant::test
