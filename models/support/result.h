// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace octant {

/// What kind of failure an Error is. The command line maps it to its exit code.
enum class Errc {
  kUsage,       ///< wrong usage of a command (exit 2)
  kBadInput,    ///< a file or value that does not follow its format (exit 3)
  kOutput,      ///< an output could not be written (exit 3)
  kNotHeard,    ///< a signal too weak for the threshold
  kNoMemory,    ///< the machine has no memory for it (exit 1)
  kInterrupted  ///< the user asked to stop (exit 130)
};

/// A failure of the outside world: where, what was found, what was expected, what to do.
struct Error {
  Errc code = Errc::kBadInput;
  std::string file{};      ///< path as the user wrote it; empty where there is no file
  int line = 0;            ///< 1-based; 0: the file as a whole
  int column = 0;          ///< 1-based; 0: the line as a whole
  std::string found{};     ///< what is wrong, e.g. "beacon 'B99' is not in the site file"
  std::string expected{};  ///< what would be right; may be empty
  std::string advice{};    ///< what to do; may be empty

  /// "tof.csv:41:7: found ...; expected ...; ..." in one line.
  [[nodiscard]] std::string message() const;
};

template <class T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

/// What does not follow its format or does not fit, without a file.
[[nodiscard]] inline tl::unexpected<Error> bad_input(std::string found, std::string expected) {
  return fail({.code = Errc::kBadInput, .found = std::move(found), .expected = std::move(expected)});
}

}  // namespace octant
