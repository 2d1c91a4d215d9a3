// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/atomic_file.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>

#include "tests/io/io_support.h"

namespace octant::io {
namespace atomic_file_test {

using test::expect_error;
using test::TemporaryFolder;

TEST(AtomicFile, ReadsWhatItWrote) {
  const TemporaryFolder folder;
  std::string content = "Süd\r\n";
  content += '\0';
  ASSERT_TRUE(write_file(folder.path("a"), content));
  EXPECT_EQ(read_file(folder.path("a")).value(), content);
  ASSERT_TRUE(write_file(folder.path("a"), "shorter"));
  EXPECT_EQ(read_file(folder.path("a")).value(), "shorter");
  EXPECT_EQ(folder.files(), 1u) << "a temporary file was left behind";
}

TEST(AtomicFile, NamesTheReasonForWhatCannotBeRead) {
  const TemporaryFolder folder;
  expect_error(read_file(folder.path("none")), 0, "No such file", "none");
  expect_error(read_file(folder.path()), 0, "folder");
  std::filesystem::create_symlink("loop", folder.path("loop"));
  expect_error(read_file(folder.path("loop")), 0, "symbolic link", "loop");
  ASSERT_EQ(::mkfifo(folder.path("pipe").c_str(), 0600), 0);
  expect_error(read_file(folder.path("pipe")), 0, "pipe", "pipe");
  folder.write("long", "0123456789");
  expect_error(read_file(folder.path("long"), 9), 0, "10 bytes");
  if (::geteuid() != 0) {  // root may read everything
    ::chmod(folder.path("long").c_str(), 0);
    expect_error(read_file(folder.path("long")), 0, "Permission denied");
  }
}

TEST(AtomicFile, RefusesFoldersThatAreNotThereAndFoldersAsFiles) {
  const TemporaryFolder folder;
  expect_error(write_file(folder.path("none/a"), "x"), 0, "folder does not exist", "none/a");
  expect_error(write_file(folder.path(), "x"), 0, "directory");
  expect_error(write_file("", "x"), 0, "empty path");
  EXPECT_EQ(write_file(folder.path("none/a"), "x").error().code, Errc::kOutput);
  EXPECT_FALSE(std::filesystem::exists(folder.path("none"))) << "folders are not created";
}

TEST(AtomicFile, SaysWhenTheDiskIsFull) {
  expect_error(write_file("/dev/full", "x"), 0, "No space left", "/dev/full");
}

// A limit on the size of files simulates a full disk: the write fails half way.
TEST(AtomicFile, LeavesTheOldFileWholeWhenWritingFails) {
  const TemporaryFolder folder;
  folder.write("a", "old");
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const struct rlimit small { 4096, before.rlim_max };
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const Result<void> result = write_file(folder.path("a"), std::string(100'000, 'x'));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  expect_error(result, 0, "too large", "a");
  EXPECT_EQ(folder.read("a"), "old");
  EXPECT_EQ(folder.files(), 1u) << "a temporary file was left behind";
}

// A deployment and its reports come together or not at all, whichever of them fails.
TEST(AtomicFile, SeveralFilesAreWrittenTogetherOrNotAtAll) {
  const TemporaryFolder folder;
  folder.write("report", "old");
  expect_error(write_files({{folder.path("report"), "new"}, {folder.path("none/deployment"), "new"}}), 0,
               "folder does not exist", "none/deployment");
  expect_error(write_files({{folder.path("report"), "new"}, {"/dev/full", "new"}}), 0, "No space left",
               "/dev/full");
  expect_error(write_files({{"/dev/full", "new"}, {folder.path("report"), "new"}}), 0, "No space left",
               "/dev/full");
  EXPECT_EQ(folder.read("report"), "old");
  EXPECT_EQ(folder.files(), 1u) << "a temporary file was left behind";
  ASSERT_TRUE(write_files({{folder.path("report"), "new"}, {folder.path("deployment"), "first"}}));
  EXPECT_EQ(folder.read("report"), "new");
  EXPECT_EQ(folder.read("deployment"), "first");
  EXPECT_EQ(folder.files(), 2u);
}

TEST(AtomicFile, KeepsLinksAndPermissions) {
  const TemporaryFolder folder;
  folder.write("target", "old");
  ::chmod(folder.path("target").c_str(), 0640);
  std::filesystem::create_symlink("target", folder.path("link"));
  ASSERT_TRUE(write_file(folder.path("link"), "new"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path("link")));
  EXPECT_EQ(folder.read("target"), "new");
  struct stat status {};
  ASSERT_EQ(::stat(folder.path("target").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(AtomicFile, DigestsAsTheStandardSays) {  // FIPS 180-4, examples
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

}  // namespace atomic_file_test
}  // namespace octant::io
