// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/text/json_values.h"
#include "models/support/result.h"

namespace octant::app {

class Job;

using Json = nlohmann::ordered_json;

/// Exit codes as documented in the guide.
enum Exit : int {
  kDone = 0,
  kFault = 1,
  kUsage = 2,
  kBadInput = 3,
  kNotConverged = 4,
  kUndetermined = 5,
  kGateFailed = 6,
  kInterrupted = 130
};

/// Options that all commands have in common.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  int verbose = 0;
  std::string progress = "auto";
  int threads = 0;  ///< 0: number of cores
  std::uint64_t seed = 1;
};

/// A failure as reported to people and machines.
struct Failure {
  std::string status;  ///< key `status` of the JSON object: "error", "undetermined", ...
  std::string code;    ///< key `code` of its error: "bad_input", ...
  Exit exit = kFault;
  std::string message;
  std::string advice;
  Error where{};  ///< underlying error of the outside world, if there is one
  /// JSON object with the keys `status` and `error`.
  [[nodiscard]] Json object() const;
  /// Text for people.
  [[nodiscard]] std::string words() const;
};
[[nodiscard]] Failure failure_of(const Error& error);
/// Failure that represents an interruption. Also the final message of a program that a signal terminates at
/// once.
[[nodiscard]] Failure interruption();

/// Exception that ends a command: thrown by the step that fails, and caught only where commands are called.
struct CommandFailed : std::exception {
  explicit CommandFailed(Failure of) : failure(std::move(of)) {}
  [[nodiscard]] const char* what() const noexcept override { return failure.message.c_str(); }
  Failure failure;
};

/// Ends a command with an error of the outside world.
[[noreturn]] void fail_with(const Error& error);
/// Value of a result; if it is an error, ends the command.
/// @param file  file to report for errors that name none
template <class T>
T need(Result<T> result, const std::string& file = "") {
  if (!result && result.error().file.empty()) result.error().file = file;
  if (!result) fail_with(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}
/// Ends the command because of invalid usage (exit 2).
[[noreturn]] void fail_usage(const std::string& message, const std::string& advice = "");
/// Ends the command if the user requested it, by a signal or through the progress callback.
void stop_if_interrupted(bool stopped = false);

/// One invocation of the program: its options, and the only access to standard output and standard error.
/// With --json exactly one object is written to standard output, at the end; otherwise standard output has
/// text for people. Messages go to standard error.
class Session {
 public:
  CommonOptions options;
  const Job* job = nullptr;  ///< processes that share the work; null: this one alone
  std::string command_line;  ///< as typed, with quotes where needed
  Json* object = nullptr;    ///< receives the final object instead of standard output; null: standard output

  /// Writes a result to standard output, or to standard error if standard output carries a file (`-o -`). No
  /// output with --json.
  void result(std::string_view text);
  void result_to_stderr() { results_ = stderr; }
  /// Writes a note, unless --quiet is given.
  void note(std::string_view text);
  /// Writes a note if --verbose is given.
  void detail(std::string_view text);
  /// Keeps warnings for the JSON object and writes the first fifty different ones to standard error.
  void warn(const std::vector<std::string>& warnings);
  /// Creates a silent session with the same options that collects its own warnings, for one of several
  /// concurrent tasks.
  [[nodiscard]] Session part(int threads) const;
  void warn(const std::string& warning) { warn(std::vector<std::string>{warning}); }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

  /// Ends with a document on standard output, which is the result with and without --json.
  [[nodiscard]] int finish_document(std::string_view text);
  /// Ends with success and prints the result. `status` and `warnings` are added unless present.
  [[nodiscard]] int finish(const Json& result);
  /// Ends with a failure; the keys of `result` are kept next to `status` and `error`.
  [[nodiscard]] int fail(const Failure& failure, Json result = Json::object());

  /// Number of threads to use.
  [[nodiscard]] int threads() const;
  /// Time since the start of the program.
  [[nodiscard]] double seconds() const;

 private:
  void complain(const std::string& message);
  int print(const Json& whole, Exit exit);
  int flush(Exit exit);

  std::FILE* results_ = stdout;
  bool silent_ = false;
  std::vector<std::string> warnings_;
  std::size_t warning_lines_ = 0, warning_bytes_ = 0;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

/// Final message of a program whose input was truncated while being read.
[[nodiscard]] Json lost_input_object();
/// One line of JSON. Invalid UTF-8 is replaced, and numbers that are not finite become null.
[[nodiscard]] std::string dump(const Json& object);
/// Quotes a word for a shell if necessary.
[[nodiscard]] std::string quote_word(const std::string& word);
/// Joins words into a command line for a shell.
[[nodiscard]] std::string quote_command(int argc, const char* const* argv);
/// Current time or SOURCE_DATE_EPOCH, as ISO 8601 in UTC.
[[nodiscard]] std::string created_now();
}  // namespace octant::app
