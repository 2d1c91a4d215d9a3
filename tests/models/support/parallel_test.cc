// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/parallel.h"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <new>
#include <set>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace octant::test {
namespace parallel_test {

TEST(Parallel, EachIsDoneOnceOnAnyNumberOfThreads) {
  for (const int threads : {-3, 0, 1, 2, 7}) {
    std::vector<std::atomic<int>> times(50);
    for_each_parallel(times.size(), threads, [&](std::size_t i) { ++times[i]; });
    for (const auto& t : times) EXPECT_EQ(t, 1);
  }
}

TEST(Parallel, NoMoreThreadsThanThereIsToDo) {
  std::mutex mutex;
  std::set<std::thread::id> ids;
  for_each_parallel(2, 64, [&](std::size_t) {
    const std::lock_guard lock(mutex);
    ids.insert(std::this_thread::get_id());
  });
  EXPECT_LE(ids.size(), 2U);
  int calls = 0;
  for_each_parallel(0, 8, [&](std::size_t) { ++calls; });
  EXPECT_EQ(calls, 0);
}

TEST(Parallel, WhatIsThrownComesOutAndWhatHasNotBegunIsLeft) {
  int begun = 0;
  EXPECT_THROW(for_each_parallel(1000, 1,
                                 [&](std::size_t i) {
                                   ++begun;
                                   if (i == 5) throw std::bad_alloc();
                                 }),
               std::bad_alloc);
  EXPECT_EQ(begun, 6);
}

TEST(Parallel, WhatOneThreadThrowsEndsTheOthers) {
  std::atomic<int> done{0};
  std::atomic<bool> thrown{false};
  const auto work = [&](std::size_t i) {
    if (i == 5) {
      thrown = true;
      throw std::bad_alloc();
    }
    while (i > 5 && !thrown) std::this_thread::yield();
    if (i > 5) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ++done;
  };
  EXPECT_THROW(for_each_parallel(1000, 3, work), std::bad_alloc);
  EXPECT_LT(done, 999) << "all but the one that threw";
}

RC_GTEST_PROP(Chunks, CoverAllItemsOnceInOrder, ()) {
  const auto count = static_cast<std::size_t>(*rc::gen::inRange(0, 1000)),
             size = static_cast<std::size_t>(*rc::gen::inRange(1, 300));
  std::vector<std::pair<std::size_t, std::size_t>> stretches(chunk_count(count, size));
  for_each_chunk(count, size, 3, [&](std::size_t chunk, std::size_t first, std::size_t last) {
    stretches[chunk] = {first, last};
  });
  std::size_t next = 0;
  for (const auto& [first, last] : stretches) {
    RC_ASSERT(first == next && last > first && last - first <= size);
    next = last;
  }
  RC_ASSERT(next == count);
}

TEST(Parallel, WhatIsDoneInParallelMayDoSoItself) {
  std::vector<std::atomic<int>> times(40);
  for_each_parallel(
      8, 4, [&](std::size_t i) { for_each_parallel(5, 3, [&](std::size_t k) { ++times[5 * i + k]; }); });
  for (const auto& t : times) EXPECT_EQ(t, 1);
}

TEST(Parallel, SeveralMayAskAtOnce) {
  std::atomic<long> sum{0};
  std::vector<std::thread> callers;
  for (int c = 0; c < 6; ++c)
    callers.emplace_back([&] {
      for (int k = 0; k < 300; ++k)
        for_each_parallel(7, 3, [&](std::size_t i) { sum += static_cast<long>(i); });
    });
  for (std::thread& t : callers) t.join();
  EXPECT_EQ(sum, 6 * 300 * 21);
}

TEST(Parallel, HelpersStayForTheNextTime) {
  std::mutex mutex;
  std::set<std::thread::id> ids;
  for (int k = 0; k < 200; ++k)
    for_each_parallel(4, 3, [&](std::size_t) {
      const std::lock_guard lock(mutex);
      ids.insert(std::this_thread::get_id());
    });
  EXPECT_LE(ids.size(), 20U) << "a thread is made for each call";  // those of the tests before among them
}

TEST(Parallel, AForkedProcessHasItsOwn) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer starts no thread after a fork";
#endif
  for_each_parallel(4, 4, [](std::size_t) {});
  const pid_t child = fork();
  if (child == 0) {
    std::atomic<int> done{0};
    for_each_parallel(100, 4, [&](std::size_t) { ++done; });
    _exit(done == 100 ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace parallel_test
}  // namespace octant::test
