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

/// Reads a run folder whose arrivals do not fit into memory. They are returned in blocks of some thousands,
/// in the order of the file, with the same checks as in read_run(); the other files are read at the
/// beginning. Memory: a block, eight pieces of a quarter of a megabyte for each thread, and the rows that are
/// no measurement (MeasurementLog::rejected).
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
  /// Errors: those of read_run() but for the rows of tof.csv.
  [[nodiscard]] static Result<RunStream> open(const std::string& folder, const NameTable& names,
                                              const Timing& timing, const ReadRunOptions& options = {});
  RunStream(RunStream&&) noexcept;
  RunStream& operator=(RunStream&&) noexcept;
  ~RunStream();

  /// Replaces the content of `block` by the next arrivals; the block may be empty. False at the end. Errors:
  /// those of the rows; after an error the stream has ended.
  [[nodiscard]] Result<bool> next(std::vector<Arrival>& block);
  /// Number of blocks that next() has returned.
  [[nodiscard]] std::size_t blocks() const;
  /// Appends the arrivals of blocks [first, last) that next() has returned to `arrivals`. Several threads may
  /// call it.
  [[nodiscard]] Result<void> read_blocks(std::size_t first, std::size_t last,
                                         std::vector<Arrival>& arrivals) const;

  /// A guess at how many rows tof.csv has, rather too many; before the first block.
  [[nodiscard]] std::size_t rows_estimate() const;

  /// The run without its arrivals. `rows`, `rejected`, the warnings and the digest of tof.csv are complete
  /// once next() has returned false, and `vehicle` as well where only the rows name it.
  [[nodiscard]] const MeasurementLog& log() const;

 private:
  explicit RunStream(std::unique_ptr<RunReader> reader);

  std::unique_ptr<RunReader> reader_;
  std::vector<TofPosition> begins_;  // of the blocks given
  bool ended_ = false;
};

}  // namespace octant::io
