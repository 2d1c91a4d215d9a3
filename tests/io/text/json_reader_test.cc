// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/json_reader.h"

#include <limits>
#include <random>

#include "tests/io/io_support.h"

namespace octant::io {
namespace json_reader_test {

using test::expect_error;
using testing::HasSubstr;
using Json = nlohmann::ordered_json;

/// Any document, with texts that hold what has a meaning outside of them.
Json some_json(std::mt19937& draws, int depth) {
  const auto below = [&](unsigned n) { return draws() % n; };
  const auto text = [&] {
    std::string out;
    for (unsigned i = below(6); i > 0; --i) out += "a\"\\{}[],: /"[below(11)];
    return out;
  };
  const unsigned kind = depth > 3 ? 5 + below(2) : below(depth > 0 ? 7 : 5);
  if (kind == 0) return nullptr;
  if (kind == 1) return below(2) == 0;
  if (kind == 2) return static_cast<int>(below(2000)) - 1000;
  if (kind == 3) return (static_cast<double>(below(2000)) - 1000) / 3;
  if (kind == 4) return text();
  Json out = kind == 5 ? Json::array() : Json::object();
  for (unsigned i = below(5); i > 0; --i) {
    if (kind == 5)
      out.push_back(some_json(draws, depth - 1));
    else
      out["k" + std::to_string(below(20))] = some_json(draws, depth - 1);
  }
  return out;
}

/// All pointers into a document, with the values they name.
void collect(const Json& json, const std::string& pointer, std::vector<std::pair<std::string, Json>>& all) {
  all.emplace_back(pointer, json);
  if (json.is_array())
    for (std::size_t i = 0; i < json.size(); ++i) collect(json[i], pointer + "/" + std::to_string(i), all);
  if (json.is_object())
    for (const auto& [key, value] : json.items()) collect(value, pointer + "/" + key, all);
}

std::size_t offset_of(const std::string& text, TextPosition at) {
  std::size_t offset = 0;
  for (int line = 1; line < at.line; ++line) offset = text.find('\n', offset) + 1;
  return offset + static_cast<std::size_t>(at.column) - 1;
}

/// Returns true if a text begins with a value, by a parser that receives only this value.
bool begins_with(const std::string& text, const Json& value) {
  for (std::size_t end = text.size(); end > 0; --end)
    if (Json::accept(text.substr(0, end))) return Json::parse(text.substr(0, end)) == value;
  return false;
}

TEST(JsonReader, EveryPointerLeadsToItsValueInAnyLayout) {
  std::mt19937 draws(20261125);
  std::size_t looked_at = 0;
  for (int i = 0; i < 150; ++i) {
    const Json json = some_json(draws, 4);
    for (const std::string& text : {json.dump(), json.dump(3, '\t'), pretty(json)}) {
      std::vector<std::pair<std::string, Json>> all;
      collect(json, "", all);
      for (const auto& [pointer, value] : all) {
        const auto at = locate(text, pointer);
        ASSERT_TRUE(at) << pointer << " in " << text;
        EXPECT_TRUE(begins_with(text.substr(offset_of(text, *at)), value)) << pointer << " in " << text;
      }
      looked_at += all.size();
      EXPECT_FALSE(locate(text, "/nowhere"));
      EXPECT_FALSE(locate(text, "/0/0/0/0/0/0/0"));
    }
  }
  EXPECT_GT(looked_at, 1000U);
}

TEST(JsonReader, PrettyIsTheSameDocument) {
  std::mt19937 draws(2);
  for (int i = 0; i < 300; ++i) {
    const Json json = some_json(draws, 4);
    EXPECT_EQ(Json::parse(pretty(json)), json);
    EXPECT_EQ(pretty(json).back(), '\n');
  }
}

TEST(JsonReader, PrettyHasAKeyALineAndNumbersOnOne) {
  const Json json = {
      {"a", 1}, {"b", {1, 2, 3}}, {"c", {{1, 2}, {3, 4}}}, {"d", {{{"e", nullptr}}}}, {"f", Json::object()}};
  EXPECT_EQ(pretty(json),
            "{\n \"a\": 1,\n \"b\": [1,2,3],\n \"c\": [[1,2],[3,4]],\n \"d\": [\n  {\n   \"e\": null\n  }\n "
            "],\n \"f\": "
            "{}\n}\n");
  EXPECT_NO_THROW((void)pretty(Json("\xFF"))) << "what is no UTF-8 is replaced";
}

TEST(JsonReader, SaysWhereADocumentIsNone) {
  expect_error(parse_json("", "a.json"), 1, "the file is empty", "a.json");
  expect_error(parse_json("{\"a\": 1,\n\"b\": ", "a"), 2, "ends too early");
  expect_error(parse_json("{\"a\": 1,\n x}", "a"), 2, "not JSON");
  expect_error(parse_json("{} {}", "a"), 1, "not JSON");
  expect_error(parse_json("{\"a\": \"\xFF\"}", "a"), 1, "byte 0xFF");
  expect_error(parse_json("[1e999]", "a"), 0, "cannot be read");
  EXPECT_TRUE(parse_json("\xEF\xBB\xBF[1]", "a")) << "a mark before it is fine";
  expect_error(parse_json(std::string(100, '[') + std::string(100, ']'), "a"), 1, "bracket");
}

/// A document, read through its log.
struct Reading {
  explicit Reading(std::string content)
      : text(std::move(content)), json(nlohmann::json::parse(text)), log{"a.json", text, {}} {}
  [[nodiscard]] JsonValue root() { return {&json, "", log}; }
  [[nodiscard]] std::string error() const { return log.error ? log.error->message() : ""; }
  std::string text;
  nlohmann::json json;
  JsonLog log;
};

TEST(JsonReader, ValuesAreWhatTheyAre) {
  Reading r(R"({"n": 1.5, "c": 7, "b": true, "t": "x", "v": [1, 2, 3], "l": ["a", "b"], "z": null})");
  const JsonValue root = r.root();
  EXPECT_EQ(root.at("n").number(), 1.5);
  EXPECT_EQ(root.at("c").count(), 7U);
  EXPECT_TRUE(root.at("b").boolean());
  EXPECT_EQ(root.at("t").text(), "x");
  EXPECT_EQ(root.at("v").vector3(), Eigen::Vector3d(1, 2, 3));
  EXPECT_THAT(root.at("l").texts(), testing::ElementsAre("a", "b"));
  EXPECT_EQ(root.at("l").items().size(), 2U);
  EXPECT_FALSE(root.find("z").present()) << "null is nothing";
  EXPECT_FALSE(root.find("y").present());
  EXPECT_EQ(root.find("y").number(), 0.0) << "nothing has a fallback and is no error";
  EXPECT_EQ(root.find("y").find("x").find("w").text(), "");
  EXPECT_EQ(r.error(), "");
}

TEST(JsonReader, EachFaultIsNamedByPointerAndLine) {
  const std::string text = "{\n\"n\": \"x\",\n\"c\": -1,\n\"v\": [1,\n null, 3],\n\"t\": 5,\n\"o\": []\n}";
  const auto error = [&](auto read) {
    Reading r(text);
    read(r.root());
    return r.error();
  };
  using V = const JsonValue&;
  EXPECT_THAT(error([](V v) { (void)v.at("n").number(); }),
              HasSubstr("a.json:2:6: /n is 'x'; expected a finite number"));
  EXPECT_THAT(error([](V v) { (void)v.at("c").count(); }),
              HasSubstr("a.json:3:6: /c is -1; expected a whole number"));
  EXPECT_THAT(error([](V v) { (void)v.at("c").number(kNotNegative); }),
              HasSubstr("zero or a positive number"));
  EXPECT_THAT(error([](V v) { (void)v.at("c").number(kPositive); }), HasSubstr("a positive number"));
  EXPECT_THAT(error([](V v) { (void)v.at("c").number(kFraction); }), HasSubstr("a fraction from 0 to 1"));
  EXPECT_THAT(error([](V v) { (void)v.at("c").boolean(); }), HasSubstr("true or false"));
  EXPECT_THAT(error([](V v) { (void)v.at("v").vector3(); }), HasSubstr("a.json:5:2: /v/1 is null"));
  EXPECT_THAT(error([](V v) { (void)v.at("v").numbers(2); }),
              HasSubstr("/v is an array of 3; expected an array of 2"));
  EXPECT_THAT(error([](V v) { (void)v.at("t").text(); }), HasSubstr("/t is 5; expected text"));
  EXPECT_THAT(error([](V v) { (void)v.at("t").items(); }), HasSubstr("/t is 5; expected an array"));
  EXPECT_THAT(error([](V v) { (void)v.at("o").find("x"); }),
              HasSubstr("/o is an array of 0; expected an object"));
  EXPECT_THAT(error([](V v) { (void)v.at("none"); }), HasSubstr("the document is without 'none'"));
}

TEST(JsonReader, TheFirstFaultSticksAndTheRestGoesOn) {
  Reading r(R"({"a": "x", "b": "y"})");
  const JsonValue root = r.root();
  (void)root.at("a").number();
  (void)root.at("b").number();
  (void)root.at("c");
  EXPECT_THAT(r.error(), HasSubstr("/a is 'x'"));
  EXPECT_EQ(root.at("c").at("d").vector3(), Eigen::Vector3d(0, 0, 0));
}

TEST(JsonReader, ChoicesAreWordsOfAList) {
  const std::vector<std::pair<std::string, int>> choices = {{"one", 1}, {"two", 2}};
  Reading good(R"("two")"), bad(R"("three")");
  EXPECT_EQ(good.root().choice(choices), 2);
  EXPECT_EQ(good.error(), "");
  EXPECT_EQ(bad.root().choice(choices), 1) << "the first, as a fallback";
  EXPECT_THAT(bad.error(), HasSubstr("the document is 'three'; expected one of one, two"));
}

TEST(JsonReader, CountsAreWholeAndNotNegative) {
  for (const char* bad : {"1.0", "-0.5", "\"1\"", "1e3", "true"}) {
    Reading r(bad);
    EXPECT_EQ(r.root().count(), 0U);
    EXPECT_THAT(r.error(), HasSubstr("a whole number")) << bad;
  }
  Reading big("18446744073709551615");
  EXPECT_EQ(big.root().count(), std::numeric_limits<std::size_t>::max());
}

TEST(JsonReader, PlacesAreThoseOfTheTextBehindItsMark) {
  const std::string text = "\xEF\xBB\xBF{\n\"n\": \"x\"}";
  nlohmann::json json = parse_json(text, "a.json").value();
  JsonLog log{"a.json", text, {}};
  (void)JsonValue(&json, "", log).at("n").number();
  EXPECT_EQ(log.error->line, 2);
  EXPECT_EQ(log.error->column, 6);
}

}  // namespace json_reader_test
}  // namespace octant::io
