// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/octant/help/help.h"

namespace octant::app {
namespace {

/// Quotes a text in single quotes for a shell.
std::string in_shell_quotes(std::string_view text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Words that may follow a command: its options and subcommands.
std::string words_after(const CLI::App& command) {
  std::vector<std::string> words = command_names(command);
  const auto options = option_names(command);
  words.insert(words.end(), options.begin(), options.end());
  return fmt::format("{}", fmt::join(words, " "));
}

std::string bash_completion(const CLI::App& program) {
  std::string cases;
  for (const std::string& name : command_names(program)) {
    const CLI::App* command = command_of(program, {name});
    for (const std::string& below : command_names(*command))
      cases += fmt::format("    '{} {}') words='{}' ;;\n", name, below,
                           words_after(*command_of(program, {name, below})));
    cases += fmt::format("    '{}'|'{} '*) words='{}' ;;\n", name, name, words_after(*command));
  }
  return fmt::format(
      "# Completion of octant for bash: octant completion bash > /etc/bash_completion.d/octant\n"
      "_octant() {{\n"
      "  local cur=${{COMP_WORDS[COMP_CWORD]}} words='' first='' second=''\n"
      "  if [ \"$COMP_CWORD\" -gt 1 ]; then first=${{COMP_WORDS[1]}}; fi\n"
      "  if [ \"$COMP_CWORD\" -gt 2 ]; then second=${{COMP_WORDS[2]}}; fi\n"
      "  case \"$first${{second:+ $second}}\" in\n"
      "    '') words='{}' ;;\n"
      "{}"
      "  esac\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
      "  if [ -n \"$first\" ] && [ \"${{cur#-}}\" = \"$cur\" ]; then COMPREPLY+=($(compgen -f -- \"$cur\")); "
      "fi\n"
      "}}\n"
      "complete -o filenames -F _octant octant\n",
      words_after(program), cases);
}

std::string zsh_completion(const CLI::App& program) {
  std::string commands, cases;
  for (const std::string& name : command_names(program)) {
    const CLI::App* command = command_of(program, {name});
    commands += fmt::format("    {}\n", in_shell_quotes(name + ":" + command->get_description()));
    cases += fmt::format("    {}) choices=({}) ;;\n", name, words_after(*command));
  }
  return fmt::format(
      "#compdef octant\n"
      "# Completion of octant for zsh: octant completion zsh > a folder of $fpath, as _octant\n"
      "_octant() {{\n"
      "  local -a commands choices\n"
      "  commands=(\n{}  )\n"
      "  if (( CURRENT == 2 )); then _describe command commands; return; fi\n"
      "  case ${{words[2]}} in\n{}  esac\n"
      "  compadd -- $choices\n"
      "  _files\n"
      "}}\n"
      "_octant \"$@\"\n",
      commands, cases);
}

std::string fish_completion(const CLI::App& program) {
  std::string text =
      "# Completion of octant for fish: octant completion fish > ~/.config/fish/completions/octant.fish\n";
  for (const std::string& name : command_names(program)) {
    const CLI::App* command = command_of(program, {name});
    text += fmt::format("complete -c octant -n __fish_use_subcommand -f -a {} -d {}\n", name,
                        in_shell_quotes(command->get_description()));
    for (const std::string& below : command_names(*command))
      text += fmt::format("complete -c octant -n '__fish_seen_subcommand_from {}' -f -a {} -d {}\n", name,
                          below, in_shell_quotes(command_of(program, {name, below})->get_description()));
    for (const CLI::Option* option : command->get_options())
      for (const std::string& long_name : option->get_lnames())
        text += fmt::format("complete -c octant -n '__fish_seen_subcommand_from {}' -l {} -d {}\n", name,
                            long_name, in_shell_quotes(option->get_description()));
  }
  return text;
}

}  // namespace

void add_completion(CLI::App& app, CommonOptions& common, Action& action) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command =
      add_command(app, common, "completion", "Print the completion of commands and options for a shell",
                  "eval \"$(octant completion bash)\"");
  add_required_option(*command, "shell", *shell, "SHELL", "bash, zsh or fish")
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->callback([shell, &app, &action] {
    action = [shell, &app](Session& session) {
      const std::string text = *shell == "bash"  ? bash_completion(app)
                               : *shell == "zsh" ? zsh_completion(app)
                                                 : fish_completion(app);
      if (!session.options.json) return session.finish_document(text);
      return session.finish({{"shell", *shell}, {"completion", text}});
    };
  });
}

}  // namespace octant::app
