// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include <fmt/format.h>

#include "io/text/open_file.h"
#include "io/text/sha256.h"
#include "io/text/staging.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

tl::unexpected<Error> write_error(const std::string& path, int reason) {
  return fail(
      {.code = Errc::kOutput,
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

/// A complete file next to the one that it will replace; removed unless it is kept.
class StagedFile {
 public:
  StagedFile(std::string path, std::string target) : path_(std::move(path)), target_(std::move(target)) {
    remove_stale_beside(target_);
    temporary_ = staging_name(target_);
  }
  StagedFile(StagedFile&& other) noexcept
      : path_(std::move(other.path_)),
        target_(std::move(other.target_)),
        temporary_(std::exchange(other.temporary_, {})),
        lock_(std::move(other.lock_)) {}
  StagedFile& operator=(StagedFile&&) = delete;
  ~StagedFile() {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }

  [[nodiscard]] Result<void> write(mode_t mode, std::string_view content) {
    Descriptor fd(::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (fd.get() < 0) {
      const int reason = errno;
      temporary_.clear();  // not ours
      return write_error(path_, reason);
    }
    lock_ = Descriptor(::dup(fd.get()));  // shares the lock, which so outlives fd
    (void)::flock(fd.get(), LOCK_EX | LOCK_NB);
    int reason = write_all(fd.get(), content);
    if (reason == 0 && mode != 0 && ::fchmod(fd.get(), mode) != 0 && errno != EPERM) reason = errno;
    if (reason == 0 && ::fsync(fd.get()) != 0 && errno != EINVAL) reason = errno;
    if (!fd.close_now() && reason == 0) reason = errno;
    if (reason != 0) return write_error(path_, reason);
    return {};
  }

  [[nodiscard]] Result<void> put_in_place() {
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) return write_error(path_, errno);
    temporary_.clear();
    const std::size_t slash = target_.rfind('/');
    flush_folder(slash == std::string::npos ? "." : slash == 0 ? "/" : target_.substr(0, slash));
    return {};
  }

 private:
  std::string path_, target_, temporary_;
  Descriptor lock_{-1};  ///< lock of the staged file, so that no other process removes it as an abandoned one
};

Result<void> write_to_stdout(std::string_view content) {
  std::fflush(stdout);  // what was printed before comes first
  if (const int reason = write_all(STDOUT_FILENO, content)) return write_error("standard output", reason);
  return {};
}

/// Method of writing a path.
struct Destination {
  enum class Kind { kStdout, kInPlace, kFile } kind = Kind::kFile;
  std::string target;  ///< a link stays a link: what it points to is replaced
  mode_t mode = 0;     ///< permissions of the existing file; 0: there is no such file
};

Result<Destination> destination_of(const std::string& path) {
  if (path == "-") return Destination{Destination::Kind::kStdout, path, 0};
  if (path.empty())
    return fail({.code = Errc::kOutput, .found = "an empty path", .expected = "the name of a file"});
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) return write_error(path, EISDIR);
    if (!S_ISREG(status.st_mode)) return Destination{Destination::Kind::kInPlace, path, 0};
    const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr), &std::free);
    return Destination{Destination::Kind::kFile, real ? real.get() : path, status.st_mode & 07777};
  }
  if (errno != ENOENT) return write_error(path, errno);
  return Destination{Destination::Kind::kFile, path, 0};
}

}  // namespace

Result<void> write_files(const std::vector<FileContent>& files) {
  std::vector<StagedFile> staged;
  std::vector<const FileContent*> at_once;
  for (const FileContent& file : files) {
    auto to = destination_of(file.path);
    if (!to) return fail(to.error());
    if (to->kind != Destination::Kind::kFile) {
      at_once.push_back(&file);
      continue;
    }
    staged.emplace_back(file.path, to->target);
    if (auto written = staged.back().write(to->mode, file.content); !written) return written;
  }
  for (const FileContent* file : at_once)
    if (auto written =
            file->path == "-" ? write_to_stdout(file->content) : write_in_place(file->path, file->content);
        !written)
      return written;
  for (StagedFile& file : staged)
    if (auto placed = file.put_in_place(); !placed) return placed;
  return {};
}

Result<void> write_file(const std::string& path, std::string_view content) {
  return write_files({{path, std::string(content)}});
}

Result<std::string> read_file(const std::string& path, std::size_t max_bytes) {
  return open_regular(path, max_bytes).and_then([&path](const OpenFile& file) {
    return read_all(file, path);
  });
}

std::string sha256_hex(std::string_view bytes) {
  Sha256 digest;
  digest.add(bytes);
  return digest.hex();
}

}  // namespace octant::io
