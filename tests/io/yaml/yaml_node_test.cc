// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/yaml/yaml_node.h"

#include "io/yaml/yaml_writer.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace yaml_node_test {

using test::expect_error;

YamlNode parsed(const std::string& text) { return parse_yaml(text, "a.yaml").value(); }

TEST(YamlNode, HoldsValuesAndWhereTheyStand) {
  const YamlNode root = parsed("# c\na: 1\nb:\n  - x\n  - {k: 'q', n: ~, e: , t: \"null\"}\nc: |\n  long\n");
  ASSERT_TRUE(root.is_map());
  EXPECT_EQ(root.line(), 2);
  EXPECT_EQ(root["a"].scalar(), "1");
  EXPECT_FALSE(root["a"].is_quoted());
  const YamlNode list = root["b"];
  ASSERT_TRUE(list.is_sequence() && !list.is_flow());
  EXPECT_EQ(list.size(), 2U);
  EXPECT_EQ(list[1].line(), 5);
  EXPECT_EQ(list[1].column(), 5);
  EXPECT_TRUE(list[1].is_flow());
  EXPECT_EQ(list[1]["k"].scalar(), "q");
  EXPECT_TRUE(list[1]["k"].is_quoted());
  EXPECT_TRUE(list[1]["n"].is_null() && list[1]["e"].is_null());
  EXPECT_EQ(list[1]["t"].scalar(), "null") << "in quotes it is a word";
  EXPECT_EQ(root["c"].scalar(), "long\n");
  EXPECT_FALSE(root["d"].is_defined() || list[2].is_defined() || YamlNode().is_null());
  EXPECT_EQ(YamlNode().line(), 0);
}

TEST(YamlNode, AliasesAreWhatTheyName) {
  const YamlNode root = parsed("a: &a {x: [1, 2]}\nb: *a\na2: &a 3\nc: [*a, *a]\n");
  EXPECT_EQ(root["b"]["x"][1].scalar(), "2");
  EXPECT_EQ(root["c"][1].scalar(), "3") << "the last one of the name";
}

TEST(YamlNode, SaysWhatIsNoDocument) {
  expect_error(parse_yaml("", "a"), 0, "empty");
  expect_error(parse_yaml("# c\n", "a"), 0, "empty");
  expect_error(parse_yaml("~", "a"), 0, "empty");
  expect_error(parse_yaml("a: 1\n---\n*a", "a"), 3, "second document");
  expect_error(parse_yaml("a: 1\n---\nb", "a"), 3, "second document");
  expect_error(parse_yaml("a: *b\n", "a"), 1, "which is not defined");
  expect_error(parse_yaml("a: &a [*a]\n", "a"), 1, "within it");
  expect_error(parse_yaml("a: \"\\q\"\n", "a"), 1, "not YAML: found unknown escape character");
  expect_error(parse_yaml("a: [1, 2\nb: 3\n", "a"), 2, "not YAML");
  expect_error(parse_yaml("a: \x07\n", "a"), 1, "control characters");
  expect_error(parse_yaml(",\n,", "a"), 1, "not YAML");
  expect_error(parse_yaml(" , h@a", "a"), 1, "not YAML");
  expect_error(parse_yaml(std::string(kLargestYaml + 1, 'a'), "a"), 0, "at most 16 MB");
}

TEST(YamlNode, WhatIsWrittenReadsBack) {
  EXPECT_TRUE(rc::check([] {
    const auto words = *rc::gen::container<std::vector<std::string>>(
        rc::gen::container<std::string>(rc::gen::inRange<char>(' ', '~')));
    YamlWriter out;
    out.begin_map(false);
    out.text("list");
    out.begin_list(*rc::gen::arbitrary<bool>());
    for (const std::string& word : words) out.text(word, true);
    out.end_list();
    out.text("map");
    out.begin_map(true);
    for (std::size_t i = 0; i < words.size(); ++i) out.text(std::to_string(i)), out.text(words[i], true);
    out.end_map();
    out.end_map();
    const YamlNode once = parsed(out.finish());
    YamlWriter again;
    again.copy(once);
    const YamlNode twice = parsed(again.finish());
    RC_ASSERT(twice["list"].size() == words.size());
    for (std::size_t i = 0; i < words.size(); ++i) {
      RC_ASSERT(twice["list"].item(i).scalar() == words[i]);
      RC_ASSERT(twice["map"][std::to_string(i)].scalar() == words[i]);
    }
  }));
}

}  // namespace yaml_node_test
}  // namespace octant::io
