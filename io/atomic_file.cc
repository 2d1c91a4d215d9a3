// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include <fmt/format.h>

#include "io/open_file.h"
#include "io/sha256.h"

namespace octant::io {
namespace {

tl::unexpected<Error> write_error(const std::string& path, int reason) {
  return fail({.code = Errc::kOutput,
               .file = path,
               .found = fmt::format("cannot be written: {}", std::strerror(reason)),
               .advice = reason == ENOENT ? "the folder does not exist; create it first" : advice_for(reason)});
}

/// 0, or the system's reason.
int write_all(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t n = ::write(fd, content.data(), content.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    if (n == 0) return EIO;
    content.remove_prefix(static_cast<std::size_t>(n));
  }
  return 0;
}

/// Makes a rename durable; file systems that cannot flush a folder are forgiven.
void flush_folder(const std::string& folder) {
  const Descriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() >= 0) (void)::fsync(fd.get());
}

/// Pipes and devices are written in place: there is no file to keep whole.
Result<void> write_in_place(const std::string& path, std::string_view content) {
  Descriptor fd(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (fd.get() < 0) return write_error(path, errno);
  if (const int reason = write_all(fd.get(), content)) return write_error(path, reason);
  if (!fd.close_now()) return write_error(path, errno);
  return {};
}

Result<void> write_and_rename(const std::string& path, const std::string& target, mode_t mode, std::string_view content) {
  static std::atomic<unsigned> count{0};
  const std::string temporary = fmt::format("{}.{}.{}.tmp", target, ::getpid(), count++);
  int reason = 0;
  {
    Descriptor fd(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (fd.get() < 0) return write_error(path, errno);
    reason = write_all(fd.get(), content);
    if (reason == 0 && mode != 0 && ::fchmod(fd.get(), mode) != 0 && errno != EPERM) reason = errno;
    if (reason == 0 && ::fsync(fd.get()) != 0 && errno != EINVAL) reason = errno;
    if (!fd.close_now() && reason == 0) reason = errno;
  }
  if (reason == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) reason = errno;
  if (reason != 0) {
    ::unlink(temporary.c_str());
    return write_error(path, reason);
  }
  const std::size_t slash = target.rfind('/');
  flush_folder(slash == std::string::npos ? "." : slash == 0 ? "/" : target.substr(0, slash));
  return {};
}

}  // namespace

Result<void> write_file(const std::string& path, std::string_view content) {
  if (path == "-") {
    std::fflush(stdout);  // what was printed before comes first
    if (const int reason = write_all(STDOUT_FILENO, content)) return write_error("standard output", reason);
    return {};
  }
  if (path.empty()) return fail({.code = Errc::kOutput, .found = "an empty path", .expected = "the name of a file"});
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) return write_error(path, EISDIR);
    if (!S_ISREG(status.st_mode)) return write_in_place(path, content);
    // A link stays a link: what it points to is replaced.
    const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr), &std::free);
    return write_and_rename(path, real ? real.get() : path, status.st_mode & 07777, content);
  }
  if (errno != ENOENT) return write_error(path, errno);
  return write_and_rename(path, path, 0, content);
}

Result<std::string> read_file(const std::string& path, std::size_t max_bytes) {
  const auto file = open_regular(path, max_bytes);
  if (!file) return fail(file.error());
  return read_all(*file, path);
}

std::string sha256_hex(std::string_view bytes) {
  Sha256 digest;
  digest.add(bytes);
  return digest.hex();
}

}  // namespace octant::io
