// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/staging.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <set>

#include "io/text/open_file.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace staging_test {

namespace fs = std::filesystem;
using test::TemporaryFolder;

/// The number of a process that was, and is no more.
pid_t gone() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return child;
}

std::set<std::string> names_in(const TemporaryFolder& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder.path()))
    names.insert(entry.path().filename().string());
  return names;
}

TEST(Staging, EachNameIsAnotherOneBesideItsTarget) {
  std::set<std::string> names;
  for (int i = 0; i < 100; ++i) names.insert(staging_name("/a/b/out.json"));
  EXPECT_EQ(names.size(), 100U);
  for (const std::string& name : names) {
    EXPECT_EQ(fs::path(name).parent_path(), "/a/b") << "on the same disk, so that it can be renamed";
    EXPECT_TRUE(name.starts_with("/a/b/out.json." + std::to_string(::getpid()) + ".")) << name;
    EXPECT_TRUE(name.ends_with(".tmp"));
  }
}

TEST(Staging, WhatADeadProcessLeftIsRemovedAndNothingElse) {
  const TemporaryFolder folder;
  const std::string dead = std::to_string(gone()), alive = std::to_string(::getpid());
  const std::set<std::string> left = {"out." + dead + ".0.tmp", "out." + dead + ".17.tmp"};
  const std::set<std::string> others = {"out",
                                        "out." + alive + ".0.tmp",     // still being written
                                        "outer." + dead + ".0.tmp",    // of another target
                                        "my-out." + dead + ".0.tmp",   // likewise
                                        "out." + dead + ".tmp",        // no count
                                        "out." + dead + ".0.tmp.bak",  // somebody's copy
                                        "out." + dead + ".x.tmp",      // no number
                                        "out.-" + dead + ".0.tmp",     // no process
                                        "out.0.0.tmp",                 // nobody's
                                        "out..0.tmp",
                                        "out.tmp",
                                        "out." + dead + ".0."};
  for (const auto& names : {left, others})
    for (const std::string& name : names) folder.write(name, "x");
  fs::create_directories(folder.path("out." + dead + ".3.tmp/run"));  // a folder that was being made
  folder.write("out." + dead + ".3.tmp/run/tof.csv", "x");
  remove_stale_beside(folder.path("out"));
  EXPECT_EQ(names_in(folder), others);
}

/// A process on another machine has a number that is unused here: it locks its temporary files.
TEST(Staging, WhatSomebodyHoldsStays) {
  const TemporaryFolder folder;
  const std::string name = "out." + std::to_string(gone()) + ".0.tmp";
  folder.write(name, "x");
  {
    const Descriptor other(::open(folder.path(name).c_str(), O_RDONLY | O_CLOEXEC));
    ASSERT_EQ(::flock(other.get(), LOCK_EX | LOCK_NB), 0);
    remove_stale_beside(folder.path("out"));
    EXPECT_TRUE(fs::exists(folder.path(name)));
  }
  remove_stale_beside(folder.path("out"));
  EXPECT_FALSE(fs::exists(folder.path(name))) << "once it is let go";
}

TEST(Staging, ALinkOfSuchANameLeadsNowhere) {
  const TemporaryFolder folder;
  folder.write("precious/file", "x");
  const std::string link = folder.path("out." + std::to_string(gone()) + ".0.tmp");
  fs::create_directory_symlink(folder.path("precious"), link);
  remove_stale_beside(folder.path("out"));
  EXPECT_EQ(folder.read("precious/file"), "x");
}

TEST(Staging, AFolderThatIsNotThereHoldsNothingStale) {
  EXPECT_NO_THROW(remove_stale_beside("/nowhere/at/all/out"));
}

TEST(StagedFolder, GoesWithItsContentUnlessItIsKept) {
  const TemporaryFolder folder;
  for (const bool keep : {false, true}) {
    const fs::path path = folder.path(keep ? "kept" : "gone");
    fs::create_directory(path);
    {
      StagedFolder staged(path);
      EXPECT_EQ(staged.path(), path);
      folder.write(path.filename().string() + "/deep/file", "x");
      if (keep) staged.keep();
    }
    EXPECT_EQ(fs::exists(path / "deep/file"), keep);
  }
}

TEST(StagedFolder, IsLockedSoThatNobodyTakesItForOneThatWasLeft) {
  const TemporaryFolder folder;
  const fs::path path = folder.path("out." + std::to_string(gone()) + ".0.tmp");
  fs::create_directory(path);
  {
    StagedFolder staged(path);
    remove_stale_beside(folder.path("out"));
    EXPECT_TRUE(fs::exists(path)) << "its name is that of a dead process";
    staged.keep();
  }
  remove_stale_beside(folder.path("out"));
  EXPECT_FALSE(fs::exists(path));
}

}  // namespace staging_test
}  // namespace octant::io
