// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

/// Writes a file completely or not at all: a temporary file in the same folder, flushed to disk, renamed. "-"
/// is standard output; pipes and devices are written directly. The target of a link is replaced, and a file
/// keeps its permissions. Temporary files that killed processes left for this file are removed. Errors:
/// kOutput with the path and the system's reason; an existing file is unchanged. Folders are not created.
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view content);

struct FileContent {
  std::string path, content;
};
/// Writes several files as write_file does, all of them or no file: the first one is replaced after all are
/// on the disk. (If a rename fails after another succeeded, that one remains. Standard output, pipes and
/// devices cannot be undone.)
[[nodiscard]] Result<void> write_files(const std::vector<FileContent>& files);

inline constexpr std::size_t kLargestFile = std::size_t{1} << 30;

/// Content of a regular file. Errors: kBadInput (missing, a folder, unreadable, a loop of links, larger than
/// max_bytes).
[[nodiscard]] Result<std::string> read_file(const std::string& path, std::size_t max_bytes = kLargestFile);

/// Lower-case hexadecimal SHA-256 of bytes.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);

}  // namespace octant::io
