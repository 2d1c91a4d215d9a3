// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/log_readings.h"

#include <memory>

#include <gtest/gtest.h>

#include "tests/calib/stream/one_residual.h"

namespace octant::test {
namespace log_readings_test {

// Results of several passes add up; a mark that depends on solving the states is for a single one.
TEST(JoinedReadings, AddUp) {
  calib::JoinedReadings both;
  both.add(std::make_unique<OneResidual>([](double x, double& r, double& J) { r = 2 * x - 6, J = 2; }));
  both.add(std::make_unique<OneResidual>([](double x, double& r, double& J) { r = x, J = 1; }));
  const calib::PassSum sum = must(both.pass(at(1.0), calib::RejectionPolicy::kKept));
  EXPECT_EQ(sum.system.cost(), 0.5 * 16 + 0.5);
  EXPECT_EQ(sum.counts.cost_before, sum.system.cost());
  EXPECT_EQ(sum.system.parts().front().system.gradient[0], -8.0 + 1.0);
  EXPECT_EQ(sum.system.whole(1).H(0, 0), 5.0);
}

TEST(JoinedReadings, AcceptTogether) {
  calib::JoinedReadings both;
  OneResidual* readings[2];
  for (OneResidual*& r : readings) {
    auto made = std::make_unique<OneResidual>([](double x, double& r, double& J) { r = x, J = 1; });
    r = made.get();
    both.add(std::move(made));
  }
  both.accept();
  EXPECT_EQ(readings[0]->accepted + readings[1]->accepted, 2);
}

}  // namespace log_readings_test
}  // namespace octant::test
