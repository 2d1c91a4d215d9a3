// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_files.h"
#include "io/run/run_folder.h"

#include "tests/io/io_support.h"

namespace octant::io {
namespace run_advice_test {

using test::expect_error;
using test::TemporaryFolder;

TEST(RunAdvice, AFolderIsARunFolderUntilItIsRead) {
  const TemporaryFolder folder;
  EXPECT_TRUE(check_run_folder(folder.path()));
  expect_error(check_run_folder(folder.write("tof.csv", "x")), 0, "this is a file", "tof.csv");
  EXPECT_EQ(check_run_folder(folder.path("tof.csv")).error().advice, "name the folder, not a file within it");
  expect_error(check_run_folder(folder.path("none")), 0, "No such file or directory", "none");
  expect_error(check_run_folder(""), 0, "cannot be read");
}

TEST(RunAdvice, NamesTheRunsRightBelow) {
  const TemporaryFolder folder;
  EXPECT_EQ(advice_where_no_run_is(folder.path()), "is this the run folder?");
  folder.write("b/tof.csv", "x");
  folder.write("notes/readme.txt", "x");
  folder.write("deep/er/tof.csv", "x");
  EXPECT_EQ(advice_where_no_run_is(folder.path()), "did you mean '" + folder.path("b") + "'?");
  folder.write("a/bearings.csv", "x");
  folder.write("c/scans.csv", "x");
  folder.write("d/tof.csv", "x");
  EXPECT_EQ(advice_where_no_run_is(folder.path()), "did you mean '" + folder.path("a") + "' or '" +
                                                       folder.path("b") + "' or '" + folder.path("c") + "'?")
      << "in their order, three at most";
}

TEST(RunAdvice, AFolderOfThatNameIsNoFile) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("a/tof.csv"));
  EXPECT_EQ(advice_where_no_run_is(folder.path()), "is this the run folder?");
  EXPECT_EQ(advice_where_no_run_is(folder.path("none")), "is this the run folder?");
}

}  // namespace run_advice_test
}  // namespace octant::io
