// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/tracker.h"
#include "models/localizers/drive/drive_tracker.h"

#include <algorithm>
#include <iostream>
#include <iterator>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "models/localizers/common/trajectory_model.h"
#include "tests/models/localizers/drive_world.h"
#include "tests/models/localizers/hall.h"
#include "tests/support/allocation_count.h"

namespace octant {
namespace tracker_test {

using test::drive;
using test::Drive;
using test::hall;
using test::with_octagon;
using test::with_receiver;

Pose truth_at(const Drive& drive, double time_s) {
  Pose T;
  EXPECT_TRUE(interpolate_poses(drive.truth, time_s, 1.0, T));
  return T;
}

TEST(Tracker, FollowsADriveFromAnUnknownStart) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 60, 1e-5, 1.0, 31);
  const std::vector<Fix> fixes = track(w.log, d);
  double sum2 = 0.0, nees = 0.0;
  int count = 0;
  for (const Fix& fix : fixes) {
    ASSERT_TRUE(fix.ok()) << to_string(fix.status);
    const Pose truth = truth_at(w, fix.time_s);
    Eigen::Vector3d e = fix.T_map_vehicle.translation_m - truth.translation_m;
    e[2] = wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad());
    sum2 += e.head<2>().squaredNorm();
    nees += e.dot(fix.covariance.inverse() * e);
    ++count;
  }
  ASSERT_GT(count, 500);
  // Two beacons within 0.1 s give 5 mm; smoothing over the drive does better than that.
  EXPECT_LT(std::sqrt(sum2 / count), 0.005);
  // Neighbouring states have correlated errors: about 60 s with a correlation time of 2 s contain 30
  // independent ones. The limits are three sigmas of their mean (3 + 3 sqrt(6 / 30)) on either side.
  EXPECT_NEAR(nees / count, 3.0, 1.35);
}

TEST(Tracker, IsExactWithoutNoise) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 20, 0.0, 0.0, 32);
  for (const Fix& fix : track(w.log, d)) {
    ASSERT_TRUE(fix.ok());
    // solve_states() stops at a gain of 1e-13 in the cost: 1e-6 of a sigma (3 mm) over a stiff chain of 400
    // states.
    EXPECT_LT((fix.T_map_vehicle.translation_m - truth_at(w, fix.time_s).translation_m).norm(), 1e-7);
  }
}

TEST(Tracker, CausalFixesUseOnlyThePast) {
  const Deployment d = with_octagon(hall());
  Drive w = drive(d, 40, 1e-5, 1.0, 33);
  const std::vector<Fix> whole = track(w.log, d, {.smooth = false});
  // A shortened drive: fixes before the cut must not change.
  Drive cut = w;
  std::erase_if(cut.log.arrivals, [](const Arrival& a) { return a.time_s > 20; });
  std::erase_if(cut.log.odometry, [](const OdometryStep& s) { return s.time_s > 20.2; });
  const std::vector<Fix> part = track(cut.log, d, {.smooth = false});
  int compared = 0;
  double sum2 = 0.0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    ASSERT_EQ(part[i].time_s, whole[i].time_s);
    ASSERT_EQ(part[i].status, whole[i].status);
    if (!part[i].ok()) continue;
    EXPECT_EQ(part[i].T_map_vehicle.translation_m, whole[i].T_map_vehicle.translation_m);
    sum2 += (part[i].T_map_vehicle.translation_m - truth_at(w, part[i].time_s).translation_m).squaredNorm();
    ++compared;
  }
  ASSERT_GT(compared, 150);
  EXPECT_LT(std::sqrt(sum2 / compared),
            0.008);  // a filter lacks the future half of what a smoother has: sqrt 2, and its start
}

/// One receiver on the axis: only the turns of the odometry determine the heading.
/// Velocities of fixes against the difference of true poses around them.
TEST(Tracker, FixesHaveTheVelocity) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 30, 1e-5, 1.0, 39);
  for (const bool smooth : {true, false}) {
    int count = 0;
    double nees = 0.0;
    for (const Fix& fix : track(w.log, d, {.smooth = smooth})) {
      if (!fix.ok() || fix.time_s < 1.0) continue;
      ASSERT_TRUE(fix.velocity);
      const auto after = std::ranges::lower_bound(w.truth, fix.time_s, {}, &TimedPose::time_s);
      if (after == w.truth.end() || after == w.truth.begin()) continue;
      const auto before = std::prev(after);
      const Pose T = before->T_map_vehicle.inverse() * after->T_map_vehicle;
      Velocity error = fix.velocity->mean;
      error.head<3>() -= T.translation_m / (after->time_s - before->time_s);
      error.tail<3>() -= log_rotation(T.rotation) / (after->time_s - before->time_s);
      for (const int i : {0, 1, 5}) nees += error[i] * error[i] / fix.velocity->variance[i] / 3;
      EXPECT_LT(error.cwiseAbs().maxCoeff(), 0.5);
      ++count;
    }
    ASSERT_GT(count, 200) << smooth;
    EXPECT_LT(nees / count, 2.0) << smooth;
    EXPECT_GT(nees / count, 0.5) << smooth;
  }
}

TEST(Tracker, SingleReceiverNeedsAndGetsAWay) {
  const Deployment d = with_receiver(hall(), {0, 0, 0.3});
  const Drive w = drive(d, 60, 3e-5, 1.0, 34);
  const std::vector<Fix> fixes = track(w.log, d);
  int ok = 0;
  double sum2 = 0.0, heading2 = 0.0;
  for (const Fix& fix : fixes) {
    if (!fix.ok()) continue;
    const Pose truth = truth_at(w, fix.time_s);
    sum2 += (fix.T_map_vehicle.translation_m - truth.translation_m).squaredNorm();
    heading2 += std::pow(wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad()), 2);
    ++ok;
  }
  ASSERT_GT(ok, 400);
  EXPECT_LT(std::sqrt(sum2 / ok), 0.03);      // 10 mm of noise, a beacon at a time
  EXPECT_LT(std::sqrt(heading2 / ok), 0.03);  // 10 mm over the metre that the odometry keeps straight
}

TEST(Tracker, EchoesAndAKidnapping) {
  const Deployment d = with_octagon(hall());
  Drive w = drive(d, 60, 1e-5, 1.0, 35);
  std::mt19937_64 random(35);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (Arrival& a : w.log.arrivals)
    if (uniform(random) < 0.2) a.tof_s += 1e-3 + 8e-3 * uniform(random);
  // The wheels slip by 2 m and half a turn without notice: the filter is lost and must find the pose again.
  w.log.odometry[600].dx_m += 2.0;
  w.log.odometry[600].dheading_rad += 2.5;
  const std::vector<Fix> fixes = track(w.log, d, {.smooth = false});
  int late_good = 0, late_all = 0;
  for (const Fix& fix : fixes) {
    if (fix.time_s < 50 || (!fix.ok() && fix.arrivals_used == 0)) continue;  // echoes alone are no fix
    ++late_all;
    if (fix.ok() && (fix.T_map_vehicle.translation_m - truth_at(w, fix.time_s).translation_m).norm() < 0.05)
      ++late_good;
  }
  EXPECT_GT(late_all, 50);
  EXPECT_GE(late_good, late_all * 95 / 100);
}

TEST(Tracker, NothingToStartFrom) {
  const Deployment d = with_octagon(hall());
  Drive w = drive(d, 10, 1e-5, 1.0, 36);
  w.log.arrivals.resize(5);
  const std::vector<Fix> fixes = track(w.log, d);
  for (const Fix& fix : fixes) EXPECT_FALSE(fix.ok());
  w.log.arrivals.clear();
  EXPECT_TRUE(track(w.log, d).empty());
}

/// The rows of a drive and its arrivals, in the order in which a robot gets them.
template <class Visit>
void replay(const Drive& w, DriveTracker& tracker, Fix& fix, Visit&& visit) {
  const std::vector<OdometryStep>& rows = w.log.odometry;
  std::size_t row = 0;
  for (std::size_t first = 0; first < w.log.arrivals.size();) {
    std::size_t last = first;
    while (last < w.log.arrivals.size() && w.log.arrivals[last].time_s == w.log.arrivals[first].time_s)
      ++last;
    while (row < rows.size() && (row == 0 || rows[row - 1].time_s < w.log.arrivals[first].time_s))
      EXPECT_TRUE(tracker.move(rows[row++]));
    tracker.locate(Observations{std::span(w.log.arrivals).subspan(first, last - first), {}}, fix);
    visit(fix);
    first = last;
  }
}

TEST(DriveTracker, AllocatesNothing) {
  const Deployment d = with_octagon(hall());
  Drive w = drive(d, 60, 1e-5, 1.0, 37);
  // A kidnapping, so that it is lost and searches again.
  w.log.odometry[600].dx_m += 2.0;
  w.log.odometry[600].dheading_rad += 2.5;
  DriveTracker tracker(d, w.log.odometry_accuracy);
  Fix fix;
  fix.rejections.reserve(64);
  std::size_t before = test::allocations(), taken = 0;
  int ok = 0, lost = 0;
  replay(w, tracker, fix, [&](const Fix&) {
    taken += test::allocations() - before;
    if (fix.ok()) {
      ++ok;
    } else if (ok > 0) {
      ++lost;
    }
    before = test::allocations();
  });
  EXPECT_EQ(taken, 0u);
  EXPECT_GT(ok, 500);
  EXPECT_GT(lost, 10);  // the second search took place
}

TEST(DriveTracker, BeginsWhereItIsTold) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 20, 1e-5, 1.0, 38);
  DriveTracker tracker(d, w.log.odometry_accuracy);
  tracker.start(w.truth.front().T_map_vehicle, Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal());
  double sum2 = 0.0;
  int count = 0;
  Fix fix;
  replay(w, tracker, fix, [&](const Fix&) {
    ASSERT_TRUE(fix.ok());
    sum2 += (fix.T_map_vehicle.translation_m - truth_at(w, fix.time_s).translation_m).head<2>().squaredNorm();
    ++count;
  });
  ASSERT_GT(count, 200);
  EXPECT_LT(std::sqrt(sum2 / count), 0.008);  // as CausalFixesUseOnlyThePast
}

}  // namespace tracker_test
}  // namespace octant
