// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: opening what the user named, and what to say when that fails.

#include <cstddef>
#include <string>

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

/// A regular file, open for reading.
struct OpenFile {
  Descriptor fd;
  std::size_t size;  ///< when it was opened
};
/// Errors: kBadInput (missing, a folder, a pipe, unreadable, a loop of links, larger than max_bytes).
[[nodiscard]] Result<OpenFile> open_regular(const std::string& path, std::size_t max_bytes);
/// Its content; what was there when it was opened, or less if it has become shorter.
[[nodiscard]] Result<std::string> read_all(const OpenFile& file, const std::string& path);

/// What to do about a system's reason (errno); may be empty.
[[nodiscard]] std::string advice_for(int reason);

}  // namespace octant::io
