// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/defaults_yaml.h"

#include <tuple>

#include "tests/io/io_support.h"

namespace octant::io {
namespace defaults_yaml_test {

TEST(DefaultsYaml, WhatIsThereIsTaken) {
  const test::TemporaryFolder box;
  const auto all = read_defaults(
      box.write("a.yaml", "octant_defaults: 1\nthreads: 2\nprogress: plain\nquiet: false\nverbose: true\n"));
  ASSERT_TRUE(all) << all.error().message();
  EXPECT_EQ(all->threads, 2);
  EXPECT_EQ(all->progress, "plain");
  EXPECT_EQ(all->quiet, false);
  EXPECT_EQ(all->verbose, true);
  const auto none = read_defaults(box.write("b.yaml", "octant_defaults: 1\n"));
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->threads || none->progress || none->quiet || none->verbose);
}

TEST(DefaultsYaml, WhatIsWrongIsNamed) {
  const test::TemporaryFolder box;
  for (const auto& [text, line, found] : std::vector<std::tuple<std::string, int, std::string>>{
           {"threads: 2\n", 1, "octant_defaults"},
           {"octant_defaults: 2\n", 1, "octant_defaults"},
           {"octant_defaults: 1\nthreads: -1\n", 2, "threads"},
           {"octant_defaults: 1\nprogress: loud\n", 2, "loud"}}) {
    const auto read = read_defaults(box.write("bad.yaml", text));
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().line, line) << text;
    EXPECT_NE(read.error().message().find(found), std::string::npos) << read.error().message();
  }
  const auto odd = read_defaults(box.write("odd.yaml", "octant_defaults: 1\nseed: 3\n"));
  ASSERT_TRUE(odd);
  ASSERT_EQ(odd->warnings.size(), 1U) << "a seed changes results";
  EXPECT_NE(odd->warnings[0].find("seed"), std::string::npos);
}

}  // namespace defaults_yaml_test
}  // namespace octant::io
