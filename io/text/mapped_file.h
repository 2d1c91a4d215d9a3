// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: a file as a text in memory that costs no copy.

#include <cstddef>
#include <string>
#include <string_view>

#include "models/support/result.h"

namespace octant::io {

/// A regular file, mapped; read into memory where the system cannot map it (empty files, some network file
/// systems). Nobody may shorten the file meanwhile: what is appended to a log after it was opened is not seen
/// and does no harm.
class MappedFile {
 public:
  static constexpr std::size_t kLargest = std::size_t{1} << 40;
  /// Errors: those of read_file().
  [[nodiscard]] static Result<MappedFile> open(const std::string& path);
  MappedFile(MappedFile&& other) noexcept;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  [[nodiscard]] std::string_view text() const {
    return map_ != nullptr ? std::string_view(map_, size_) : std::string_view(copy_);
  }
  /// Gives the memory of the pages that end in [begin, end) back to the system; whoever looks again finds
  /// them again.
  void release(std::size_t begin, std::size_t end) const;

 private:
  MappedFile(const char* map, std::size_t size, std::string copy)
      : map_(map), size_(size), copy_(std::move(copy)) {}

  const char* map_;  // null: not mapped
  std::size_t size_;
  std::string copy_;
};

}  // namespace octant::io
