// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/mapped_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <utility>

#include "io/text/open_file.h"

namespace octant::io {

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
