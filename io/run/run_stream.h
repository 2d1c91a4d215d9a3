// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "io/run/run_folder.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

class RunReader;
struct TofPosition;

/// A run folder whose arrivals are too many to be held at once. They come in blocks, in the order of the
/// file, with the same checks as read_run() makes; all else is read when it is opened. Memory: a block, a few
/// pieces of a quarter of a megabyte a thread, and the rows that are no measurement
/// (MeasurementLog::rejected).
///   auto stream = RunStream::open(folder, names, site.timing, {.threads = 2});
///   std::vector<Arrival> block;
///   for (;;) {
///     const auto more = stream->next(block);
///     if (!more) return fail(more.error());
///     if (!*more) break;
///     ...
///   }
///   ... stream->log() ...
class RunStream {
 public:
  /// @param names       must outlive the stream
  /// @param block_rows  largest number of arrivals in a block
  /// Errors: those of read_run() but for the rows of tof.csv.
  [[nodiscard]] static Result<RunStream> open(const std::string& folder, const NameTable& names,
                                              const Timing& timing, const ReadRunOptions& options = {},
                                              std::size_t block_rows = std::size_t{1} << 16);
  RunStream(RunStream&&) noexcept;
  RunStream& operator=(RunStream&&) noexcept;
  ~RunStream();

  /// Puts the next arrivals in place of what `block` held: block_rows of them, fewer in the last block. False
  /// at the end. Errors: those of the rows; after one there is no more to come.
  [[nodiscard]] Result<bool> next(std::vector<Arrival>& block);

  /// Instead of next(): blocks as they come, each some thousands of rows, so that any of them can be read
  /// again. There may be none in a block.
  [[nodiscard]] Result<bool> next_piece(std::vector<Arrival>& block);
  /// How many blocks next_piece() has given.
  [[nodiscard]] std::size_t pieces() const;
  /// Puts the arrivals of blocks [first, last) that next_piece() has given, once more, behind what `arrivals`
  /// holds. Several threads may do so.
  [[nodiscard]] Result<void> read_pieces(std::size_t first, std::size_t last,
                                         std::vector<Arrival>& arrivals) const;

  /// A guess at how many rows tof.csv has, rather too many; before the first block.
  [[nodiscard]] std::size_t rows_estimate() const;

  /// The run without its arrivals. `rows`, `rejected`, the warnings and the digest of tof.csv are complete
  /// once next() has returned false, and `vehicle` as well where only the rows name it.
  [[nodiscard]] const MeasurementLog& log() const;

 private:
  RunStream(std::unique_ptr<RunReader> reader, std::size_t block_rows);

  std::unique_ptr<RunReader> reader_;
  std::size_t block_rows_;
  std::vector<Arrival> held_;  // read, not yet given out from taken_ on
  std::size_t taken_ = 0;
  std::vector<TofPosition> begins_;  // of the pieces given
  bool ended_ = false;
};

}  // namespace octant::io
