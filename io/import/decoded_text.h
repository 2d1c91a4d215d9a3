// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: text files of other programs, in the encodings and compressions that people use.

#include <string>
#include <string_view>
#include <vector>

#include "io/text/open_file.h"

namespace octant::io {

/// Text of a file as UTF-8, without a byte-order mark: gzip and Zstandard are decompressed, UTF-16 (with or
/// without a byte-order mark) and Latin-1 are converted. Lines are checked as by check_lines().
class DecodedText {
 public:
  /// Errors: those of read_file() and check_lines(); kBadInput: a damaged archive, an archive of files
  /// (.zip, .xlsx), more than kLargestDecoded bytes of text.
  [[nodiscard]] static Result<DecodedText> open(const std::string& path);

  [[nodiscard]] std::string_view text() const;
  /// One sentence for each conversion.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

  static constexpr std::size_t kLargestDecoded = std::size_t{1} << 31;  ///< bytes

 private:
  explicit DecodedText(MappedFile map) : map_(std::move(map)) {}

  MappedFile map_;
  bool is_converted_ = false;
  std::string converted_;
  std::vector<std::string> notes_;
};

}  // namespace octant::io
