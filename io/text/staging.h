// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace octant::io {

/// A new temporary name next to the target: TARGET.PID.COUNT.tmp, different at each call.
[[nodiscard]] std::string staging_name(const std::string& target);

/// Removes files and folders that killed processes staged for a target: those whose process has ended and
/// that are not locked (processes on other machines or in other containers lock theirs).
void remove_stale_beside(const std::string& target);

/// A folder that is being made under such a name; gone with its content unless it is kept.
class StagedFolder {
 public:
  /// @param path  an existing folder; it is locked, so that no other process removes it as an abandoned one
  explicit StagedFolder(std::filesystem::path path);
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  void keep() { path_.clear(); }

 private:
  std::filesystem::path path_;
  int lock_ = -1;  ///< file descriptor
};

}  // namespace octant::io
