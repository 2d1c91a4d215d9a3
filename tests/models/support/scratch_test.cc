// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/scratch.h"

#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_count.h"

namespace octant::test {
namespace scratch_test {

using Doubles = std::pmr::vector<double>;

TEST(Scratch, IsTheHeapWhereThereIsNoScope) {
  EXPECT_EQ(scratch(), std::pmr::new_delete_resource());
  Scratch memory(1000);
  {
    const ScratchScope scope(memory);
    EXPECT_NE(scratch(), std::pmr::new_delete_resource());
  }
  EXPECT_EQ(scratch(), std::pmr::new_delete_resource());
}

TEST(Scratch, TakesNothingFromTheHeapFixAfterFix) {
  Scratch memory(64 * 1024);
  const std::size_t before = allocations();
  double sum = 0.0;
  for (int fix = 0; fix < 100; ++fix) {  // 100 times 40 kB
    const ScratchScope scope(memory);
    const Doubles work(5000, 1.0, scratch());
    sum += work[17];
  }
  EXPECT_EQ(allocations(), before);
  EXPECT_EQ(sum, 100.0);
}

TEST(Scratch, WhatDoesNotFitComesFromTheHeapAndWorks) {
  Scratch memory(100);
  const ScratchScope scope(memory);
  const std::size_t before = allocations();
  Doubles work(scratch());
  for (int i = 0; i < 10000; ++i) work.push_back(i);
  EXPECT_GT(allocations(), before);
  EXPECT_EQ(work[9999], 9999.0);
}

TEST(Scratch, ScopesNest) {
  Scratch outer(1000), inner(1000);
  const ScratchScope first(outer);
  std::pmr::memory_resource* const of_first = scratch();
  {
    const ScratchScope second(inner);
    EXPECT_NE(scratch(), of_first);
  }
  EXPECT_EQ(scratch(), of_first);
}

TEST(Scratch, IsTheThreadsOwn) {
  Scratch memory(1000);
  const ScratchScope scope(memory);
  std::pmr::memory_resource* there = nullptr;
  std::thread([&] { there = scratch(); }).join();
  EXPECT_EQ(there, std::pmr::new_delete_resource());
}

}  // namespace scratch_test
}  // namespace octant::test
