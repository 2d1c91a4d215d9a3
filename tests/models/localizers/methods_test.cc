// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/methods.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/trajectory/trajectory.h"
#include "tests/models/localizers/drive_world.h"
#include "tests/models/localizers/hall.h"

namespace octant {
namespace methods_test {

using test::drive;
using test::Drive;
using test::hall;
using test::with_receiver;

// One receiver that receives one beacon at a time.
TEST(Methods, ADriveWithoutOdometryIsTrackedWithTheUsualMotion) {
  const Deployment d = with_receiver(hall(), Eigen::Vector3d::Zero());
  Drive w = drive(d, 120, d.noise.tof_sigma_s, 1.0, 31);
  w.log.odometry.clear();
  const MethodChoice choice = choose_method(d, w.log, {});
  EXPECT_EQ(choice.method, Method::kTracker);
  EXPECT_NE(std::string(choice.why).find("assumed"), std::string::npos);
  const auto fixes = locate_run(Method::kAuto, d, w.log, {});
  ASSERT_TRUE(fixes.has_value());
  double squares_m2 = 0.0, nees = 0.0;
  int count = 0;
  for (const Fix& fix : *fixes) {
    Pose truth;
    if (!fix.ok() || !interpolate_poses(w.truth, fix.time_s, 1.0, truth)) continue;
    EXPECT_EQ(fix.protection_level_m, 0.0) << "it would depend on the assumption";
    const Eigen::Vector2d off = (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>();
    squares_m2 += off.squaredNorm();
    nees += off.dot(fix.covariance.topLeftCorner<2, 2>().ldlt().solve(off)) / 2;
    ++count;
  }
  ASSERT_GT(count, 0.9 * static_cast<double>(fixes->size()));
  EXPECT_LT(std::sqrt(squares_m2 / count), 0.1);
  EXPECT_GT(nees / count, 0.05);
  EXPECT_LT(nees / count, 2.5);
}

}  // namespace methods_test
}  // namespace octant
