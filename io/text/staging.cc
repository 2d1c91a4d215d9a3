// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/staging.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "io/text/open_file.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

/// Process that staged a file of that name for the target; no value for other names.
std::optional<pid_t> stager_of(std::string_view name, std::string_view target) {
  constexpr std::string_view kEnd = ".tmp";
  if (!name.starts_with(target) || !name.ends_with(kEnd) || name.size() < target.size() + kEnd.size())
    return std::nullopt;
  name = name.substr(target.size(), name.size() - target.size() - kEnd.size());  // .PID.COUNT
  const std::size_t dot = name.rfind('.');
  std::int64_t pid = 0, count = 0;
  if (dot == std::string_view::npos || dot < 2 || name.front() != '.' ||
      name.find_first_not_of("0123456789.") != std::string_view::npos ||
      !parse_integer(name.substr(1, dot - 1), pid) || !parse_integer(name.substr(dot + 1), count) || pid <= 0)
    return std::nullopt;
  return static_cast<pid_t>(pid);
}

}  // namespace

std::string staging_name(const std::string& target) {
  static std::atomic<unsigned> count{0};
  return fmt::format("{}.{}.{}.tmp", target, ::getpid(), count++);
}

void remove_stale_beside(const std::string& target) {
  namespace fs = std::filesystem;
  const fs::path path(target);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code error;
  for (auto entry = fs::directory_iterator(folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    const auto pid = stager_of(entry->path().filename().string(), path.filename().string());
    if (!pid || ::kill(*pid, 0) == 0 || errno != ESRCH) continue;
    const Descriptor lock(::open(entry->path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    std::error_code ignored;  // what cannot be removed stays, and hurts nobody
    if (lock.get() >= 0 && ::flock(lock.get(), LOCK_EX | LOCK_NB) == 0)
      fs::remove_all(entry->path(), ignored);
  }
}

StagedFolder::StagedFolder(std::filesystem::path path)
    : path_(std::move(path)), lock_(::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (lock_ >= 0) (void)::flock(lock_, LOCK_EX | LOCK_NB);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;  // nothing better can be done in a destructor
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace octant::io
