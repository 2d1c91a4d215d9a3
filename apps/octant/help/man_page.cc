// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "apps/octant/help/glossary.h"
#include "apps/octant/help/help.h"

namespace octant::app {
namespace {

/// Escapes text for man macros (groff_man(7)).
std::string roff(std::string_view text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    line_begins = c == '\n';
  }
  return out;
}

std::string man_option(const CLI::Option& option) {
  // Removes the details that CLI11 appends to a type's name: INT in [0 - 1024].
  const std::string whole_type = option.get_type_name(), type = whole_type.substr(0, whole_type.find(':'));
  std::string name = option.get_positional() ? type : option.get_name();
  if (!option.get_positional() && option.get_type_size() > 0 && !type.empty()) name += " " + type;
  return fmt::format(".TP\n.B {}\n{}\n", roff(name), roff(option.get_description()));
}

std::string man_options(const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : command.get_options())
    if (option->get_group() != kCommonGroup) text += man_option(*option);
  return text;
}

std::string man_command(const CLI::App& command, const std::string& parent) {
  const std::string name = parent + " " + command.get_name();
  std::string text =
      fmt::format(".SS {}\n{}.\n{}", roff(name), roff(command.get_description()), man_options(command));
  if (!command.get_footer().empty()) text += fmt::format(".PP\n.nf\n{}\n.fi\n", roff(command.get_footer()));
  for (const CLI::App* below : command.get_subcommands([](const CLI::App*) { return true; }))
    text += man_command(*below, name);
  return text;
}

}  // namespace

std::string man_page(const CLI::App& program) {
  std::string text = fmt::format(
      ".TH OCTANT 1 \"\" \"octant " OCTANT_VERSION
      "\"\n.SH NAME\noctant \\- calibrate and survey time\\-of\\-flight beacon positioning\n.SH SYNOPSIS\n.B "
      "octant\n.I COMMAND\n[words] [options]\n.SH DESCRIPTION\n{}\n.SH COMMANDS\n",
      roff(program.get_description()));
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    text += man_command(*command, "octant");
  text += ".SH COMMON OPTIONS\n";
  for (const CLI::Option* option : program.get_options())
    if (option->get_group() == kCommonGroup) text += man_option(*option);
  text += ".SH EXIT STATUS\n";
  for (const GlossaryTerm& term : glossary())
    if (term.kind == GlossaryKind::kExit)
      text += fmt::format(".TP\n.B {}\n{}\n", roff(term.name), roff(term.text));
  text +=
      ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nNo colours on standard error.\n.TP\n.B OCTANT_DEFAULTS\nFile of "
      "defaults; empty: none. Else ~/.config/octant/defaults.yaml is read where it is.\n.TP\n.B "
      "OCTANT_TRUSTED_KEY\nPublic "
      "key "
      "that deployments must be signed by.\n.TP\n.B SOURCE_DATE_EPOCH\nThe time that documents name as "
      "now.\n";
  return text;
}

}  // namespace octant::app
