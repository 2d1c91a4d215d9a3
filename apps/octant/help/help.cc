// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/help/help.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "apps/octant/text/layout.h"
#include "io/text/text.h"

namespace octant::app {
namespace {

constexpr std::size_t kNames = 28;  // columns for the names of options

/// Formats CLI11's help within 80 columns, with a command's own options first.
class HelpFormat : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    return make_description(app) + make_usage(app, std::move(name)) + make_positionals(app) +
           make_subcommands(app, mode) + groups_of(app) + "\n" + make_footer(app);
  }
  [[nodiscard]] std::string groups_of(const CLI::App* app) const {
    std::vector<std::string> groups = app->get_groups();
    std::stable_partition(groups.begin(), groups.end(),
                          [](const std::string& g) { return g != kCommonGroup; });
    std::string text;
    for (const std::string& group : groups) {
      const auto options = app->get_options(
          [&](const CLI::Option* option) { return option->get_group() == group && option->nonpositional(); });
      if (group.empty() || options.empty()) continue;
      text += "\n" + paragraph(group + ":");
      for (const CLI::Option* option : options) text += make_option(option, false);
    }
    return text;
  }
  std::string make_option(const CLI::Option* option, bool positional) const override {
    // Name of the type only. CLI11 appends technical details (INT in [0 - 1024], {a,b,c}).
    const std::string type = option->get_type_name();
    const std::size_t colon = type.find(':');
    std::string name = make_option_name(option, positional);
    if (option->get_type_size() != 0 && !type.empty()) name += " " + type.substr(0, colon);
    if (option->get_expected_max() > 1 && positional) name += " ...";
    std::string what = option->get_description();
    if (colon != std::string::npos && type[colon + 1] == '{')
      what += choices_untold(type.substr(colon + 2), what);
    if (option->get_required() && !positional) what += " (required)";
    if (option->get_type_size() != 0 && !option->get_default_str().empty())
      what += " [" + option->get_default_str() + "]";
    return row(name, what);
  }
  std::string make_subcommand(const CLI::App* command) const override {
    return row(command->get_display_name(true), command->get_description());
  }
  /// Examples: long lines are continued with a backslash, as in a shell.
  std::string make_footer(const CLI::App* app) const override {
    std::string text;
    std::istringstream lines(app->get_footer());
    for (std::string line; std::getline(lines, line);) {
      if (columns_of(line) <= kTextColumns) {
        text += line + "\n";
        continue;
      }
      if (!line.starts_with("  ")) {  // text, not a command
        text += paragraph(line);
        continue;
      }
      if (const std::size_t comment = line.find("  ", 2); comment != std::string::npos) {
        text += line.substr(0, comment) + "\n      ";
        line = line.substr(line.find_first_not_of(' ', comment));
      } else {
        const std::size_t stop = line.rfind(' ', kTextColumns - 2);
        text += line.substr(0, stop) + " \\\n      ";
        line = line.substr(stop + 1);
      }
      text += line + "\n";
    }
    return text;
  }
  std::string make_description(const CLI::App* app) const override {
    return paragraph(app->get_description()) + "\n";
  }

 private:
  /// Choices of an option, "a,b,c}", unless its description names them.
  static std::string choices_untold(std::string choices, const std::string& what) {
    choices.resize(std::min(choices.find('}'), choices.size()));
    if (what.find(choices.substr(0, choices.find(','))) != std::string::npos) return "";
    std::string text = ": ";
    for (const char c : choices) text += c == ',' ? std::string(", ") : std::string(1, c);
    return text;
  }

  static std::string row(const std::string& name, const std::string& what) {
    const std::string indent(kNames, ' ');
    std::string text = "  " + name;
    text += text.size() < kNames ? std::string(kNames - text.size(), ' ') : "\n" + indent;
    return text + paragraph(what, kTextColumns, kNames, kNames);
  }
};

}  // namespace

std::string help_of(const CLI::App& command) {
  std::string parents;
  for (const CLI::App* a = command.get_parent(); a != nullptr; a = a->get_parent())
    parents = a->get_name() + (parents.empty() ? "" : " " + parents);
  auto format = std::make_shared<HelpFormat>();
  return format->make_help(&command,
                           parents.empty() ? command.get_name() : parents + " " + command.get_name(),
                           CLI::AppFormatMode::Normal);
}

const CLI::App* command_of(const CLI::App& program, const std::vector<std::string>& words) {
  const CLI::App* command = &program;
  for (const std::string& word : words) {
    const auto below = command->get_subcommands([&](const CLI::App* a) { return a->get_name() == word; });
    if (below.empty()) return nullptr;
    command = below.front();
  }
  return command;
}

std::vector<std::string> command_names(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_name().empty()) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const std::string hint = io::suggestion(word, known);
  return hint.starts_with("did") ? "; " + hint : "";
}

std::string version_text() {
  return commit().empty() ? "octant " OCTANT_VERSION
                          : fmt::format("octant " OCTANT_VERSION " ({})", commit());
}

void add_help(CLI::App& app, CommonOptions& common, Action& action) {
  struct HelpArgs {
    std::vector<std::string> command;
    bool man = false;
  };
  auto args = std::make_shared<HelpArgs>();
  CLI::App* command = add_command(app, common, "help", "Explain a command", "octant help calibrate");
  add_option(*command, "command", args->command, "COMMAND", "Command, as in: history trend; left out: all");
  command->add_flag("--man", args->man, "Instead: all of it as a page for man");
  command->callback([args, &app, &action] {
    action = [args, &app](Session& session) {
      if (args->man) {
        if (!session.options.json) return session.finish_document(man_page(app));
        return session.finish({{"man", man_page(app)}});
      }
      const CLI::App* asked = command_of(app, args->command);
      if (asked == nullptr)
        fail_usage(fmt::format("unknown command '{}'{}", args->command.front(),
                               did_you_mean(args->command.front(), command_names(app))),
                   "octant help lists them all");
      const std::string text = help_of(*asked);
      session.result(text);
      return session.finish({{"help", text}});
    };
  });
}

}  // namespace octant::app
