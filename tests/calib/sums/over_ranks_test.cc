// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Ranks as threads.
#include "calib/sums/over_ranks.h"

#include <mutex>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/calib/thread_team.h"

namespace octant::test {
namespace over_ranks_test {

RC_GTEST_PROP(PartsOf, RanksCoverAllPartsAndNoneTwice, ()) {
  const int ranks = *rc::gen::inRange(1, 9);
  const auto parts = static_cast<std::size_t>(*rc::gen::inRange(0, 100));
  Team team(ranks);
  std::size_t next = 0;
  for (int i = 0; i < ranks; ++i) {
    const Team::Member member(team, i);
    const auto [first, last] = calib::parts_of(&member, parts);
    RC_ASSERT(first == next && last >= first);
    RC_ASSERT(last - first <= parts / static_cast<std::size_t>(ranks) + 1);  // as many each
    next = last;
  }
  RC_ASSERT(next == parts);
}

TEST(PartsOf, AloneHasAll) {
  EXPECT_EQ(calib::parts_of(nullptr, 7), (std::pair<std::size_t, std::size_t>(0, 7)));
}

/// Part k is k numbers long.
std::vector<double> part(std::size_t k) { return std::vector<double>(k, static_cast<double>(k) + 0.5); }

TEST(InOrder, ListsOfAllPartsStandOneBehindTheOtherOnEveryRank) {
  std::vector<double> want;
  std::vector<std::vector<double>> all;
  for (std::size_t k = 0; k < 11; ++k) {
    all.push_back(part(k));
    want.insert(want.end(), k, static_cast<double>(k) + 0.5);
  }
  EXPECT_EQ(calib::in_order(nullptr, all), want);
  for (const int ranks : {1, 3, 15}) {  // of fifteen some have none
    std::mutex mutex;
    int equal = 0;
    for_each_rank(ranks, [&](const calib::Ranks& rank) {
      const auto [first, last] = calib::parts_of(&rank, 11);
      std::vector<std::vector<double>> mine;
      for (std::size_t k = first; k < last; ++k) mine.push_back(part(k));
      const std::vector<double> here = calib::in_order(&rank, std::move(mine));
      const std::lock_guard lock(mutex);
      equal += here == want;
    });
    EXPECT_EQ(equal, ranks);
  }
}

// Some ranks have no part; for an empty log no rank has one.
TEST(SumOverRanks, SystemsOfOtherColumnsAddUp) {
  for (const bool is_empty : {false, true}) {
    std::mutex mutex;
    std::vector<Eigen::MatrixXd> sums;
    for_each_rank(4, [&](const calib::Ranks& rank) {
      calib::SystemParts parts;
      if (!is_empty && rank.index() != 1) {
        calib::SystemPart part = calib::empty_part({rank.index(), rank.index() + 1});
        part.system.H << 2.0, 1.0, 1.0, 3.0;
        part.system.gradient << 1.0, -1.0;
        part.system.cost = 1.0;
        parts.add(part);
      }
      calib::sum_over(&rank, parts);
      const calib::ReducedSystem whole = parts.whole(5);
      const std::lock_guard lock(mutex);
      EXPECT_EQ(whole.cost, is_empty ? 0.0 : 3.0);
      EXPECT_EQ(whole.gradient,
                is_empty ? Eigen::VectorXd::Zero(5)
                         : Eigen::VectorXd(Eigen::VectorXd::Unit(5, 0) - Eigen::VectorXd::Unit(5, 1) +
                                           Eigen::VectorXd::Unit(5, 2) - Eigen::VectorXd::Unit(5, 4)));
      sums.push_back(whole.H);
    });
    Eigen::MatrixXd want = Eigen::MatrixXd::Zero(5, 5);
    for (const int k : {0, 2, 3})
      if (!is_empty) want.block<2, 2>(k, k) += (Eigen::Matrix2d() << 2.0, 1.0, 1.0, 3.0).finished();
    for (const Eigen::MatrixXd& sum : sums) EXPECT_EQ(sum, want);
  }
}

}  // namespace over_ranks_test
}  // namespace octant::test
