// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>

namespace octant {

/// Has up to `helpers` other threads call loop(data), and calls it itself. Returns when all that began have
/// ended; helpers that have not begun by the time its own call ends are no longer waited for. They are kept
/// for the next time: making one takes as long as a chain of a hundred states, and a new one waits for its
/// turn where a machine is busy.
void run_with_helpers(std::size_t helpers, void (*loop)(void* data), void* data);

/// Calls work(i) for each i below count, on up to `threads` threads (1 or less: on this one; fewer where the
/// system has no more to give). Whoever adds results up does it afterwards, in the order of i, so that no sum
/// depends on the number of threads. What `work` throws first (memory that there is not) comes out here, when
/// all threads have ended; what has not begun by then is left out.
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

/// The same by stretches: work(chunk, first, last) for each [first, last) of up to `size` of `count` items.
[[nodiscard]] constexpr std::size_t chunk_count(std::size_t count, std::size_t size) {
  return (count + size - 1) / size;
}
template <class Work>
void for_each_chunk(std::size_t count, std::size_t size, int threads, Work&& work) {
  for_each_parallel(chunk_count(count, size), threads, [&](std::size_t chunk) {
    work(chunk, chunk * size, std::min(count, (chunk + 1) * size));
  });
}
/// work(i) for each item of each chunk.
template <class Work>
void for_each_in_chunks(std::size_t count, std::size_t size, int threads, Work&& work) {
  for_each_chunk(count, size, threads, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) work(i);
  });
}
inline constexpr std::size_t kArrivalsAtOnce = 65536;  ///< that a thread takes

}  // namespace octant
