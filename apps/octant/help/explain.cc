// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/octant/help/glossary.h"
#include "apps/octant/help/help.h"
#include "apps/octant/text/layout.h"

namespace octant::app {
namespace {

struct ExplainArgs {
  std::vector<std::string> term;
  bool page = false;
};

int explain(const ExplainArgs& args, Session& session) {
  if (args.page) {
    if (!session.options.json) return session.finish_document(glossary_page());
    return session.finish({{"page", glossary_page()}});
  }
  std::vector<std::string> known;
  for (const GlossaryTerm& t : glossary()) known.emplace_back(t.name);
  if (args.term.empty()) {
    session.result(paragraph(fmt::format("{}", fmt::join(known, ", "))) +
                   "\noctant explain WORD explains one of them.\n");
    return session.finish({{"terms", known}});
  }
  const std::string wanted = fmt::format("{}", fmt::join(args.term, " "));
  const GlossaryTerm* term = find_term(wanted);
  if (term == nullptr) {
    fail_usage(fmt::format("'{}' is not among the words{}", wanted, did_you_mean(wanted, known)),
               "octant explain lists them all");
  }
  const std::string name = (term->kind == GlossaryKind::kExit ? "exit " : "") + std::string(term->name);
  session.result(paragraph(fmt::format("{}: {}", name, term->text)));
  return session.finish({{"term", name}, {"text", term->text}});
}

}  // namespace

void add_explain(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<ExplainArgs>(
      app, common, action, "explain", "Explain a word of the outputs or an exit code",
      "octant explain variance factor\n  octant explain 6", explain);
  add_option(*command, "term", args->term, "TERM|CODE",
             "A term, a reason, a grade or an exit code; left out: lists them");
  command->add_flag("--page", args->page, "All of them as a page of Markdown");
}

}  // namespace octant::app
