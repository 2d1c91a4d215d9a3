// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "calib/start/progress_monitor.h"
#include "models/support/result.h"

namespace octant::calib {

/// Calls work(k, worker) -> Result<void> for k in [first, last), by so many workers side by side. The
/// caller's thread is one of those that work. Errors: the first of the work's, Errc::kInterrupted where the
/// course is to stop; what has not begun by then is left out.
template <class Work>
[[nodiscard]] Result<void> for_each_side_by_side(std::size_t first, std::size_t last, std::size_t workers,
                                                 const ProgressMonitor& monitor, Work&& work) {
  std::atomic<std::size_t> next{first};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::optional<Error> error;
  std::exception_ptr failure;
  const auto loop = [&](std::size_t worker) {
    try {
      for (std::size_t k = next.fetch_add(1); k < last && !stop; k = next.fetch_add(1)) {
        Result<void> done = work(k, worker);
        if (done && worker == 0 && !monitor.go_on()) done = interrupted();
        if (done) continue;
        stop = true;
        const std::lock_guard lock(mutex);
        if (!error) error = done.error();
      }
    } catch (...) {
      stop = true;
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < workers && first + i < last; ++i) others.emplace_back([&, i] { loop(i); });
  loop(0);
  for (std::thread& thread : others) thread.join();
  if (failure) std::rethrow_exception(failure);
  if (error) return fail(*error);
  if (!monitor.go_on()) return interrupted();
  return {};
}

}  // namespace octant::calib
