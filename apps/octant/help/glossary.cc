// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// glossary.json is the only source of explanations of the program's terms: for octant explain, the guide's
// glossary and the man page.
#include "apps/octant/help/glossary.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/octant/text/layout.h"

namespace octant::app {
namespace {

using enum GlossaryKind;

constexpr std::size_t kPageColumns = 110;  // of the page of words

std::string plain(std::string_view word) {
  std::string out;
  for (const char c : word)
    out += c == '_' || c == '-' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  while (!out.empty() && out.back() == ' ') out.pop_back();
  const std::size_t first = out.find_first_not_of(' ');
  out.erase(0, std::min(first, out.size()));
  constexpr std::string_view kExitWord = "exit ";
  return out.starts_with(kExitWord) ? out.substr(kExitWord.size()) : out;
}

const char* heading(GlossaryKind kind) {
  switch (kind) {
    case kTerm: return "Terms";
    case kGrade: return "Grades of a verdict";
    case kReason: return "Why an arrival is left out, why there is no fix, what contradicts";
    case kExit: return "Exit codes";
  }
  return "";
}

constexpr std::pair<const char*, GlossaryKind> kLists[] = {
    {"terms", kTerm}, {"grades", kGrade}, {"reasons", kReason}, {"exits", kExit}};

std::vector<GlossaryTerm> terms_of(const nlohmann::json& lists) {
  std::vector<GlossaryTerm> terms;
  for (const auto& [list, kind] : kLists)
    for (const auto& term : lists.at(list))
      terms.push_back({kind, term.at("name").get<std::string>(), term.at("others").get<std::string>(),
                       term.at("text").get<std::string>()});
  return terms;
}

}  // namespace

const std::vector<GlossaryTerm>& glossary() {
  static const std::vector<GlossaryTerm> terms = terms_of(nlohmann::json::parse(glossary_data()));
  return terms;
}

namespace {

/// Returns true if a test holds for a term's name or one of its synonyms.
template <class Test>
bool any_spelling(const GlossaryTerm& term, const Test& holds) {
  if (holds(std::string_view(term.name))) return true;
  for (std::string_view others = term.others; !others.empty();) {
    const std::size_t end = std::min(others.find(','), others.size());
    if (holds(others.substr(0, end))) return true;
    others.remove_prefix(std::min(end + 1, others.size()));
  }
  return false;
}

/// Lower case; everything except letters, digits and column separators becomes a blank.
std::string only_words(std::string_view text) {
  std::string out = " ";
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    out += std::isalnum(u) != 0 || c == '|' || c == '%' ? static_cast<char>(std::tolower(u)) : ' ';
    if (out.size() > 1 && out.back() == ' ' && out[out.size() - 2] == ' ') out.pop_back();
  }
  return out + " ";
}

bool has_spelling(const std::string& words, std::string_view spelling) {
  constexpr std::size_t kShort = 2;  // synonyms of up to this many letters count only in headings
  std::string wanted = only_words(spelling);
  if (wanted.size() <= 2) return false;
  if (wanted.size() - 2 <= kShort) wanted = "|" + wanted;
  return words.find(wanted) != std::string::npos;
}

}  // namespace

const GlossaryTerm* find_term(std::string_view word) {
  const std::string wanted = plain(word);
  for (const GlossaryTerm& term : glossary())
    if (any_spelling(term, [&](std::string_view spelling) { return plain(spelling) == wanted; }))
      return &term;
  return nullptr;
}

std::vector<const GlossaryTerm*> terms_used(std::string_view text) {
  const std::string words = only_words(text);
  std::vector<const GlossaryTerm*> used;
  for (const GlossaryTerm& term : glossary())
    if (any_spelling(term, [&](std::string_view spelling) { return has_spelling(words, spelling); }))
      used.push_back(&term);
  return used;
}

std::string glossary_page() {
  std::string page =
      "# Words\n\nThe terms of the outputs, a paragraph each. `octant explain WORD` prints one of them.\n";
  const char* last = "";
  for (const GlossaryTerm& term : glossary()) {
    if (heading(term.kind) != last) page += fmt::format("\n## {}\n", last = heading(term.kind));
    page +=
        "\n" + paragraph(fmt::format("**{}**{}. {}", term.name,
                                     term.others.empty() ? "" : fmt::format(" ({})", term.others), term.text),
                         kPageColumns);
  }
  return page;
}

}  // namespace octant::app
