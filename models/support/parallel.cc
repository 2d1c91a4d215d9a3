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

/// Request for helpers. Owned by the caller, and alive until no helper runs it.
struct Job {
  void (*loop)(void* data);
  void* data;
  std::size_t wanted;       ///< helpers that may still begin
  std::size_t running = 0;  ///< helpers that are running
};

class Helpers {
 public:
  /// Threads of this process. Never destroyed, so that they may still wait when the program ends.
  static Helpers& all() {
    static Helpers* const helpers = [] {
      auto* made = new Helpers;
      // After a fork the child has none of the threads. The lock is copied in its current state, and the
      // conditions still count waiters of the parent, so they are created again.
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
  /// If the system cannot create more threads, the existing ones do all the work.
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
  std::deque<Job*> jobs_;             ///< jobs that helpers may still start
  std::size_t count_ = 0, idle_ = 0;  ///< number of threads, and of those that are idle
};

}  // namespace

void run_with_helpers(std::size_t helpers, void (*loop)(void* data), void* data) {
  Job job{loop, data, helpers};
  Helpers::all().run(job);
}

}  // namespace octant
