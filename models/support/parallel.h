// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>

namespace octant {

/// Runs loop(data) on up to `helpers` other threads and on this one. Returns when all started calls have
/// finished. Helpers that have not started by the time this thread's own call ends are not waited for. The
/// threads are kept for later calls, because creating one costs as much as solving a chain of a hundred
/// states.
void run_with_helpers(std::size_t helpers, void (*loop)(void* data), void* data);

/// Calls work(i) for each i below count on up to `threads` threads (1 or less: this thread only; fewer if the
/// system cannot create them). Sum up results afterwards in the order of i, so that sums do not depend on the
/// number of threads. The first exception of `work` is rethrown after all threads have ended; calls that had
/// not started by then are skipped.
template <class Work>
void for_each_parallel(std::size_t count, int threads, Work&& work) {
  const std::size_t helpers = std::min(count, static_cast<std::size_t>(std::max(threads, 1)));
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr failure;
  auto loop = [&]() noexcept {
    try {
      for (std::size_t i = next.fetch_add(1); i < count && !failed; i = next.fetch_add(1)) work(i);
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  };
  if (helpers > 1)
    run_with_helpers(
        helpers - 1, [](void* data) { (*static_cast<decltype(loop)*>(data))(); }, &loop);
  else
    loop();
  if (failure) std::rethrow_exception(failure);
}

/// Splits `count` items into chunks of up to `size` and calls work(chunk, first, last) for each [first,
/// last).
[[nodiscard]] constexpr std::size_t chunk_count(std::size_t count, std::size_t size) {
  return (count + size - 1) / size;
}
template <class Work>
void for_each_chunk(std::size_t count, std::size_t size, int threads, Work&& work) {
  for_each_parallel(chunk_count(count, size), threads, [&](std::size_t chunk) {
    work(chunk, chunk * size, std::min(count, (chunk + 1) * size));
  });
}
/// Calls work(i) for each item of each chunk.
template <class Work>
void for_each_in_chunks(std::size_t count, std::size_t size, int threads, Work&& work) {
  for_each_chunk(count, size, threads, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) work(i);
  });
}
inline constexpr std::size_t kArrivalsAtOnce = 65536;  ///< number of arrivals in a chunk

}  // namespace octant
