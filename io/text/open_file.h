// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: opens files named by the user, with error messages.

#include <cstddef>
#include <string>
#include <string_view>

#include "models/support/result.h"

namespace octant::io {

/// Closes a descriptor at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(Descriptor&& other) noexcept;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] bool close_now();

 private:
  int fd_;
};

/// A regular file that is open for reading.
struct OpenFile {
  Descriptor fd;
  std::size_t size;  ///< when it was opened
};
/// Errors: kBadInput (missing, a folder, a pipe, unreadable, a loop of links, larger than max_bytes).
[[nodiscard]] Result<OpenFile> open_regular(const std::string& path, std::size_t max_bytes);
/// Its content when it was opened, or less if it has become shorter.
[[nodiscard]] Result<std::string> read_all(const OpenFile& file, const std::string& path);

/// Advice for a system error (errno); may be empty.
[[nodiscard]] std::string advice_for(int reason);

/// A regular file, mapped; read into memory if the system cannot map it (empty files, some network file
/// systems). The file must not be shortened in the meantime. Data appended after opening are ignored.
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
  /// Releases the memory of the pages that end in [begin, end); they are read again on the next access.
  void release(std::size_t begin, std::size_t end) const;

 private:
  MappedFile(const char* map, std::size_t size, std::string copy)
      : map_(map), size_(size), copy_(std::move(copy)) {}

  const char* map_;  // null: not mapped
  std::size_t size_;
  std::string copy_;
};

}  // namespace octant::io
