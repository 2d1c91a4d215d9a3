// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace octant {

/// Category of an Error. The command line maps it to the exit code.
enum class Errc {
  kUsage,       ///< invalid usage of a command (exit 2)
  kBadInput,    ///< invalid format of a file or value (exit 3)
  kOutput,      ///< an output could not be written (exit 3)
  kNotHeard,    ///< a signal too weak for the threshold
  kNoMemory,    ///< out of memory (exit 1)
  kInterrupted  ///< the user asked to stop (exit 130)
};

/// A failure of the outside world: where, what was found, what was expected, what to do.
struct Error {
  Errc code = Errc::kBadInput;
  std::string file{};      ///< path as the user wrote it; empty if there is no file
  int line = 0;            ///< 1-based; 0: the whole file
  int column = 0;          ///< 1-based; 0: the whole line
  std::string found{};     ///< description of the problem, e.g. "beacon 'B99' is not in the site file"
  std::string expected{};  ///< valid input; may be empty
  std::string advice{};    ///< recommended action; may be empty

  /// One line of text: "tof.csv:41:7: found ...; expected ...; ..."
  [[nodiscard]] std::string message() const;
};

template <class T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

/// Error for a value that violates its format or does not fit, without a file.
[[nodiscard]] inline tl::unexpected<Error> bad_input(std::string found, std::string expected) {
  return fail({.code = Errc::kBadInput, .found = std::move(found), .expected = std::move(expected)});
}

}  // namespace octant
