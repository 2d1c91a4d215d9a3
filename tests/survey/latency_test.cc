// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/latency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/evaluate.h"

namespace octant::survey {
namespace latency_test {

using testing::ElementsAre;

Arrival arrival(double time_s, float received_after_s, std::int64_t epoch = kNoEpoch, int vehicle = 0) {
  Arrival a;
  a.time_s = time_s;
  a.received_after_s = received_after_s;
  a.epoch = epoch;
  a.vehicle = VehicleId(vehicle);
  return a;
}

Fix fix(double time_s, std::int64_t epoch = kNoEpoch, FixStatus status = FixStatus::kOk) {
  Fix fix;
  fix.status = status;
  fix.time_s = time_s;
  fix.vehicle = VehicleId(0);
  fix.epoch = epoch;
  fix.covariance = Eigen::Matrix3d::Identity();
  return fix;
}

TEST(Latency, LastsUntilTheLastArrivalOfTheEpoch) {
  MeasurementLog log;
  log.arrivals = {arrival(1.0, 0.5F, 7), arrival(1.25, 0.125F, 7), arrival(9.0, 0.25F, 8),
                  arrival(9.0, 4.0F, 8, 1)};
  // The first row of epoch 7 is received last, at 1.5 s. Another vehicle's row of epoch 8 does not count.
  EXPECT_THAT(latencies_s(std::vector{fix(1.125, 7), fix(9.0, 8), fix(9.0, 9)}, log),
              ElementsAre(0.375, 0.25));
}

TEST(Latency, IsThatOfTheInstantInADrive) {
  MeasurementLog log;
  log.arrivals = {arrival(1.0, 0.125F), arrival(1.0, 0.25F), arrival(2.0, NAN), arrival(3.0, 0.5F)};
  EXPECT_THAT(latencies_s(std::vector{fix(1.0), fix(2.0), fix(3.0, kNoEpoch, FixStatus::kNoConsensus)}, log),
              ElementsAre(0.25));
}

TEST(Latency, OfAllRecordingsIsPartOfTheEvaluation) {
  std::vector<ReferencedRun> runs(2);
  for (ReferencedRun& run : runs) run.truth = {{0.0, Pose{}}, {1.0, Pose{}}};
  EXPECT_FALSE(evaluate(runs, Motion::kPlanar, {}).latency);
  runs[0].latencies_s = {0.3};
  runs[1].latencies_s = {0.2, 0.1};
  const auto latency = evaluate(runs, Motion::kPlanar, {}).latency;
  ASSERT_TRUE(latency);
  EXPECT_NEAR(latency->mean_s, 0.2, 1e-12);
  EXPECT_NEAR(latency->p95_s, 0.29, 1e-12);
  EXPECT_EQ(latency->largest_s, 0.3);
}

}  // namespace latency_test
}  // namespace octant::survey
