// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace octant::app {

/// Takes over SIGINT and SIGTERM. A first signal asks politely (interrupted() becomes true); a second one
/// kills. A SIGINT that the parent ignores (background jobs) stays ignored.
/// @param last_words  what goes to standard output where a signal ends the program at once; may be empty
void install_interrupt_handlers(const std::string& last_words);

[[nodiscard]] bool interrupted();

/// While one lives within another program, its SIGINT asks politely too, and then goes where it went before.
/// They may be nested and live on several threads; after the last one it is as before, and forgotten.
class PoliteInterrupts {
 public:
  PoliteInterrupts();
  ~PoliteInterrupts();
  PoliteInterrupts(const PoliteInterrupts&) = delete;
  PoliteInterrupts& operator=(const PoliteInterrupts&) = delete;
};

/// A recording is read where it lies on the disk: one that somebody cuts off meanwhile ends the program with
/// SIGBUS. It then ends with exit 3 and says so.
/// @param last_words  as above
void install_lost_input_handler(const std::string& last_words);
inline constexpr const char* kLostInput =
    "an input has become shorter, or could not be read any more, while it was read; nothing is made of it";

/// While one lives, nothing of ours is half on disk, and a signal may end the program at once with exit 130:
/// for long computations that cannot be asked to stop. They may be nested.
class ExitAtOnce {
 public:
  ExitAtOnce();
  ~ExitAtOnce();
  ExitAtOnce(const ExitAtOnce&) = delete;
  ExitAtOnce& operator=(const ExitAtOnce&) = delete;
};

/// While one lives, a signal ends nothing at once, whatever ExitAtOnce says: another thread may be writing.
class NoExitAtOnce {
 public:
  NoExitAtOnce();
  ~NoExitAtOnce();
  NoExitAtOnce(const NoExitAtOnce&) = delete;
  NoExitAtOnce& operator=(const NoExitAtOnce&) = delete;
};

}  // namespace octant::app
