// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <barrier>
#include <functional>
#include <thread>
#include <vector>

#include "calib/sums/ranks.h"

namespace octant::test {

/// Ranks that are threads.
class Team {
 public:
  explicit Team(int count) : count_(count), barrier_(count) {}
  class Member : public calib::Ranks {
   public:
    Member(Team& team, int index) : team_(team), index_(index) {}
    [[nodiscard]] int count() const override { return team_.count_; }
    [[nodiscard]] int index() const override { return index_; }
    void sum(std::span<double> values) const override { team_.sum(index_, values); }

   private:
    Team& team_;
    int index_;
  };

 private:
  void sum(int index, std::span<double> values) {
    barrier_.arrive_and_wait();
    if (index == 0) sum_.assign(values.size(), 0.0);
    for (int turn = 0; turn < count_; ++turn) {
      barrier_.arrive_and_wait();
      if (turn == index)
        std::transform(values.begin(), values.end(), sum_.begin(), sum_.begin(), std::plus<>());
    }
    barrier_.arrive_and_wait();
    std::copy(sum_.begin(), sum_.end(), values.begin());
  }
  int count_;
  std::barrier<> barrier_;
  std::vector<double> sum_;
};

/// Runs work(rank) on this number of ranks.
template <class Work>
void for_each_rank(int count, Work&& work) {
  Team team(count);
  std::vector<std::thread> ranks;
  for (int i = 0; i < count; ++i) ranks.emplace_back([&, i] { work(Team::Member(team, i)); });
  for (std::thread& rank : ranks) rank.join();
}

}  // namespace octant::test
