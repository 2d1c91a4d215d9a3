// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/parallel.h"

#include <pthread.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <new>
#include <thread>

namespace octant {
namespace {

/// What helpers are asked for; stands with whoever asks, until no one is at it.
struct Job {
  void (*loop)(void* data);
  void* data;
  std::size_t wanted;       ///< helpers that may still begin
  std::size_t running = 0;  ///< helpers that are at it
};

class Helpers {
 public:
  /// Those of this process, never destroyed: they wait where they are when the program ends.
  static Helpers& all() {
    static Helpers* const helpers = [] {
      auto* made = new Helpers;
      // A fork has none of the threads, the lock as it was, and conditions that still count the parent's
      // waiters: who would wake these waits for them to leave.
      pthread_atfork([] { all().mutex_.lock(); }, [] { all().mutex_.unlock(); },
                     [] {
                       all().count_ = all().idle_ = 0;
                       all().jobs_.clear();
                       new (&all().work_) std::condition_variable;
                       new (&all().done_) std::condition_variable;
                       all().mutex_.unlock();
                     });
      return made;
    }();
    return *helpers;
  }

  void run(Job& job) {
    const bool is_one = job.wanted == 1;
    {
      const std::lock_guard lock(mutex_);
      make(job.wanted);
      jobs_.push_back(&job);
    }
    if (is_one)
      work_.notify_one();
    else
      work_.notify_all();
    job.loop(job.data);
    std::unique_lock lock(mutex_);
    std::erase(jobs_, &job);
    done_.wait(lock, [&job] { return job.running == 0; });
  }

 private:
  /// Where the system has no more threads to give, those that there are do it all.
  void make(std::size_t wanted) {
    try {
      for (; count_ < kMost && idle_ < wanted; ++count_, ++idle_) std::thread([this] { serve(); }).detach();
    } catch (const std::exception&) {
    }
  }

  [[noreturn]] void serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
      work_.wait(lock, [this] { return !jobs_.empty(); });
      Job& job = *jobs_.front();
      if (--job.wanted == 0) jobs_.pop_front();
      ++job.running;
      --idle_;
      lock.unlock();
      job.loop(job.data);
      lock.lock();
      ++idle_;
      if (--job.running == 0) done_.notify_all();
    }
  }

  static constexpr std::size_t kMost = 1024;

  std::mutex mutex_;
  std::condition_variable work_, done_;
  std::deque<Job*> jobs_;             ///< that helpers may still begin
  std::size_t count_ = 0, idle_ = 0;  ///< threads, and those that wait or are about to
};

}  // namespace

void run_with_helpers(std::size_t helpers, void (*loop)(void* data), void* data) {
  Job job{loop, data, helpers};
  Helpers::all().run(job);
}

}  // namespace octant
