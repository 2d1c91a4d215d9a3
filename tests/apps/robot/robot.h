// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "apps/robot/octant/positioner.h"
#include "io/deployment/deployment_json.h"
#include "tests/io/io_support.h"
#include "tests/support/worlds.h"

namespace octant::test {

/// Deployment file of a world, and its arrivals by name.
class Robot {
 public:
  explicit Robot(const World& world) : names_(names_of(world.truth)) {
    EXPECT_TRUE(io::write_deployment(path(), world.truth));
  }
  [[nodiscard]] std::string path() const { return folder_.path("deployment.json"); }

  [[nodiscard]] Heard heard(const Arrival& a) const {
    return {.beacon = names_.beacons[a.beacon.index()],
            .tof_s = a.tof_s,
            .receiver = names_.receivers[a.receiver.index()].name,
            .time_s = a.time_s,
            .epoch = a.epoch == kNoEpoch ? Heard::kNone : a.epoch};
  }

 private:
  io::test::TemporaryFolder folder_;
  NameTable names_;
};

}  // namespace octant::test
