// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/append_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace octant::app {
namespace {

constexpr std::size_t kPageBytes = 4096;
constexpr std::size_t kMostPendingBytes = std::size_t{16} << 20;  ///< while the disk is full

}  // namespace

AppendFile::~AppendFile() {
  (void)flush();
  if (fd_ >= 0) ::close(fd_);
}

bool AppendFile::add(std::string_view row) {
  if (pending_.size() + row.size() > kMostPendingBytes) return false;
  if (size_ == 0 && !header_.empty()) {
    pending_ += header_;
    size_ += header_.size();
  }
  const std::size_t left = kPageBytes - size_ % kPageBytes;
  if (row.size() > left && row.size() <= kPageBytes) {
    pending_.append(left, '\n');
    size_ += left;
  }
  pending_ += row;
  size_ += row.size();
  return true;
}

Result<void> AppendFile::open() {
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (fd_ >= 0) return {};
  return fail({.code = Errc::kOutput, .file = path_, .found = std::strerror(errno)});
}

Result<void> AppendFile::flush() {
  if (pending_.empty()) return {};
  if (fd_ < 0)
    if (auto opened = open(); !opened) return opened;
  while (!pending_.empty()) {
    const ssize_t written = write(fd_, pending_.data(), pending_.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return fail({.code = Errc::kOutput, .file = path_, .found = std::strerror(errno)});
    pending_.erase(0, static_cast<std::size_t>(written));
  }
  return {};
}

int AppendFile::duplicate() const { return fd_ < 0 ? -1 : fcntl(fd_, F_DUPFD_CLOEXEC, 0); }

void AppendFile::reopen() {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  std::error_code missing;
  const auto size = std::filesystem::file_size(path_, missing);
  size_ = missing ? 0 : size;
}

}  // namespace octant::app
