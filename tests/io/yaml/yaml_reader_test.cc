// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/yaml/yaml_reader.h"

#include <cmath>

#include "tests/io/io_support.h"

namespace octant::io {
namespace yaml_reader_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A document, its mapping and the result of the reader.
struct Reading {
  explicit Reading(const std::string& text)
      : node(parse_yaml(text, "a.yaml").value()), log("a.yaml"), map(node, "", log) {}
  YamlNode node;
  YamlLog log;
  YamlMap map;
  [[nodiscard]] std::string error() const { return log.error ? log.error->message() : ""; }
};

TEST(YamlReader, NumbersAreDecimalAndWhatYamlCallsNumbers) {
  for (const auto& [text, expected] : std::vector<std::pair<const char*, double>>{
           {"1", 1}, {"-2.5", -2.5}, {"+3e-4", 3e-4}, {".5", 0.5}, {"1E3", 1000}, {"007", 7}}) {
    Reading r("k: " + std::string(text));
    EXPECT_EQ(r.map.number("k", 9), expected) << text;
    EXPECT_EQ(r.error(), "");
  }
}

TEST(YamlReader, WhatIsNoNumberIsNamedWithItsPlaceAndTheFallbackStands) {
  for (const auto& [text, found] :
       std::vector<std::pair<const char*, const char*>>{{"abc", "k is 'abc'"},
                                                        {"'1'", "k is '1' in quotes"},
                                                        {"1,5", "k is '1,5'"},
                                                        {"0x10", "k is '0x10'"},
                                                        {"1_000", "k is '1_000'"},
                                                        {"[1]", "k is a list"},
                                                        {"{a: 1}", "k is a mapping"},
                                                        {".nan", "k is '.nan'"},
                                                        {"-.inf", "k is '-.inf'"},
                                                        {"1e400", "k is '1e400'"},
                                                        {"true", "k is 'true'"}}) {
    Reading r("# c\nk: " + std::string(text));
    EXPECT_EQ(r.map.number("k", 9), 9.0) << text;
    EXPECT_THAT(r.error(), HasSubstr(found));
    EXPECT_THAT(r.error(), HasSubstr("a.yaml:2:4")) << text;
    EXPECT_THAT(r.error(), HasSubstr("a number"));
  }
  Reading quoted("k: '1'");
  (void)quoted.map.number("k", 0);
  EXPECT_EQ(quoted.log.error->advice, "leave the quotes out");
}

TEST(YamlReader, RangesHoldTheirEndsUnlessTheyExcludeThem) {
  const auto accepted = [](const char* text, NumberRange range) {
    Reading r("k: " + std::string(text));
    (void)r.map.number("k", 0.5, range);
    if (r.log.error) EXPECT_EQ(r.log.error->expected, range.words);
    return !r.log.error;
  };
  EXPECT_TRUE(accepted("1e-300", kPositive));
  EXPECT_FALSE(accepted("0", kPositive));
  EXPECT_FALSE(accepted("-1", kPositive));
  EXPECT_TRUE(accepted("0", kNotNegative));
  EXPECT_FALSE(accepted("-1e-300", kNotNegative));
  EXPECT_TRUE(accepted("0", kFraction) && accepted("1", kFraction));
  EXPECT_FALSE(accepted("1.0000001", kFraction));
  EXPECT_FALSE(accepted("50", kFraction)) << "percent";
}

TEST(YamlReader, WholeNumbersHaveNoFraction) {
  const auto read = [](const char* text) {
    Reading r("k: " + std::string(text));
    const int value = r.map.integer("k", -1, 0, 10);
    EXPECT_EQ(r.error().empty(), value != -1) << text;
    return value;
  };
  EXPECT_EQ(read("7"), 7);
  EXPECT_EQ(read("7.0"), 7);
  EXPECT_EQ(read("0"), 0);
  EXPECT_EQ(read("10"), 10);
  for (const char* bad : {"7.5", "11", "-1", "1e99", ".nan", "seven", "'7'"}) EXPECT_EQ(read(bad), -1) << bad;
  Reading r("k: 11");
  (void)r.map.integer("k", 0, 0, 10);
  EXPECT_THAT(r.error(), HasSubstr("a whole number from 0 to 10"));
}

TEST(YamlReader, TrueAndFalseAreNothingElse) {
  for (const char* yes : {"true", "True", "TRUE"})
    EXPECT_TRUE(Reading("k: " + std::string(yes)).map.boolean("k", false));
  for (const char* no : {"false", "False", "FALSE"}) {
    Reading r("k: " + std::string(no));
    EXPECT_FALSE(r.map.boolean("k", true));
    EXPECT_EQ(r.error(), "");
  }
  for (const char* neither : {"yes", "no", "on", "1", "0", "'true'", "tRue", "[true]"}) {
    Reading r("k: " + std::string(neither));
    EXPECT_TRUE(r.map.boolean("k", true)) << "the fallback";
    EXPECT_THAT(r.error(), HasSubstr("true or false")) << neither;
  }
}

TEST(YamlReader, AKeyWithoutAValueIsAnErrorForValuesAndNoBlock) {
  Reading scalar("# c\n\nk:\n");
  EXPECT_EQ(scalar.map.number("k", 9), 9.0);
  EXPECT_THAT(scalar.error(), HasSubstr("a.yaml:3:1: 'k' has no value"));
  Reading block("k:\nl: ~\n");
  EXPECT_FALSE(block.map.block("k").is_defined());
  EXPECT_FALSE(block.map.has("k") || block.map.has("l") || block.map.has("m"));
  EXPECT_THAT(block.map.list("l"), IsEmpty());
  EXPECT_EQ(block.error(), "");
}

TEST(YamlReader, AbsentKeysGiveTheFallbackAndRequiredOnesAnError) {
  Reading r("a: 1\n");
  EXPECT_EQ(r.map.number("k", 9), 9.0);
  EXPECT_EQ(r.map.integer("k", 3, 0, 9), 3);
  EXPECT_TRUE(r.map.boolean("k", true));
  EXPECT_EQ(r.map.text("k", "t"), "t");
  EXPECT_EQ(r.map.optional_number("k"), std::nullopt);
  EXPECT_THAT(r.map.numbers("k", 3), IsEmpty());
  EXPECT_EQ(r.error(), "");
  EXPECT_EQ(r.map.required_number("sigma_m", kPositive), 0.0);
  EXPECT_THAT(r.error(), HasSubstr("'sigma_m' is missing"));
  EXPECT_EQ(r.log.error->expected, "a positive number");
}

/// Keys that were requested are not suggested as misspellings of a missing one.
TEST(YamlReader, AMissingKeyIsHeldAgainstThoseThatNobodyAskedFor) {
  Reading r("model: x\nsigma_mp: 1\n");
  (void)r.map.text("model", "");
  (void)r.map.required_number("sigma_mps");
  EXPECT_THAT(r.error(), HasSubstr("misspelt? the file says 'sigma_mp'"));
  Reading known("sigma_mp: 1\n");
  (void)known.map.number("sigma_mp", 0);
  (void)known.map.required_number("sigma_mps");
  EXPECT_EQ(known.log.error->advice, "") << "that one is another key";
  Reading far("model: x\n");
  (void)far.map.required_text("name");
  EXPECT_EQ(far.log.error->advice, "");
}

TEST(YamlReader, TheFirstErrorSticks) {
  Reading r("a: x\nb: y\n");
  (void)r.map.number("a", 0);
  const std::string first = r.error();
  (void)r.map.number("b", 0);
  (void)r.map.required_text("c");
  EXPECT_EQ(r.error(), first);
}

TEST(YamlReader, PathsNameTheBlocksTheyAreIn) {
  Reading r("medium:\n  sigma_mps: x\n");
  YamlMap medium(r.map.block("medium"), "medium", r.log);
  EXPECT_TRUE(medium.present());
  EXPECT_EQ(medium.path("sigma_mps"), "medium.sigma_mps");
  (void)medium.number("sigma_mps", 0);
  EXPECT_THAT(r.error(), HasSubstr("a.yaml:2:14: medium.sigma_mps is 'x'"));
  YamlLog log("a.yaml");
  YamlMap none(YamlNode(), "none", log);
  EXPECT_FALSE(none.present());
  EXPECT_EQ(none.number("k", 5), 5.0);
  EXPECT_FALSE(log.error);
}

TEST(YamlReader, ABlockThatIsNoMappingIsNamed) {
  Reading r("medium: 5\n");
  const YamlMap medium(r.map.block("medium"), "medium", r.log);
  EXPECT_FALSE(medium.present());
  EXPECT_THAT(r.error(), HasSubstr("medium is '5'"));
  EXPECT_THAT(Reading("- 1\n").error(), HasSubstr("the file's content is a list"));
}

TEST(YamlReader, KeysAreWordsAndStandOnce) {
  EXPECT_THAT(Reading("a: 1\nb: 2\na: 3\n").error(), HasSubstr("a.yaml:3:1: 'a' is given twice"));
  EXPECT_THAT(Reading("[1]: 2\n").error(), HasSubstr("a key that is a list"));
  std::string many;
  for (int i = 0; i < 1001; ++i) many += "k" + std::to_string(i) + ": 1\n";
  EXPECT_THAT(Reading(many).error(), HasSubstr("a mapping of 1001 keys"));
}

TEST(YamlReader, ListsHaveTheirLength) {
  Reading r("three: [1, 2, 3]\nodd: [1, x]\nmap: {a: 1}\n");
  EXPECT_THAT(r.map.numbers("three", 3), ElementsAre(1, 2, 3));
  EXPECT_THAT(r.map.numbers("three", 0), ElementsAre(1, 2, 3)) << "any number of them";
  EXPECT_EQ(r.error(), "");
  EXPECT_THAT(r.map.numbers("three", 2), ElementsAre(0, 0)) << "one may index what was asked for";
  EXPECT_THAT(r.error(), HasSubstr("three has 3 items"));
  EXPECT_EQ(r.log.error->expected, "a list of 2");
  Reading odd("odd: [1, x]\n");
  (void)odd.map.numbers("odd", 2);
  EXPECT_THAT(odd.error(), HasSubstr("odd[1] is 'x'"));
  Reading map("map: {a: 1}\n");
  (void)map.map.list("map");
  EXPECT_THAT(map.error(), HasSubstr("map is a mapping"));
}

enum class Kind { kStops, kDrive };
const std::vector<std::pair<std::string, Kind>> kKinds = {{"stops", Kind::kStops}, {"drive", Kind::kDrive}};

TEST(YamlReader, ChoicesAreWordsOfAList) {
  EXPECT_EQ(Reading("k: drive\n").map.choice("k", kKinds, Kind::kStops), Kind::kDrive);
  EXPECT_EQ(Reading("a: 1\n").map.choice("k", kKinds, Kind::kDrive), Kind::kDrive);
  Reading r("k: drives\n");
  EXPECT_EQ(r.map.choice("k", kKinds, Kind::kStops), Kind::kStops);
  EXPECT_THAT(r.error(), HasSubstr("k is 'drives'"));
  EXPECT_EQ(r.log.error->expected, "one of stops, drive");
  EXPECT_THAT(r.log.error->advice, HasSubstr("did you mean 'drive'?"));
  Reading far("k: zebra\n");
  (void)far.map.choice("k", kKinds, Kind::kStops);
  EXPECT_EQ(far.log.error->advice, "");
}

TEST(YamlReader, KeysThatNobodyKnowsAreWarningsWithWhatTheyMayMean) {
  Reading r("sigma_mps: 1\nsigma_mp: 2\nzebra: 3\n");
  (void)r.map.number("sigma_mps", 0);
  (void)r.map.number("model", 0);
  r.map.finish();
  ASSERT_EQ(r.log.warnings.size(), 2U);
  EXPECT_THAT(r.log.warnings[0], HasSubstr("a.yaml:2: unknown key 'sigma_mp' is ignored"));
  EXPECT_THAT(r.log.warnings[0], HasSubstr("'sigma_mps'"));
  EXPECT_THAT(r.log.warnings[1], HasSubstr("a.yaml:3: unknown key 'zebra' is ignored"));
  EXPECT_EQ(r.error(), "");
}

/// Without its position a beacon has another meaning: its position is unknown.
TEST(YamlReader, AMisspeltPlaceIsAnError) {
  Reading r("positon_m: [1, 2, 3]\n");
  (void)r.map.numbers("position_m", 3);
  r.map.finish();
  EXPECT_THAT(r.error(), HasSubstr("unknown key 'positon_m'"));
  EXPECT_THAT(r.error(), HasSubstr("did you mean 'position_m'?"));
  Reading both("positon_m: [1, 2, 3]\nposition_m: [1, 2, 3]\n");
  (void)both.map.numbers("position_m", 3);
  both.map.finish();
  EXPECT_EQ(both.error(), "") << "it is not lost";
  EXPECT_EQ(both.log.warnings.size(), 1U);
}

TEST(YamlReader, AVersionIsOneOrAnError) {
  const auto error = [](const std::string& text, const char* key) {
    Reading r(text);
    check_version(r.map, key, r.log);
    return r.error();
  };
  EXPECT_EQ(error("octant_run: 1\n", "octant_run"), "");
  EXPECT_THAT(error("octant_run: 2\n", "octant_run"), HasSubstr("version '2' of the format"));
  EXPECT_THAT(error("octant_run: [1]\n", "octant_run"), HasSubstr("version a list"));
  EXPECT_THAT(error("a: 1\n", "octant_run"), HasSubstr("'octant_run' is missing"));
  EXPECT_THAT(error("octant_site: 1\n", "octant_scene"), HasSubstr("a site file; expected octant_scene: 1"));
  EXPECT_THAT(error("octant_site: 1\n", "octant_scene"), HasSubstr("octant schema scene"));
}

}  // namespace yaml_reader_test
}  // namespace octant::io
