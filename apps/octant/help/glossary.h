// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace octant::app {

enum class GlossaryKind { kTerm, kGrade, kReason, kExit };

/// A word of the program's outputs, in a paragraph.
struct GlossaryTerm {
  GlossaryKind kind = GlossaryKind::kTerm;
  std::string name;
  std::string others;  ///< spellings that mean the same, comma between them
  std::string text;
};

/// Text of glossary.json, which octant_embed() puts into the program.
[[nodiscard]] std::string_view glossary_data();

/// All of them: terms, grades of a verdict, reasons why an arrival is left out, exit codes. By kind, then
/// name.
[[nodiscard]] const std::vector<GlossaryTerm>& glossary();

/// The term of this name or spelling, whatever its case; "exit 5" and "5" are the same. Null if there is
/// none.
[[nodiscard]] const GlossaryTerm* find_term(std::string_view word);

/// Terms that a text has, or one of their spellings, as words of their own, in the glossary's order;
/// spellings of one or two letters count as the heading of a column alone ("| r |").
[[nodiscard]] std::vector<const GlossaryTerm*> terms_used(std::string_view text);

/// As a page of Markdown.
[[nodiscard]] std::string glossary_page();

}  // namespace octant::app
