// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/side_by_side.h"

#include <atomic>
#include <set>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace octant::test {
namespace side_by_side_test {

const calib::SolveOptions kNobodyListens;

TEST(SideBySide, EachPartIsWorkedOnOnceByOneOfTheWorkers) {
  const calib::ProgressMonitor monitor(kNobodyListens);
  for (const std::size_t workers : {1U, 3U, 40U}) {
    std::vector<std::atomic<int>> times(25);
    std::atomic<bool> beyond{false};
    const Result<void> done = calib::for_each_side_by_side(
        5, 25, workers, monitor, [&](std::size_t k, std::size_t worker) -> Result<void> {
          ++times[k];
          if (worker >= workers) beyond = true;
          return {};
        });
    EXPECT_TRUE(done.has_value());
    EXPECT_FALSE(beyond);
    for (std::size_t k = 0; k < times.size(); ++k) EXPECT_EQ(times[k], k >= 5 ? 1 : 0) << k;
  }
}

TEST(SideBySide, OfNoPartsNothingIsDone) {
  const calib::ProgressMonitor monitor(kNobodyListens);
  int calls = 0;
  EXPECT_TRUE(calib::for_each_side_by_side(7, 7, 3, monitor, [&](std::size_t, std::size_t) -> Result<void> {
    ++calls;
    return {};
  }));
  EXPECT_EQ(calls, 0);
}

TEST(SideBySide, AnErrorEndsItAndComesOut) {
  const calib::ProgressMonitor monitor(kNobodyListens);
  for (const std::size_t workers : {1U, 3U}) {
    std::atomic<int> begun{0};
    const Result<void> done = calib::for_each_side_by_side(
        0, 1000, workers, monitor, [&](std::size_t k, std::size_t) -> Result<void> {
          ++begun;
          if (k == 3) return fail({.code = Errc::kBadInput, .found = "a row is gone"});
          return {};
        });
    ASSERT_FALSE(done.has_value());
    EXPECT_EQ(done.error().found, "a row is gone");
    if (workers == 1) EXPECT_EQ(begun, 4) << "what has not begun is left out";
  }
}

TEST(SideBySide, WhatIsThrownComesOutWhenAllHaveEnded) {
  const calib::ProgressMonitor monitor(kNobodyListens);
  for (const std::size_t workers : {1U, 3U})
    EXPECT_THROW(
        static_cast<void>(calib::for_each_side_by_side(0, 50, workers, monitor,
                                                       [](std::size_t k, std::size_t) -> Result<void> {
                                                         if (k == 20) throw std::runtime_error("no memory");
                                                         return {};
                                                       })),
        std::runtime_error);
}

TEST(SideBySide, StopsWhereItIsAskedTo) {
  int asked = 0;
  calib::SolveOptions options;
  options.on_progress = [&](const calib::Progress&) { return ++asked < 4; };
  const calib::ProgressMonitor monitor(options);
  int begun = 0;
  const Result<void> done = calib::for_each_side_by_side(0, 1000, 1, monitor, [&](std::size_t, std::size_t) {
    ++begun;
    return Result<void>();
  });
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().code, Errc::kInterrupted);
  EXPECT_EQ(begun, 4);
}

TEST(SideBySide, OfNoPartsAWishToStopCountsToo) {
  calib::SolveOptions options;
  options.on_progress = [](const calib::Progress&) { return false; };
  const calib::ProgressMonitor monitor(options);
  const Result<void> done =
      calib::for_each_side_by_side(0, 0, 2, monitor, [](std::size_t, std::size_t) { return Result<void>(); });
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().code, Errc::kInterrupted);
}

}  // namespace side_by_side_test
}  // namespace octant::test
