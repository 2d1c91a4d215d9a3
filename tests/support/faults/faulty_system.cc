// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A system that fails on purpose, for LD_PRELOAD: tests/apps/faults_test.cc. OCTANT_FAULTS names what fails,
// in words with blanks between them:
//   short          read and write do seven bytes at a time
//   interrupted    every other read, write and open of a file ends with EINTR
//   full=N         the disk is full after N bytes to files
//   read_only      no file can be made
//   no_map         files cannot be mapped
//   no_flush       fsync fails
//   cut=NAME       a file of this name is cut off as soon as it is mapped
//   grow=NAME      and one is appended to
//   replace=NAME   and one is replaced by another
//   die=NAME       the second rank is killed as soon as it maps a file of this name
//   clock_back     each look at the clock on the wall is an hour before the last one
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>

namespace {

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

/// Value after a fault's name in OCTANT_FAULTS; null if it is not requested, "" without a value.
const char* asked(const char* fault) {
  static const std::string all =
      std::string(" ") + (::getenv("OCTANT_FAULTS") ? ::getenv("OCTANT_FAULTS") : "");
  const std::size_t at = all.find(std::string(" ") + fault);
  return at == std::string::npos ? nullptr : all.c_str() + at + 1 + std::strlen(fault);
}

/// 0, 1, 0, 1, ...
bool is_other_time() {
  static std::atomic<unsigned> count{0};
  return count++ % 2 == 1;
}

bool is_file(int fd) {
  struct stat status {};
  return ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
}

bool interrupts() { return asked("interrupted") != nullptr && is_other_time(); }

std::size_t most(std::size_t size) {
  return asked("short") != nullptr ? std::min<std::size_t>(size, 7) : size;
}

/// Number of the `size` bytes for which the disk has space.
std::size_t room(int fd, std::size_t size) {
  const char* bytes = asked("full=");
  if (bytes == nullptr || !is_file(fd)) return size;
  static std::atomic<long> left{std::atol(bytes)};
  const long before = left.fetch_sub(static_cast<long>(size));
  return static_cast<std::size_t>(std::clamp<long>(before, 0, static_cast<long>(size)));
}

std::string path_of(int fd) {
  char path[PATH_MAX] = "";
  const ssize_t size = ::readlink(("/proc/self/fd/" + std::to_string(fd)).c_str(), path, sizeof path - 1);
  return size < 0 ? "" : std::string(path, static_cast<std::size_t>(size));
}

/// Returns true if a fault applies to the open file.
bool hits(const char* fault, const std::string& path) {
  const char* name = asked(fault);
  if (name == nullptr) return false;
  const std::string end = "/" + std::string(name, std::strcspn(name, " "));
  return path.size() > end.size() && path.compare(path.size() - end.size(), end.size(), end) == 0;
}

bool makes_file(int flags) { return (flags & O_CREAT) != 0; }

}  // namespace

extern "C" {

ssize_t read(int fd, void* to, size_t size) {
  static auto* const next = real<ssize_t(int, void*, size_t)>("read");
  if (is_file(fd) && interrupts()) return errno = EINTR, -1;
  return next(fd, to, is_file(fd) ? most(size) : size);
}

ssize_t write(int fd, const void* from, size_t size) {
  static auto* const next = real<ssize_t(int, const void*, size_t)>("write");
  if (interrupts()) return errno = EINTR, -1;
  const std::size_t left = room(fd, most(size));
  if (left == 0 && size > 0) return errno = ENOSPC, -1;
  return next(fd, from, left);
}

ssize_t pwrite64(int fd, const void* from, size_t size, off64_t at) {
  static auto* const next = real<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
  const std::size_t left = room(fd, size);
  if (left == 0 && size > 0) return errno = ENOSPC, -1;
  return next(fd, from, left, at);
}

int open(const char* path, int flags, ...) {
  static auto* const next = real<int(const char*, int, ...)>("open");
  va_list words;
  va_start(words, flags);
  const mode_t mode = makes_file(flags) ? va_arg(words, mode_t) : 0;
  va_end(words);
  if (makes_file(flags) && asked("read_only") != nullptr) return errno = EROFS, -1;
  return next(path, flags, mode);
}

int mkdir(const char* path, mode_t mode) {
  static auto* const next = real<int(const char*, mode_t)>("mkdir");
  if (asked("read_only") != nullptr) return errno = EROFS, -1;
  return next(path, mode);
}

int fsync(int fd) {
  static auto* const next = real<int(int)>("fsync");
  if (asked("no_flush") != nullptr && is_file(fd)) return errno = EIO, -1;
  return next(fd);
}

void* mmap(void* where, size_t size, int protection, int flags, int fd, off_t at) {
  static auto* const next = real<void*(void*, size_t, int, int, int, off_t)>("mmap");
  if (fd >= 0 && asked("no_map") != nullptr) return errno = ENODEV, MAP_FAILED;
  void* const map = next(where, size, protection, flags, fd, at);
  if (fd < 0 || map == MAP_FAILED) return map;
  const std::string path = path_of(fd);
  const char* rank = ::getenv("OMPI_COMM_WORLD_RANK");
  if (hits("die=", path) && rank != nullptr && std::strcmp(rank, "1") == 0) std::raise(SIGKILL);
  if (hits("cut=", path) && ::truncate(path.c_str(), 0) != 0) std::abort();
  if (hits("grow=", path) || hits("replace=", path)) {
    if (hits("replace=", path)) ::unlink(path.c_str());
    std::FILE* file = std::fopen(path.c_str(), "a");
    if (file == nullptr) std::abort();
    std::fputs("half a ro", file);
    std::fclose(file);
  }
  return map;
}

int clock_gettime(clockid_t clock, struct timespec* time) {
  static auto* const next = real<int(clockid_t, struct timespec*)>("clock_gettime");
  const int result = next(clock, time);
  static std::atomic<long> looks{0};
  if (result == 0 && clock == CLOCK_REALTIME && asked("clock_back") != nullptr)
    time->tv_sec -= 3600 * looks++;
  return result;
}

}  // extern "C"
