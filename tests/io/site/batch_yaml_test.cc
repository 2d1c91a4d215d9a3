// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/site/batch_yaml.h"

#include "tests/io/io_support.h"

namespace octant::io {
namespace batch_yaml_test {

using test::expect_error;
using test::TemporaryFolder;

Result<Batch> read(const std::string& text) {
  const TemporaryFolder folder;
  return read_batch(folder.write("sites.yaml", text));
}

const std::string kHead = "octant_batch: 1\nsites:\n";

TEST(BatchYaml, ReadsSitesAndTheirPaths) {
  const TemporaryFolder folder;
  const std::string list = folder.write(
      "sites.yaml",
      kHead + "- {site: a/site.yaml, runs: [a/run1, /abs/run2], output: a.json, report: out/a.html}\n" +
          "- {site: b/site.yaml, runs: [b/run], output: /abs/b.json, name: hall B, colour: red}\n");
  const auto batch = read_batch(list).value();
  ASSERT_EQ(batch.sites.size(), 2u);
  const BatchSite &a = batch.sites[0], &b = batch.sites[1];
  EXPECT_EQ(a.name, "a/site.yaml");
  EXPECT_EQ(a.site, folder.path("a/site.yaml"));
  EXPECT_THAT(a.runs, testing::ElementsAre(folder.path("a/run1"), "/abs/run2"));
  EXPECT_EQ(a.output, folder.path("a.json"));
  EXPECT_EQ(a.report, folder.path("out/a.html"));
  EXPECT_EQ(b.name, "hall B");
  EXPECT_EQ(b.output, "/abs/b.json");
  EXPECT_EQ(b.report, "");
  EXPECT_THAT(batch.warnings,
              testing::ElementsAre(testing::HasSubstr("sites.yaml:4: unknown key 'sites[1].colour'")));

  const auto moved = read_batch(list, "out").value();
  EXPECT_EQ(moved.sites[0].output, "out/a.json");
  EXPECT_EQ(moved.sites[0].report, "out/out/a.html");
  EXPECT_EQ(moved.sites[0].site, a.site) << "what is read stays where it is";
  EXPECT_EQ(moved.sites[1].output, "/abs/b.json");
}

TEST(BatchYaml, SaysWhatIsWrongAndWhere) {
  const std::string good = "- {site: s, runs: [r], output: o}\n";
  struct Bad {
    std::string text;
    int line;
    std::string words;
  };
  for (const auto& [text, line, words] :
       {Bad{"", 0, "empty"}, Bad{"sites: []\n", 1, "'octant_batch' is missing"},
        Bad{"octant_batch: 2\nsites: []\n", 1, "version '2'"},
        Bad{"octant_batch: 1\n", 1, "'sites' is missing"}, Bad{kHead + "  []\n", 2, "'sites' has no value"},
        Bad{kHead + "- s\n", 3, "sites[0]"},
        Bad{kHead + good + "- {runs: [r], output: p}\n", 4, "'sites[1].site' is missing"},
        Bad{kHead + "- {site: s, output: o}\n", 3, "'sites[0].runs' is missing"},
        Bad{kHead + "- {site: s, runs: r, output: o}\n", 3, "runs"},
        Bad{kHead + "- {site: s, runs: [r]}\n", 3, "'sites[0].output' is missing"},
        Bad{kHead + "- {site: s, runs: [r], output: \"-\"}\n", 3, "the name of a file"},
        Bad{kHead + good + "- {site: t, runs: [r], output: ./x/../o}\n", 4,
            "the same file as sites[0].output"},
        Bad{kHead + "- {site: t, runs: [r], output: o, report: o}\n", 3,
            "the same file as sites[0].output"}}) {
    SCOPED_TRACE(text);
    expect_error(read(text), line, words, "sites.yaml");
  }
  expect_error(read_batch("/nowhere/sites.yaml"), 0, "No such file", "sites.yaml");
}

}  // namespace batch_yaml_test
}  // namespace octant::io
