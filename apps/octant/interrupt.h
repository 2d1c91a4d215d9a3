// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace octant::app {

/// Installs handlers for SIGINT and SIGTERM. The first signal requests an orderly end (interrupted() becomes
/// true), the second one terminates the program. If the parent process ignores SIGINT (background jobs), it
/// remains ignored.
/// @param last_words  text for standard output if a signal terminates the program at once; may be empty
void install_interrupt_handlers(const std::string& last_words);

[[nodiscard]] bool interrupted();

/// For use inside another program: during its lifetime SIGINT first requests an orderly end, and is then
/// passed on to the previous handler. Objects may be nested and exist on several threads. When the last one
/// is destroyed, the previous handler is restored and the request is cleared.
class PoliteInterrupts {
 public:
  PoliteInterrupts();
  ~PoliteInterrupts();
  PoliteInterrupts(const PoliteInterrupts&) = delete;
  PoliteInterrupts& operator=(const PoliteInterrupts&) = delete;
};

/// Recordings are read through memory maps, so a file that is truncated meanwhile causes SIGBUS. This handler
/// then ends the program with exit 3 and a message.
/// @param last_words  as above
void install_lost_input_handler(const std::string& last_words);
inline constexpr const char* kLostInput =
    "an input has become shorter, or could not be read any more, while it was read; nothing is made of it";

/// During its lifetime no output is partially written, so a signal may terminate the program at once with
/// exit 130. For long computations that cannot be interrupted otherwise. Objects may be nested.
class ExitAtOnce {
 public:
  ExitAtOnce();
  ~ExitAtOnce();
  ExitAtOnce(const ExitAtOnce&) = delete;
  ExitAtOnce& operator=(const ExitAtOnce&) = delete;
};

/// During its lifetime no signal terminates the program at once, in spite of ExitAtOnce, because another
/// thread may be writing.
class NoExitAtOnce {
 public:
  NoExitAtOnce();
  ~NoExitAtOnce();
  NoExitAtOnce(const NoExitAtOnce&) = delete;
  NoExitAtOnce& operator=(const NoExitAtOnce&) = delete;
};

}  // namespace octant::app
