// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <exception>
#include <filesystem>
#include <new>
#include <string_view>
#include <system_error>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <fmt/format.h>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "apps/octant/commands.h"
#include "apps/octant/defaults.h"
#include "apps/octant/help/help.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/ranks.h"

namespace octant::app {
namespace {

/// Looks for --json even if other words are invalid, because a failure is then reported as JSON as well.
bool wants_json(int argc, const char* const* argv) {
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--") return false;
    if (std::string_view(argv[i]) == "--json") return true;
  }
  return false;
}

/// Help and version count as success; all other parse errors are exit 2, whatever CLI11 numbers them.
int end_of_parsing(const CLI::App& app, const CLI::ParseError& error, Session& session) {
  const auto chosen = app.get_subcommands();
  const CLI::App* innermost = &app;
  std::string name = "octant";
  for (auto inner = chosen; !inner.empty(); inner = innermost->get_subcommands()) {
    innermost = inner.back();
    name += " " + innermost->get_name();
  }
  const CLI::App& command = *innermost;
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    const bool version = error.get_name() == "CallForVersion";
    const std::string text = version ? version_text() + "\n" : help_of(command);
    session.result(text);
    return session.finish(version ? Json{{"program", "octant"},
                                         {"version", OCTANT_VERSION},
                                         {"commit", commit().empty() ? Json(nullptr) : Json(commit())}}
                                  : Json{{"help", text}});
  }
  std::string message = error.what();
  if (const auto* site = command.get_option_no_throw("site");
      site != nullptr && site->count() > 0 && message == "run is required" &&
      std::filesystem::is_directory(site->as<std::string>()))
    message = fmt::format(
        "{0} is a folder, so a recording, and the site file before it is missing (octant init {0} -o "
        "site.yaml begins one)",
        site->as<std::string>());
  // CLI11 prints the largest double as an upper bound.
  constexpr std::string_view kNotInRange = " not in range ";
  if (const auto at = message.find(kNotInRange);
      at != std::string::npos && message.find(" to 17976931348623157", at) != std::string::npos)
    message =
        message.substr(0, at) + (message.substr(0, at).ends_with(" 0") ? " is not above 0" : " is below 0");
  constexpr std::string_view kRequired = " is required";
  if (const auto at = message.rfind(kRequired);
      at != std::string::npos && at + kRequired.size() == message.size())
    if (const auto* word = command.get_option_no_throw(message.substr(0, at)); word && word->get_positional())
      message = fmt::format("{} is required ({})", word->get_type_name(), word->get_description());
  const auto strange = app.remaining(true);
  if (chosen.empty())
    message = strange.empty()
                  ? "a command is missing: octant demo shows a site from recording to report, octant init "
                    "RUN begins one of your own"
                  : fmt::format("unknown command '{}'{}", strange.front(),
                                did_you_mean(strange.front(), command_names(app)));
  else if (!strange.empty() && strange.front().starts_with("-"))
    message = fmt::format(
        "{} has no option '{}'{}", name, strange.front(),
        did_you_mean(strange.front().substr(0, strange.front().find('=')), option_names(command)));
  fail_usage(message, fmt::format("{} --help explains", name));
}

int run(int argc, const char* const* argv, Session& session) {
  // Ranks other than the first take part only in commands that share work.
  const std::string_view first_word = argc > 1 ? argv[1] : "";
  if (!session.job->is_first() && first_word != "calibrate" && first_word != "batch") return kDone;
  session.command_line = quote_command(argc, argv);
  session.options.json = wants_json(argc, argv);
  install_interrupt_handlers(session.options.json ? dump(interruption().object()) + "\n" : "");
  install_lost_input_handler(session.options.json ? dump(lost_input_object()) + "\n" : "");
  apply_defaults(session);

  CLI::App app(
      "Octant calibrates time-of-flight beacon positioning: beacons, delays and the speed of sound from a "
      "recording, and tells a robot where it is.",
      "octant");
  add_common_options(app, session.options);
  app.footer(
      "Example:\n  octant demo                    a simulated hall, from recording to report\n  octant "
      "init RUN -o "
      "site.yaml   a site file to fill in for your own\n  octant explain WORD            what a word or an "
      "exit code "
      "means\n\nExit codes: 0 done, 1 fault of the program, 2 wrong usage, 3 bad input,\n4 not converged, 5 "
      "undetermined, "
      "6 a quality gate failed or the data contradict\nthe site file, 130 interrupted.\n\nDefaults of "
      "threads, progress, quiet and verbose: "
      "~/.config/octant/defaults.yaml, or\nthe file that OCTANT_DEFAULTS names (octant schema defaults).");
  app.require_subcommand(1);
  Action action;
  add_demo(app, session.options, action);
  add_init(app, session.options, action);
  add_simulate(app, session.options, action);
  add_check(app, session.options, action);
  add_calibrate(app, session.options, action);
  add_batch(app, session.options, action);
  add_localize(app, session.options, action);
  add_verify(app, session.options, action);
  add_survey(app, session.options, action);
  add_adjust(app, session.options, action);
  add_convert(app, session.options, action);
  add_export(app, session.options, action);
  add_cockpit(app, session.options, action);
  add_plan(app, session.options, action);
  add_recalibrate(app, session.options, action);
  add_monitor(app, session.options, action);
  add_diff(app, session.options, action);
  add_report(app, session.options, action);
  add_history(app, session.options, action);
  add_sign(app, session.options, action);
  add_verify_signature(app, session.options, action);
  add_schema(app, session.options, action);
  add_explain(app, session.options, action);
  add_completion(app, session.options, action);
  add_help(app, session.options, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return end_of_parsing(app, error, session);
  }
  return action(session);
}

}  // namespace
}  // namespace octant::app

namespace {

int run_guarded(int argc, char** argv, octant::app::Session& session) {
  try {
    return octant::app::run(argc, argv, session);
  } catch (const octant::app::CommandFailed& ended) {
    return session.fail(ended.failure);
  } catch (const std::bad_alloc&) {
    return session.fail({"error", "internal", octant::app::kFault, "out of memory",
                         "use a machine with more, or fewer arrivals"});
  } catch (const std::system_error& error) {
    // If threads cannot be created, memory is exhausted; any other error is a bug.
    const bool out = error.code() == std::errc::resource_unavailable_try_again ||
                     error.code() == std::errc::not_enough_memory;
    return session.fail(
        {"error", "internal", octant::app::kFault,
         fmt::format("{}: {}", out ? "the system gives no more" : "a fault of octant", error.what()),
         out ? "raise the limits of memory and processes, or take --threads 1"
             : "please report it with the command"});
  } catch (const std::exception& error) {
    return session.fail({"error", "internal", octant::app::kFault,
                         fmt::format("a fault of octant: {}", error.what()),
                         "please report it with the command"});
  }
}

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Lists of millions of rows are allocated and freed repeatedly. Memory returned to the system must be
  // zeroed before its next use, which costs more than filling it on a virtual machine.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
  octant::app::Job job(&argc, &argv);
  octant::app::Session session;
  session.job = &job;
  return job.finish(run_guarded(argc, argv, session));
}
