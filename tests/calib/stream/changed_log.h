// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/streamed.h"
#include "tests/calib/memory_source.h"
#include "tests/support/worlds.h"

namespace octant::test {

/// A recording in which rows are missing in a later pass, within eight megabytes.
inline void expect_a_changed_log_to_be_an_error(const World& world) {
  MemorySource source(std::vector<MeasurementLog>{world.run}, 300);
  calib::SolveOptions options;
  options.on_progress = [&](const calib::Progress& p) {
    source.forgets = p.stage == "states of the whole log";
    return true;
  };
  const auto answer = calib::solve_streamed(world.site, source, options, 8U << 20U);
  ASSERT_FALSE(answer);
  EXPECT_THAT(answer.error().message(), ::testing::HasSubstr("changed"));
}

}  // namespace octant::test
