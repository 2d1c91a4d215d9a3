// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace octant::io {

/// A name for what will become the target, beside it: TARGET.PID.COUNT.tmp, another one at each call.
[[nodiscard]] std::string staging_name(const std::string& target);

/// Removes what processes that were killed left beside a target: files and folders staged for it whose
/// process is gone and that nobody holds (a process on another machine, or in another container, locks its
/// own).
void remove_stale_beside(const std::string& target);

/// A folder that is being made under such a name; gone with its content unless it is kept.
class StagedFolder {
 public:
  /// @param path  a folder that is there; it is locked, so that nobody takes it for one that was left behind
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
