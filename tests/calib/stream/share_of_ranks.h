// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

#include "calib/streamed.h"
#include "tests/calib/memory_source.h"
#include "tests/calib/thread_team.h"
#include "tests/support/worlds.h"

namespace octant::test {

/// Each of several ranks reads its share of a recording, and all have the result of a single one.
/// @param memory    bytes of arrivals at a time
/// @param distance  distance of two solutions, zero if they are equal
/// @param within    largest distance from the single one
template <class Distance>
void expect_ranks_to_share_and_agree(const World& world, std::size_t memory,
                                     std::initializer_list<int> counts, Distance&& distance, double within) {
  // Data that are read several times, after the part is known.
  const auto rows_of_passes = [&](calib::SolveOptions options, calib::Solution& answer) {
    MemorySource source(std::vector<MeasurementLog>{world.run}, 300);
    std::size_t before = 0;
    options.on_progress = [&](const calib::Progress& p) {
      if (p.stage == "states of the whole log" && before == 0) before = source.rows_read;
      return true;
    };
    answer = must(calib::solve_streamed(world.site, source, options, memory)).solution;
    return source.rows_read - before;
  };
  calib::Solution one;
  const std::size_t all_rows = rows_of_passes({}, one);
  for (const int count : counts) {
    const auto ranks = static_cast<std::size_t>(count);
    std::vector<calib::Solution> answers(ranks);
    std::vector<std::size_t> rows(ranks);
    for_each_rank(count, [&](const calib::Ranks& rank) {
      calib::SolveOptions options;
      options.ranks = &rank;
      const auto i = static_cast<std::size_t>(rank.index());
      rows[i] = rows_of_passes(options, answers[i]);
    });
    for (const calib::Solution& answer : answers) {
      ASSERT_EQ(answer.status, calib::SolveStatus::kConverged) << answer.message;
      EXPECT_LT(distance(one, answer), within);
      EXPECT_NEAR(answer.statistics.variance_factor, one.statistics.variance_factor, 1e-12);
      EXPECT_EQ(answer.statistics.rejected, one.statistics.rejected);
      EXPECT_EQ(answer.statistics.unknowns, one.statistics.unknowns);
      EXPECT_EQ(answer.warnings, one.warnings);
      EXPECT_EQ(answer.reliability.arrivals.size(), one.reliability.arrivals.size());
      EXPECT_EQ(distance(answers[0], answer), 0.0) << "ranks must decide alike";
    }
    for (const std::size_t r : rows) EXPECT_LT(r, all_rows * 3 / 2 / ranks);
  }
}

}  // namespace octant::test
