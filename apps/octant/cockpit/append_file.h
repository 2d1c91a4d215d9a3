// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "models/support/result.h"

namespace octant::app {

/// A table to which rows are appended so that a killed process leaves complete rows only. The system writes
/// page by page, and a kill can end a write between two pages. A row that would cross a page therefore begins
/// on the next one, after blank lines, which readers skip.
class AppendFile {
 public:
  /// @param header  first row of a new file
  AppendFile(std::string path, std::string header) : path_(std::move(path)), header_(std::move(header)) {}
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Adds a row with its newline; flush() writes it. @return false if too many rows wait already
  [[nodiscard]] bool add(std::string_view row);
  /// Writes the added rows. After an error the rest is written by the next call.
  [[nodiscard]] Result<void> flush();
  /// A copy of the descriptor, with which another thread waits for the disk; -1 if the file is not open. The
  /// caller closes it.
  [[nodiscard]] int duplicate() const;
  /// Continues with a file that has replaced this one, or that is gone.
  void reopen();
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  [[nodiscard]] Result<void> open();
  std::string path_, header_, pending_;
  int fd_ = -1;
  std::size_t size_ = 0;  ///< of the file with the pending rows
};

}  // namespace octant::app
