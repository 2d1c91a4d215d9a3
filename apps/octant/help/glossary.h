// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace octant::app {

enum class GlossaryKind { kTerm, kGrade, kReason, kExit };

/// A term used in the program's outputs, with its explanation.
struct GlossaryTerm {
  GlossaryKind kind = GlossaryKind::kTerm;
  std::string name;
  std::string others;  ///< synonyms, separated by commas
  std::string text;
};

/// Text of glossary.json, embedded by octant_embed().
[[nodiscard]] std::string_view glossary_data();

/// All terms: vocabulary, grades of a verdict, reasons for rejected arrivals, exit codes. Ordered by kind,
/// then name.
[[nodiscard]] const std::vector<GlossaryTerm>& glossary();

/// Finds a term by name or synonym, ignoring case; "exit 5" and "5" are equivalent. Null if there is none.
[[nodiscard]] const GlossaryTerm* find_term(std::string_view word);

/// Terms that occur in a text as separate words, in the order of the glossary. Synonyms of one or two letters
/// count only as the heading of a column ("| r |").
[[nodiscard]] std::vector<const GlossaryTerm*> terms_used(std::string_view text);

/// The glossary as a page of Markdown.
[[nodiscard]] std::string glossary_page();

}  // namespace octant::app
