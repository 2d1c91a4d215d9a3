// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "models/fix.h"
#include "tests/support/worlds.h"

namespace octant::test {

/// Distance of a fix from the validation truth at its time, in the plane [m].
inline double off_truth_m(const World& world, const Fix& fix) {
  Pose truth;
  EXPECT_TRUE(interpolate_poses(world.heldout.truth, fix.time_s, 1.0, truth));
  return (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>().norm();
}

}  // namespace octant::test
