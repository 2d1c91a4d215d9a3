// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/open_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "tests/io/io_support.h"

namespace octant::io {
namespace open_file_test {

namespace fs = std::filesystem;
using test::expect_error;
using test::TemporaryFolder;

bool is_open(int fd) { return ::fcntl(fd, F_GETFD) != -1; }

TEST(Descriptor, IsClosedOnceByItsLastOwner) {
  int fd = -1;
  {
    Descriptor first(::open("/dev/null", O_RDONLY));
    fd = first.get();
    ASSERT_GE(fd, 0);
    Descriptor second(std::move(first));
    EXPECT_EQ(first.get(), -1);  // NOLINT(bugprone-use-after-move): that is what is asked
    EXPECT_EQ(second.get(), fd);
    EXPECT_TRUE(is_open(fd));
  }
  EXPECT_FALSE(is_open(fd));
}

TEST(Descriptor, AnAssignedOneClosesWhatItHeldBefore) {
  Descriptor a(::open("/dev/null", O_RDONLY));
  const int before = a.get();
  {
    Descriptor b(::open("/dev/null", O_RDONLY));
    a = std::move(b);
  }
  EXPECT_FALSE(is_open(before));
  EXPECT_TRUE(is_open(a.get()));
}

TEST(Descriptor, ClosedNowSaysWhetherItWent) {
  Descriptor good(::open("/dev/null", O_RDONLY)), none(-1);
  const int fd = good.get();
  EXPECT_TRUE(good.close_now());
  EXPECT_FALSE(is_open(fd));
  EXPECT_FALSE(none.close_now());
}

TEST(OpenFile, IsARegularFileOfItsSize) {
  const TemporaryFolder folder;
  const auto file = open_regular(folder.write("a", "12345"), 5);
  ASSERT_TRUE(file);
  EXPECT_EQ(file->size, 5U);
  EXPECT_EQ(read_all(*file, "a").value(), "12345");
  expect_error(open_regular(folder.path("a"), 4), 0, "5 bytes; expected at most 4", "a");
}

TEST(OpenFile, WhatIsNoFileIsNamedAndNothingHangs) {
  const TemporaryFolder folder;
  expect_error(open_regular(folder.path(), 100), 0, "this is a folder; expected a file");
  expect_error(open_regular(folder.path("none"), 100), 0, "No such file or directory", "none");
  ASSERT_EQ(::mkfifo(folder.path("pipe").c_str(), 0600), 0);
  expect_error(open_regular(folder.path("pipe"), 100), 0, "a pipe or a device", "pipe");
  expect_error(open_regular("/dev/zero", 100), 0, "a pipe or a device");
  fs::create_symlink(folder.path("loop"), folder.path("loop"));
  expect_error(open_regular(folder.path("loop"), 100), 0, "a symbolic link leads back to itself");
}

TEST(OpenFile, AFileThatHasShrunkMeanwhileIsWhatIsLeft) {
  const TemporaryFolder folder;
  const auto file = open_regular(folder.write("a", "0123456789"), 100);
  ASSERT_TRUE(file);
  fs::resize_file(folder.path("a"), 4);
  EXPECT_EQ(read_all(*file, "a").value(), "0123");
}

TEST(OpenFile, AFileThatHasGrownIsWhatWasThere) {
  const TemporaryFolder folder;
  const auto file = open_regular(folder.write("a", "0123"), 100);
  ASSERT_TRUE(file);
  std::ofstream(folder.path("a"), std::ios::app) << "456789";
  EXPECT_EQ(read_all(*file, "a").value(), "0123");
}

TEST(OpenFile, ReasonsHaveAnAdviceWhereThereIsOne) {
  for (const auto& [reason, words] : {std::pair{ENOENT, "path"},
                                      {EACCES, "permissions"},
                                      {EPERM, "permissions"},
                                      {ELOOP, "link"},
                                      {ENOSPC, "space"},
                                      {EROFS, "written"}})
    EXPECT_THAT(advice_for(reason), testing::HasSubstr(words));
  EXPECT_EQ(advice_for(EINVAL), "");
}

}  // namespace open_file_test
}  // namespace octant::io
