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

/// Exit codes of the contract.
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

/// Options that every command has.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  int verbose = 0;
  std::string progress = "auto";
  int threads = 0;  ///< 0: as many as there are cores
  std::uint64_t seed = 1;
};

/// What went wrong, for people and for machines.
struct Failure {
  std::string status;  ///< of the JSON object: "error", "undetermined", ...
  std::string code;    ///< of its error: "bad_input", ...
  Exit exit = kFault;
  std::string message;
  std::string advice;
  Error where{};  ///< the error of the outside world that it comes from, if it is one
  /// The object's keys `status` and `error`.
  [[nodiscard]] Json object() const;
  /// What people read.
  [[nodiscard]] std::string words() const;
};
[[nodiscard]] Failure failure_of(const Error& error);
/// The failure that stands for an interruption; also the last words of a program that a signal ends at once.
[[nodiscard]] Failure interruption();

/// Ends a command: thrown by the step that fails, caught where commands are called and nowhere between.
struct CommandFailed : std::exception {
  explicit CommandFailed(Failure of) : failure(std::move(of)) {}
  [[nodiscard]] const char* what() const noexcept override { return failure.message.c_str(); }
  Failure failure;
};

/// Ends a command by an error of the outside world.
[[noreturn]] void fail_with(const Error& error);
/// The value of a result without which a command cannot go on: an error ends it.
/// @param file  that an error is about which names none
template <class T>
T need(Result<T> result, const std::string& file = "") {
  if (!result && result.error().file.empty()) result.error().file = file;
  if (!result) fail_with(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}
/// Ends the command of what was typed wrongly (exit 2).
[[noreturn]] void fail_usage(const std::string& message, const std::string& advice = "");
/// Ends the command of a user who asked to stop, by a signal or through the progress of a computation.
void stop_if_interrupted(bool stopped = false);

/// One invocation of the program: its options, and the only way to standard output and standard error.
/// With --json exactly one object goes to standard output, at the end; otherwise text for people goes there.
/// Talk goes to standard error.
class Session {
 public:
  CommonOptions options;
  const Job* job = nullptr;  ///< whom the work is shared with; null: nobody
  std::string command_line;  ///< as typed, quoted where needed
  Json* object = nullptr;    ///< takes the object of the end instead of standard output; null: nobody does

  /// Text of a result: standard output, or standard error where standard output carries a file (`-o -`); none
  /// with --json.
  void result(std::string_view text);
  void result_to_stderr() { results_ = stderr; }
  /// Talk, unless --quiet.
  void note(std::string_view text);
  /// Talk with --verbose.
  void detail(std::string_view text);
  /// Warnings are kept for the JSON object and go to standard error, each once, the first fifty of them.
  void warn(const std::vector<std::string>& warnings);
  /// A session of the same options and words that keeps its warnings and says nothing: for one of several
  /// things done at once.
  [[nodiscard]] Session part(int threads) const;
  void warn(const std::string& warning) { warn(std::vector<std::string>{warning}); }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

  /// Ends with a document on standard output that is a result as it stands, --json or not.
  [[nodiscard]] int finish_document(std::string_view text);
  /// Ends with success: prints the result, which gets `status` and `warnings` where it has none.
  [[nodiscard]] int finish(const Json& result);
  /// Ends with a failure; keys of `result` are kept beside `status` and `error`.
  [[nodiscard]] int fail(const Failure& failure, Json result = Json::object());

  /// Threads to use.
  [[nodiscard]] int threads() const;
  /// Since the start of the program.
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

/// The last words of a program whose input was cut off while it was read.
[[nodiscard]] Json lost_input_object();
/// One line, with bytes that are not UTF-8 replaced and numbers that are not finite as null.
[[nodiscard]] std::string dump(const Json& object);
/// A word as a shell would need it typed: in quotes where it has blanks or the like.
[[nodiscard]] std::string quote_word(const std::string& word);
/// Joins words as a shell would need them typed.
[[nodiscard]] std::string quote_command(int argc, const char* const* argv);
/// Now, or SOURCE_DATE_EPOCH, as ISO 8601 in UTC.
[[nodiscard]] std::string created_now();
}  // namespace octant::app
