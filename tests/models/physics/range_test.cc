// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/range.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/physics/measurement.h"

namespace octant {
namespace range_test {

constexpr AttenuationModel kModel = {
    .amplitude_1m_v = 1.0, .absorption_np_per_m = 0.1, .threshold_v = 0.01, .rise_time_s = 300e-6};

/// By the measurement equation, of a receiver at rest.
double tof_s(double distance_m, double legs, double log_gain) {
  const Pose here;
  PathInput path;
  path.T_map_vehicle = &here;
  path.T_hear_send = legs == 2.0 ? &here : nullptr;
  path.p_beacon_map_m = {distance_m, 0.0, 0.0};
  path.speed_mps = 345.0;
  path.attenuation = &kModel;
  path.log_gain = log_gain;
  return predict_arrival_value(path).tof_s;
}

TEST(Range, IsTheMeasurementEquationBackwards) {
  for (const double legs : {1.0, 2.0})
    for (const double log_gain : {0.0, -0.9, 0.4})
      for (const double distance_m :
           {0.05, 0.4, 3.0, 12.0, 21.0, 40.0}) {  // the last are beyond what is heard
        const FlightTime flight{tof_s(distance_m, legs, log_gain), 345.0, legs};
        const TimedRange range = range_with_walk(flight, kModel, log_gain);
        EXPECT_NEAR(range.range_m, distance_m, 1e-11) << legs << " legs, ln gain " << log_gain;
        const double step_s = 1e-9;
        const double further_m =
            range_with_walk({flight.time_s + step_s, 345.0, legs}, kModel, log_gain).range_m;
        EXPECT_NEAR((further_m - range.range_m) / step_s, range.by_time_mps, 1e-3 * range.by_time_mps);
      }
}

TEST(Range, ATimeThatIsNoneGivesWhatItWouldWithoutAWalk) {
  EXPECT_EQ(range_with_walk({-0.002, 345.0, 1.0}, kModel, 0.0).range_m, -0.002 * 345.0);
  EXPECT_EQ(range_with_walk({0.0, 345.0, 2.0}, kModel, 0.0).range_m, 0.0);
}

TEST(Range, OffTheAxisAPulseIsLaterByThreeDecibels) {
  const double share = 0.01 / amplitude_v(8.0, kModel);
  EXPECT_NEAR(off_axis_walk_sigma_s(8.0, kModel, 0.0),
              walk_of_share_s(share * std::sqrt(2.0), kModel) - walk_of_share_s(share, kModel), 1e-15);
  EXPECT_EQ(off_axis_walk_sigma_s(60.0, kModel, 0.0), 0.0) << "held at both";
}

}  // namespace range_test
}  // namespace octant
