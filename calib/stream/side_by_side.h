// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <mutex>
#include <optional>
#include <thread>

#include "calib/start/progress_monitor.h"
#include "models/support/parallel.h"
#include "models/support/result.h"

namespace octant::calib {

/// Calls work(k, worker) -> Result<void> for k in [first, last) with the given number of parallel workers,
/// including the caller's thread. Errors: the first error of the work; Errc::kInterrupted if the calibration
/// is cancelled. Work that has not begun by then is left out.
template <class Work>
[[nodiscard]] Result<void> for_each_side_by_side(std::size_t first, std::size_t last, std::size_t workers,
                                                 const ProgressMonitor& monitor, Work&& work) {
  std::atomic<std::size_t> next{first};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::optional<Error> error;
  const auto caller = std::this_thread::get_id();
  for_each_parallel(std::min(workers, last - first), static_cast<int>(workers), [&](std::size_t worker) {
    for (std::size_t k = next.fetch_add(1); k < last && !stop; k = next.fetch_add(1)) {
      Result<void> done = work(k, worker);
      if (done && std::this_thread::get_id() == caller && !monitor.go_on()) done = interrupted();
      if (done) continue;
      stop = true;
      const std::lock_guard lock(mutex);
      if (!error) error = done.error();
    }
  });
  if (error) return fail(*error);
  if (!monitor.go_on()) return interrupted();
  return {};
}

}  // namespace octant::calib
