// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/escape.h"

#include <cctype>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <nlohmann/json.hpp>

namespace octant::survey {
namespace escape_test {

/// Decodes character references like a browser.
std::string unescaped(std::string text) {
  const std::pair<const char*, const char*> references[] = {
      {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&#39;", "'"}, {"&amp;", "&"}};
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    bool found = false;
    for (const auto& [reference, character] : references)
      if (!found && text.compare(i, std::string(reference).size(), reference) == 0)
        out += character, i += std::string(reference).size(), found = true;
    if (!found) out += text[i++];
  }
  return out;
}

std::string some_text() {
  return *rc::gen::container<std::string>(rc::gen::weightedOneOf<char>(
      {{3, rc::gen::element('<', '>', '&', '"', '\'', ';', '#', '\n', '\t', '\\', '|', '*', '`')},
       {1, rc::gen::inRange('\x01', '\x20')},
       {3, rc::gen::inRange(' ', '~')},
       {1, rc::gen::element('\xC3', '\xBC')}}));
}

/// Characters that XML does not know at all are blanks.
std::string without_controls(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') c = ' ';
  return text;
}

TEST(EscapeXml, ReadsBackAsTheText) {
  EXPECT_TRUE(rc::check("and has nothing that ends content or an attribute", [] {
    const std::string text = some_text(), safe = escape_xml(text);
    RC_ASSERT(unescaped(safe) == without_controls(text));
    RC_ASSERT(safe.find_first_of("<>\"'") == std::string::npos);
    for (const char c : safe) RC_ASSERT(static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t');
  }));
}

TEST(EscapeXml, EscapesReferencesThemselves) {
  EXPECT_EQ(escape_xml("&lt;"), "&amp;lt;");
  EXPECT_EQ(escape_xml("Süd <1> & \"2\""), "Süd &lt;1&gt; &amp; &quot;2&quot;");
  EXPECT_EQ(escape_xml(std::string("a\0b\x1F", 4)), "a b ");
}

TEST(EscapeScriptJson, IsTheSameJsonAndEndsNoScript) {
  EXPECT_TRUE(rc::check("what stands in the strings stays", [] {
    const nlohmann::json json = {{some_text(), {some_text(), 1.5, nullptr}}, {"<!--", "</script>"}};
    const std::string text = json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    const std::string safe = escape_script_json(text);
    RC_ASSERT(nlohmann::json::parse(safe) == nlohmann::json::parse(text));
    RC_ASSERT(safe.find_first_of("<>&") == std::string::npos);
  }));
}

/// Decodes backslashes before punctuation and references like CommonMark; `special`: a character with a
/// meaning is unescaped.
std::string markdown_read(const std::string& text, bool& special) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size() && std::ispunct(static_cast<unsigned char>(text[i + 1])) != 0)
      out += text[++i];
    else {
      special = special || std::string("\\`*_[]|~#<>\n").find(text[i]) != std::string::npos;
      out += text[i];
    }
  }
  return unescaped(out);
}

TEST(EscapeMarkdown, ReadsBackAsTheTextInOneLine) {
  EXPECT_TRUE(rc::check("and nothing in it has a meaning", [] {
    std::string text = some_text();
    bool special = false;
    const std::string read = markdown_read(escape_markdown(text), special);
    for (char& c : text)
      if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    RC_ASSERT(read == text);
    RC_ASSERT(!special);
  }));
}

/// A text is often at the beginning of a line, where some characters have more meanings.
TEST(EscapeMarkdown, BeginsNoListAndNoRule) {
  for (const auto& [text, escaped] : {std::pair{"- a", "\\- a"},
                                      {"+ a", "\\+ a"},
                                      {"1. a", "1\\. a"},
                                      {"27) a", "27\\) a"},
                                      {"  - a", "  \\- a"},
                                      {"- - -", "\\- - -"},
                                      {"---", "\\---"}})
    EXPECT_EQ(escape_markdown(text), escaped);
  for (const char* plain : {"-", "-1.5", "1.5 m", "B1.", "2026", "--", "a - b", "a 1. b", "1.x"})
    EXPECT_EQ(escape_markdown(plain), plain) << "nothing begins with it";
}

}  // namespace escape_test
}  // namespace octant::survey
