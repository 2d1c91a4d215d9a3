// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/yaml/yaml_writer.h"

#include "io/yaml/yaml_node.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace yaml_writer_test {

/// As it reads back as a value and as a list's item in brackets, where more characters have a meaning.
void expect_back(const std::string& text) {
  const auto document = parse_yaml("{k: " + yaml_text(text) + ", l: [" + yaml_text(text) + "]}\n", "a");
  ASSERT_TRUE(document) << document.error().message() << " from " << yaml_text(text);
  EXPECT_EQ((*document)["k"].scalar(), text);
  EXPECT_EQ((*document)["l"][0].scalar(), text);
  EXPECT_TRUE((*document)["k"].is_scalar()) << "a text, and not nothing";
}

TEST(YamlText, ReadsBackAsTheTextWhateverItIs) {
  EXPECT_TRUE(rc::check("names of ASCII", [] {
    const auto text = *rc::gen::container<std::string>(rc::gen::weightedOneOf<char>(
        {{3, rc::gen::element(':', '#', '-', '"', '\'', '\\', '{', ']', ',', '&', '*', '!', '%', '@', '~')},
         {4, rc::gen::inRange(' ', '~')},
         {1, rc::gen::inRange('\x01', '\x20')}}));
    const auto document = parse_yaml("k: " + yaml_text(text) + "\n", "a");
    RC_ASSERT(document.has_value());
    RC_ASSERT((*document)["k"].scalar() == text);
  }));
}

TEST(YamlText, WordsThatYamlTakesForSomethingElseAreQuoted) {
  for (const char* word : {"",     "null", "Null", "~",    "true",  "FALSE", "yes",  "No",  "on",  "Off",
                           "y",    "N",    "1",    "-1.5", "1e5",   ".inf",  ".nan", "inf", "nan", "0x1",
                           "a: b", "- a",  "a #b", " a",   "a ",    "[a]",   "{a}",  "a,b", "*a",  "&a",
                           "!a",   "%a",   "@a",   "'a'",  "\"a\"", "a\\b",  "a\nb", "---", "..."}) {
    EXPECT_EQ(yaml_text(word).front(), '"') << word;
    expect_back(word);
  }
}

TEST(YamlText, PlainNamesStayPlain) {
  for (const char* name : {"B1", "robot", "hall-3", "a.b", "under_score", "nullable", "yesterday", "e5"}) {
    EXPECT_EQ(yaml_text(name), name);
    expect_back(name);
  }
}

TEST(YamlText, NamesInAnyScriptReadBack) {
  for (const char* name : {"Süd 北", "\xF0\x9F\x9C\xA8", "naïve", "Δ"}) expect_back(name);
}

/// Characters beyond ASCII that end a line or are not allowed in YAML at all (YAML 1.1, 5.1 and 5.4), but may
/// occur in a name from a CSV file.
TEST(YamlText, BreaksAndControlsBeyondAsciiReadBack) {
  for (const char* odd :
       {"a\xC2\x80z", "a\xC2\x85z", "a\xC2\x9Fz", "a\xE2\x80\xA8z", "a\xE2\x80\xA9z", "a\x7Fz",
        "a\xEF\xBF\xBEz", "a\xEF\xBF\xBFz", "\xEF\xBB\xBFz", "\xE2\x80\xA8", "a\xC2\xA0z"})
    expect_back(odd);
}

}  // namespace yaml_writer_test
}  // namespace octant::io
