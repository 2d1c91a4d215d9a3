// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <memory_resource>

namespace octant {

/// Memory for what a fix works on: taken once, used up from the front by one fix, free again for the next.
/// What does not fit comes from the heap, so it bounds no fix; it only is the reason why a robot's fixes take
/// no memory of their own.
class Scratch {
 public:
  explicit Scratch(std::size_t bytes);

 private:
  friend class ScratchScope;
  std::unique_ptr<std::byte[]> buffer_;
  std::pmr::monotonic_buffer_resource resource_;
};

/// While it lives, `scratch()` of this thread hands out that memory; all of it is free again when it ends.
class ScratchScope {
 public:
  explicit ScratchScope(Scratch& scratch);
  ~ScratchScope();
  ScratchScope(const ScratchScope&) = delete;
  ScratchScope& operator=(const ScratchScope&) = delete;

 private:
  Scratch& scratch_;
  std::pmr::memory_resource* outer_;
};

/// Where vectors that live no longer than a fix get their memory: the innermost scope's, or the heap where
/// there is none.
[[nodiscard]] std::pmr::memory_resource* scratch();

}  // namespace octant
