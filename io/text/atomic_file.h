// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

/// Writes a file whole or not at all: a temporary file beside it, flushed to disk, renamed over it. "-" is
/// standard output; pipes and devices are written in place. A link keeps pointing where it did, a file keeps
/// its permissions. What killed processes left beside it under such a temporary name is removed. Errors:
/// kOutput with the path and the system's reason; the file that was there stays as it was. Folders are not
/// created.
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view content);

struct FileContent {
  std::string path, content;
};
/// Several files, each as write_file does it, all or none: none is replaced before all of them lie on the
/// disk. (Only where a rename fails after another went through does one stay; what goes to standard output,
/// pipes and devices cannot be taken back.)
[[nodiscard]] Result<void> write_files(const std::vector<FileContent>& files);

inline constexpr std::size_t kLargestFile = std::size_t{1} << 30;

/// Content of a regular file. Errors: kBadInput (missing, a folder, unreadable, a loop of links, larger than
/// max_bytes).
[[nodiscard]] Result<std::string> read_file(const std::string& path, std::size_t max_bytes = kLargestFile);

/// Lower-case hexadecimal SHA-256 of bytes.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);

}  // namespace octant::io
