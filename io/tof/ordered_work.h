// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: work on the pieces of a file in parallel, results in the order of the pieces.

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace octant::io {

/// Does tasks 0, 1, ... on several threads and hands their results over in that order. There are a few slots
/// for results, so that work is never far ahead of whoever takes them. The caller's own thread is one of the
/// threads: while it waits, it works.
///   OrderedWork work(tasks, threads, [&](std::size_t task, std::size_t slot) { ... });
///   while (work.wait()) { ... work.slot() ...; work.release(); }
/// What a task throws, wait() throws.
class OrderedWork {
 public:
  using Task = std::function<void(std::size_t task, std::size_t slot)>;
  /// @param beside  something else to be done once, by another thread where there is one
  OrderedWork(std::size_t tasks, int threads, Task task, std::function<void()> beside = {});
  /// Waits for what has begun; the rest is not done.
  ~OrderedWork();
  OrderedWork(const OrderedWork&) = delete;
  OrderedWork& operator=(const OrderedWork&) = delete;

  [[nodiscard]] static std::size_t slots(int threads) {
    return threads > 1 ? 2 * static_cast<std::size_t>(threads) : 1;
  }
  /// Waits until the next task in order is done; false after the last.
  [[nodiscard]] bool wait();
  [[nodiscard]] std::size_t slot() const { return taken_ % slots_; }
  /// Its result has been used.
  void release();
  /// Begins no more tasks.
  void stop();
  /// Waits until `beside` is done; begins no more tasks.
  void finish();

 private:
  void run();
  void join();
  [[nodiscard]] bool may_begin() const { return !stopped_ && begun_ < tasks_ && begun_ < taken_ + slots_; }
  void do_one(std::unique_lock<std::mutex>& lock);

  const std::size_t tasks_, slots_;
  Task task_;
  std::function<void()> beside_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t begun_ = 0, taken_ = 0;
  bool stopped_ = false;
  std::vector<char> done_;  // by slot
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace octant::io
