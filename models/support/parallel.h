// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace octant {

/// Calls work(i) for each i below count, on up to `threads` threads (1 or less: on this one). Whoever adds
/// results up does it afterwards, in the order of i, so that no sum depends on the number of threads. `work`
/// must not throw.
template <class Work>
void for_each_parallel(std::size_t count, int threads, Work&& work) {
  const std::size_t helpers = std::min(count, static_cast<std::size_t>(std::max(threads, 1)));
  std::atomic<std::size_t> next{0};
  const auto loop = [&] {
    for (std::size_t i = next.fetch_add(1); i < count; i = next.fetch_add(1)) work(i);
  };
  std::vector<std::thread> others;
  for (std::size_t k = 1; k < helpers; ++k) others.emplace_back(loop);
  loop();
  for (std::thread& thread : others) thread.join();
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
inline constexpr std::size_t kArrivalsAtOnce = 65536;  ///< that a thread takes

}  // namespace octant
