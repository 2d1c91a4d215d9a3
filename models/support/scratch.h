// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <memory_resource>

namespace octant {

/// Preallocated memory for the temporary data of a fix. It is filled from the front and becomes free again
/// for the next fix. Requests beyond its size are served from the heap, so the size does not limit a fix. It
/// only lets a robot's fixes run without allocation.
class Scratch {
 public:
  explicit Scratch(std::size_t bytes);

 private:
  friend class ScratchScope;
  std::unique_ptr<std::byte[]> buffer_;
  std::pmr::monotonic_buffer_resource resource_;
};

/// During its lifetime scratch() of this thread returns the given memory; afterwards all of it is free again.
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

/// Memory resource for vectors that live no longer than a fix: that of the innermost scope, or the heap
/// outside any scope.
[[nodiscard]] std::pmr::memory_resource* scratch();

}  // namespace octant
