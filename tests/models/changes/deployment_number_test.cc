// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/deployment_number.h"

#include <cmath>
#include <iterator>

#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace octant::test {
namespace deployment_number_test {

/// Values are read back as written, and no others change.
TEST(DeploymentNumber, IsReadAsItWasWritten) {
  Scenario s = hall_scenario();
  add_attenuation(s);
  s.path.epochs = s.heldout_path.epochs = 2;
  Deployment d = must(simulate(s, 1)).truth;
  const ParameterId ids[] = {parameters::beacon_position(2, 1), parameters::beacon_delay(5),
                             parameters::beacon_gain(1),        parameters::receiver_position(3, 2),
                             parameters::receiver_delay(4),     parameters::speed(),
                             parameters::attenuation(1),        parameters::clock_drift(0)};
  for (std::size_t i = 0; i < std::size(ids); ++i)
    set_number(ids[i], {0.1 + 0.01 * static_cast<double>(i), 0.5 + 0.01 * static_cast<double>(i)}, d);
  for (std::size_t i = 0; i < std::size(ids); ++i) {
    EXPECT_NEAR(number_in(d, ids[i]).value, 0.1 + 0.01 * static_cast<double>(i), 1e-15);
    const double sigma = number_in(d, ids[i]).sigma;
    EXPECT_TRUE(sigma == 0.0 || sigma == 0.5 + 0.01 * static_cast<double>(i))
        << "where there is room for one";
  }
  EXPECT_EQ(d.beacons[2].position_m.y(), 0.1);
  EXPECT_DOUBLE_EQ(d.beacons[1].gain, std::exp(0.12))
      << "a factor in the file, its logarithm in the estimate";
  EXPECT_DOUBLE_EQ(d.receivers[4].delay_s, 0.14);
  EXPECT_EQ(d.receivers[4].delay_sigma_s, 0.54);
  EXPECT_EQ(d.speed_sigma_mps, 0.55);
}

TEST(DeploymentNumber, OfWhatItDoesNotHoldIsNothing) {
  Deployment d;
  d.vehicles.resize(1);
  for (const ParameterId& id : {parameters::array_radius(0), parameters::array_turn(0),
                                parameters::site_delay(), parameters::pair_bias(0, 0)}) {
    set_number(id, {3.0, 4.0}, d);
    EXPECT_EQ(number_in(d, id).value, 0.0);
    EXPECT_EQ(number_in(d, id).sigma, 0.0);
  }
}

}  // namespace deployment_number_test
}  // namespace octant::test
