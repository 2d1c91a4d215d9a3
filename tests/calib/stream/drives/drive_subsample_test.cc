// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drives/drive_subsample.h"

#include <gtest/gtest.h>

#include "calib/problem/subsample.h"
#include "calib/stream/long_log.h"
#include "tests/calib/memory_source.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace drive_subsample_test {

/// The part of a run that is not in memory, compared with the selection of subsample().
void expect_the_part_of_thin(const Site& site, const MeasurementLog& run) {
  const MeasurementLog expected = calib::subsample(run, site, calib::kLongLogSubsample);
  MemorySource source(std::vector<MeasurementLog>{run}, 300);
  calib::DriveIndex index(source, site);
  static_cast<void>(source.scan([&](std::size_t r, const std::vector<Arrival>& block) {
    index.add(r, block);
    return true;
  }));
  index.end(1U << 20U);
  const MeasurementLog part = must(calib::subsample_of_drives(0, site, source, index));
  ASSERT_LT(part.arrivals.size(), run.arrivals.size());
  ASSERT_EQ(part.arrivals.size(), expected.arrivals.size());
  for (std::size_t i = 0; i < part.arrivals.size(); ++i)
    EXPECT_EQ(part.arrivals[i].line, expected.arrivals[i].line);
  ASSERT_EQ(part.odometry.size(), expected.odometry.size());
  for (std::size_t i = 0; i < part.odometry.size(); ++i) {
    EXPECT_EQ(part.odometry[i].time_s, expected.odometry[i].time_s);
    EXPECT_EQ(part.odometry[i].dx_m, expected.odometry[i].dx_m);
  }
  ASSERT_EQ(part.poses.size(), expected.poses.size());
  for (std::size_t i = 0; i < part.poses.size(); ++i)
    EXPECT_EQ(part.poses[i].time_s, expected.poses[i].time_s);
}

TEST(DrivePart, IsThatOfTheWholeDrive) {
  for (const Ranging ranging : {Ranging::kOneWay, Ranging::kTwoWay}) {
    Scenario s = drive_scenario(600.0);
    s.site.timing.ranging = ranging;
    if (ranging == Ranging::kTwoWay) s.site.timing.turnaround_s = 0.25;
    s.heldout_path.duration_s = 5.0;
    s.log_poses = true;
    MeasurementLog run = must(simulate(s, 4)).run;
    // One beacon is received occasionally.
    std::erase_if(run.arrivals, [](const Arrival& a) { return a.beacon.value == 5 && a.line % 30 != 0; });
    expect_the_part_of_thin(s.site, run);
  }
}

// Also without odometry: segments of time.
TEST(DrivePart, MayBeOfADriveByAMotionPrior) {
  Scenario s = drive_scenario(600.0);
  s.heldout_path.duration_s = 5.0;
  MeasurementLog run = must(simulate(s, 5)).run;
  run.odometry.clear();
  expect_the_part_of_thin(s.site, run);
}

}  // namespace drive_subsample_test
}  // namespace octant::test
