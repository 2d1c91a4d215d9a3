// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/session.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <thread>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include "apps/octant/interrupt.h"

namespace octant::app {
namespace {

constexpr std::size_t kMaxWarningLines = 50, kMaxWarningBytes = 12'000;

/// Colour on terminals, unless disabled (https://no-color.org).
std::string painted(const char* colour, std::string_view text) {
  const char* no_color = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  const bool plain = (no_color != nullptr && *no_color != '\0') || term == nullptr ||
                     std::string_view(term) == "dumb" || isatty(STDERR_FILENO) != 1;
  return plain ? std::string(text) : fmt::format("\033[{}m{}\033[0m", colour, text);
}

/// Unlike fmt::print this does not throw if the disk is full or the reader is gone; print() checks the stream
/// at the end.
void put(std::FILE* stream, std::string_view text) { (void)std::fwrite(text.data(), 1, text.size(), stream); }

Json error_object(const std::string& code, int exit, const std::string& message, const Error& error) {
  const auto number = [](int n) { return n > 0 ? Json(n) : Json(nullptr); };
  const auto text = [](const std::string& s) { return s.empty() ? Json(nullptr) : Json(s); };
  return {{"code", code},
          {"exit", exit},
          {"message", message},
          {"file", text(error.file)},
          {"line", number(error.line)},
          {"column", number(error.column)},
          {"found", text(error.found)},
          {"expected", text(error.expected)},
          {"advice", text(error.advice)}};
}

}  // namespace

Json Failure::object() const {
  Error error = where;
  if (error.found.empty()) error.advice = advice;
  return {{"status", status}, {"error", error_object(code, exit, message, error)}};
}

std::string Failure::words() const {
  return where.found.empty() && !advice.empty() ? message + "; " + advice : message;
}

Failure failure_of(const Error& error) {
  const auto failure = [&error](const char* code, Exit exit) {
    return Failure{"error", code, exit, error.message(), "", error};
  };
  switch (error.code) {
    case Errc::kUsage: return failure("usage", kUsage);
    case Errc::kBadInput: return failure("bad_input", kBadInput);
    case Errc::kOutput: return failure("output", kBadInput);
    case Errc::kInterrupted: return interruption();
    default: return failure("internal", kFault);
  }
}

Failure interruption() {
  return {"interrupted", "interrupted", kInterrupted, "interrupted, nothing was written", ""};
}

void fail_with(const Error& error) { throw CommandFailed(failure_of(error)); }

void fail_usage(const std::string& message, const std::string& advice) {
  throw CommandFailed({"error", "usage", kUsage, message, advice});
}

void stop_if_interrupted(bool stopped) {
  if (stopped || interrupted()) throw CommandFailed(interruption());
}

std::string dump(const Json& object) { return object.dump(-1, ' ', false, Json::error_handler_t::replace); }

void Session::result(std::string_view text) {
  if (!options.json && !silent_) put(results_, text);
}

void Session::note(std::string_view text) {
  if (!options.quiet) put(stderr, fmt::format("{}\n", text));
}

void Session::detail(std::string_view text) {
  if (options.verbose > 0) put(stderr, fmt::format("{}\n", text));
}

void Session::warn(const std::vector<std::string>& warnings) {
  for (const auto& warning : warnings) {
    if (std::ranges::find(warnings_, warning) != warnings_.end()) continue;
    warnings_.push_back(warning);
    if (silent_ || warning_lines_ >= kMaxWarningLines || warning_bytes_ >= kMaxWarningBytes) continue;
    ++warning_lines_;
    warning_bytes_ += warning.size();
    put(stderr, fmt::format("{} {}\n", painted("1;33", "warning:"), warning));
  }
}

void Session::complain(const std::string& message) {
  if (silent_) return;
  put(stderr, fmt::format("{} {}\n", painted("1;31", "error:"), message));
}

int Session::flush(Exit exit) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit;
  complain("standard output could not be written");
  return exit == kDone ? kBadInput : exit;
}

int Session::print(const Json& whole, Exit exit) {
  if (object != nullptr) {
    *object = whole;
    return exit;
  }
  if (warnings_.size() > warning_lines_) {
    put(stderr, fmt::format("{} {} more; --json lists them all\n", painted("1;33", "warning:"),
                            warnings_.size() - warning_lines_));
    warning_lines_ = warnings_.size();
  }
  if (options.json) put(stdout, dump(whole) + "\n");
  return flush(exit);
}

int Session::finish_document(std::string_view text) {
  put(stdout, text);
  return flush(kDone);
}

int Session::finish(const Json& result) {
  Json whole = {{"status", "ok"}};
  whole.update(result);
  if (!whole.contains("warnings")) whole["warnings"] = warnings_;
  return print(whole, kDone);
}

int Session::fail(const Failure& failure, Json result) {
  complain(failure.words());
  Json whole = failure.object();
  // An interrupted command prints the same object as the signal handler, which has no warnings.
  if (failure.exit == kInterrupted && result.empty()) return print(whole, kInterrupted);
  result.erase("status");
  whole.update(result);
  if (!whole.contains("warnings")) whole["warnings"] = warnings_;
  return print(whole, failure.exit);
}

Session Session::part(int threads) const {
  Session part;
  part.options = options;
  part.options.threads = threads;
  part.options.quiet = true;
  part.options.verbose = 0;
  part.options.progress = "none";
  part.command_line = command_line;
  part.silent_ = true;
  return part;
}

int Session::threads() const {
  return options.threads > 0 ? options.threads
                             : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

double Session::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

Json lost_input_object() {
  return {{"status", "error"}, {"error", error_object("bad_input", kBadInput, kLostInput, {})}};
}

std::string quote_word(const std::string& word) {
  if (!word.empty() && word.find_first_of(" \t\n'\"\\$`*?[]{}()<>|&;~#!") == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string quote_command(int argc, const char* const* argv) {
  std::string line = "octant";
  for (int i = 1; i < argc; ++i) line += " " + quote_word(argv[i]);
  return line;
}

std::string created_now() {
  std::time_t now = std::time(nullptr);
  // Reproducible documents: https://reproducible-builds.org/specs/source-date-epoch
  if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) {
    char* end = nullptr;
    const long long seconds = std::strtoll(epoch, &end, 10);
    if (end != epoch && *end == '\0' && seconds >= 0 && seconds < 253402300800LL)
      now = static_cast<std::time_t>(seconds);
  }
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

}  // namespace octant::app
