// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <CLI/App.hpp>

namespace octant::app {

class Session;

/// Function that main() calls after parsing; set by the command that was chosen.
using Action = std::function<int(Session&)>;

/// Group of the options that all commands have, in help and man pages.
inline constexpr std::string_view kCommonGroup = "Common options";

/// Adds an option ("-o,--output") or, for a name without dashes, a positional argument. The current value is
/// the default; --help shows it unless it is empty or zero. @param type  placeholder of the value in --help
template <class T>
CLI::Option* add_option(CLI::App& command, const std::string& name, T& value, const std::string& type,
                        const std::string& help) {
  CLI::Option* option = command.add_option(name, value, help)->type_name(type);
  if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>)
    if (value != T{}) option->capture_default_str();
  // The ranges of CLI11 accept NaN.
  if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>)
    option->check([](const std::string& text) {
      double number = 0.0;
      const bool finite = !CLI::detail::lexical_cast(text, number) || std::isfinite(number);
      return finite ? std::string() : "Value " + text + " is no finite number";
    });
  return option;
}

template <class T>
CLI::Option* add_required_option(CLI::App& command, const std::string& name, T& value,
                                 const std::string& type, const std::string& help) {
  return add_option(command, name, value, type, help)->required();
}

/// During its lifetime new options appear under a separate heading in --help.
class OptionGroup {
 public:
  OptionGroup(CLI::App& command, const std::string& heading)
      : defaults_(*command.option_defaults()), before_(defaults_.get_group()) {
    defaults_.group(heading);
  }
  ~OptionGroup() { defaults_.group(before_); }
  OptionGroup(const OptionGroup&) = delete;
  OptionGroup& operator=(const OptionGroup&) = delete;

 private:
  CLI::OptionDefaults& defaults_;
  std::string before_;
};

/// Makes main() call `run` with the arguments if the command line names this command.
template <class Args>
void set_action(CLI::App& command, std::shared_ptr<Args> args, Action& action,
                std::type_identity_t<int (*)(const Args&, Session&)> run) {
  command.callback([args = std::move(args), &action, run] {
    action = [args, run](Session& session) { return run(*args, session); };
  });
}

}  // namespace octant::app
