// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/open_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include <fmt/format.h>

namespace octant::io {
namespace {

tl::unexpected<Error> read_error(const std::string& path, int reason) {
  return fail({.code = Errc::kBadInput,
               .file = path,
               .found = fmt::format("cannot be read: {}", std::strerror(reason)),
               .advice = advice_for(reason)});
}

}  // namespace

Descriptor::Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

Descriptor::~Descriptor() {
  if (fd_ >= 0) ::close(fd_);
}

bool Descriptor::close_now() { return ::close(std::exchange(fd_, -1)) == 0; }

std::string advice_for(int reason) {
  switch (reason) {
    case ENOENT: return "check the path";
    case EACCES:
    case EPERM: return "check the permissions";
    case ELOOP: return "a symbolic link leads back to itself; remove it";
    case ENOSPC:
    case EDQUOT: return "free some space or choose another place";
    case EROFS: return "choose a place that can be written";
    default: return "";
  }
}

Result<OpenFile> open_regular(const std::string& path, std::size_t max_bytes) {
  // Without O_NONBLOCK, opening a pipe without a writer would block.
  Descriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (fd.get() < 0) return read_error(path, errno);
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) return read_error(path, errno);
  if (S_ISDIR(status.st_mode)) return fail({.file = path, .found = "this is a folder", .expected = "a file"});
  if (!S_ISREG(status.st_mode))
    return fail({.file = path, .found = "this is a pipe or a device", .expected = "a file"});
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > max_bytes) {
    return fail({.file = path,
                 .found = fmt::format("{} bytes", size),
                 .expected = fmt::format("at most {}", max_bytes)});
  }
  return OpenFile{std::move(fd), size};
}

Result<std::string> read_all(const OpenFile& file, const std::string& path) {
  try {
    std::string content(file.size, '\0');
    std::size_t have = 0;
    while (have < content.size()) {
      const ssize_t n = ::read(file.fd.get(), content.data() + have, content.size() - have);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return read_error(path, errno);
      if (n == 0) break;  // it has become shorter meanwhile
      have += static_cast<std::size_t>(n);
    }
    content.resize(have);
    return content;
  } catch (const std::bad_alloc&) {
    return fail({.code = Errc::kNoMemory,
                 .file = path,
                 .found = fmt::format("out of memory for its {} bytes", file.size),
                 .advice = "use a machine with more, or a smaller file"});
  }
}

Result<MappedFile> MappedFile::open(const std::string& path) {
  const auto file = open_regular(path, kLargest);
  if (!file) return fail(file.error());
  if (file->size > 0) {
    void* map = ::mmap(nullptr, file->size, PROT_READ, MAP_PRIVATE, file->fd.get(), 0);
    if (map != MAP_FAILED) {
      (void)::madvise(map, file->size, MADV_SEQUENTIAL);  // advice only: it works without
      return MappedFile(static_cast<const char*>(map), file->size, {});
    }
  }
  auto content = read_all(*file, path);
  if (!content) return fail(content.error());
  return MappedFile(nullptr, 0, std::move(*content));
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : map_(std::exchange(other.map_, nullptr)),
      size_(std::exchange(other.size_, 0)),
      copy_(std::move(other.copy_)) {}

MappedFile::~MappedFile() {
  if (map_ != nullptr) ::munmap(const_cast<char*>(map_), size_);
}

void MappedFile::release(std::size_t begin, std::size_t end) const {
  static const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t first = begin / page * page, last = end == size_ ? size_ : end / page * page;
  if (map_ == nullptr || first >= last) return;
  (void)::madvise(const_cast<char*>(map_) + first, last - first, MADV_DONTNEED);
}

}  // namespace octant::io
