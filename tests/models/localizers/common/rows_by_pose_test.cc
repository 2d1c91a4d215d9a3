// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/rows_by_pose.h"

#include <gtest/gtest.h>

namespace octant {
namespace rows_by_pose_test {

std::vector<Arrival> arrivals_at(const std::vector<double>& times_s) {
  std::vector<Arrival> arrivals;
  for (const double time_s : times_s) {
    Arrival& a = arrivals.emplace_back();
    a.time_s = time_s;
    a.vehicle = VehicleId(0);
    a.tof_s = 1e-8;
  }
  return arrivals;
}

TEST(RowsByPose, AStreamWithoutGapsIsCutIntoPings) {
  const auto stream = arrivals_at({0.0, 0.004, 0.008, 0.012, 0.016});
  const RowsByPose<Arrival> rows(stream, VehicleId(0), false);
  ASSERT_EQ(rows.count(), 3U);
  EXPECT_EQ(rows.pose(0).size(), 2U);
  EXPECT_EQ(rows.pose(2).size(), 1U);
}

// Sound of one firing takes 30 ms to cross a hall of ten metres.
TEST(RowsByPose, WhatWasSentTogetherIsOnePing) {
  auto sound = arrivals_at({0.010, 0.018, 0.026});
  for (Arrival& a : sound) a.tof_s = a.time_s;
  EXPECT_EQ(RowsByPose<Arrival>(sound, VehicleId(0), false).count(), 1U);
}

TEST(RowsByPose, EpochsAreOfOneVehicle) {
  auto all = arrivals_at({0.0, 0.5, 1.0, 1.5});
  for (std::size_t i = 0; i < all.size(); ++i) all[i].epoch = i < 3 ? 1 : 2;
  all[1].vehicle = VehicleId(1);
  const RowsByPose<Arrival> rows(all, VehicleId(0), true);
  ASSERT_EQ(rows.count(), 2U);
  EXPECT_DOUBLE_EQ(middle_time_s(rows.pose(0)), 1.0);
}

}  // namespace rows_by_pose_test
}  // namespace octant
