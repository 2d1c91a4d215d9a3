// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/ordered_work.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace octant::io {

OrderedWork::OrderedWork(std::size_t tasks, int threads, Task task, std::function<void()> beside)
    : tasks_(tasks),
      slots_(slots(threads)),
      task_(std::move(task)),
      beside_(std::move(beside)),
      done_(slots_, 0) {
  const std::size_t useful = std::min(slots_, tasks + (beside_ ? 1 : 0));
  const std::size_t wanted = std::min<std::size_t>(static_cast<std::size_t>(std::max(1, threads)), useful);
  try {
    for (std::size_t i = 1; i < wanted; ++i) threads_.emplace_back([this] { run(); });
  } catch (const std::system_error&) {
    // The system has no more threads to give: those that there are do it all.
  }
}

OrderedWork::~OrderedWork() {
  stop();
  join();
}

void OrderedWork::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
}

void OrderedWork::join() {
  for (auto& thread : threads_) thread.join();
  threads_.clear();
}

void OrderedWork::finish() {
  stop();
  join();
  if (const auto beside = std::exchange(beside_, nullptr)) beside();
}

void OrderedWork::do_one(std::unique_lock<std::mutex>& lock) {
  const std::size_t task = begun_++;
  lock.unlock();
  std::exception_ptr failure;
  try {
    task_(task, task % slots_);
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  if (failure && !failure_) failure_ = failure;
  done_[task % slots_] = 1;
  changed_.notify_all();
}

void OrderedWork::run() {
  std::unique_lock lock(mutex_);
  if (const auto beside = std::exchange(beside_, nullptr)) {
    lock.unlock();
    beside();
    lock.lock();
  }
  for (;;) {
    changed_.wait(lock, [this] { return stopped_ || begun_ == tasks_ || may_begin(); });
    if (!may_begin()) return;
    do_one(lock);
  }
}

bool OrderedWork::wait() {
  std::unique_lock lock(mutex_);
  if (taken_ == tasks_) return false;
  while (done_[slot()] == 0 && !failure_) {
    if (may_begin()) {
      do_one(lock);
    } else {
      changed_.wait(lock);
    }
  }
  if (failure_) std::rethrow_exception(failure_);
  return true;
}

void OrderedWork::release() {
  {
    const std::lock_guard lock(mutex_);
    done_[slot()] = 0;
    ++taken_;
  }
  changed_.notify_all();
}

}  // namespace octant::io
