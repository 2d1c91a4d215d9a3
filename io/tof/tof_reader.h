// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: tof.csv as a sequence of blocks of arrivals.

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/text/open_file.h"
#include "io/text/sha256.h"
#include "io/tof/repeated_rows.h"
#include "io/tof/tof_chunk.h"
#include "io/tof/tof_rows.h"

namespace octant::io {

/// Where a row begins, and the times of the rows before it.
struct TofPosition {
  std::size_t offset = 0;
  int line = 1;
  OrderWatch::Times times = {};
};

struct TofReaderOptions {
  int threads = 1;
  std::size_t chunk_bytes =
      std::size_t{1}
      << 17;  ///< size of a piece, which fits into the cache of a thread together with its rows
  bool general_way = false;  ///< read row by row from the beginning; the reference of the other methods
  /// Reads only the rows from this position of a file that has been read before; text and digest are not
  /// checked again.
  std::optional<TofPosition> from = {};
  /// Reads the rows up to an offset at which a row begins (or the end); the digest is that of the whole file.
  std::size_t to = std::string_view::npos;
  DistanceAsTime distance = {};
};

/// Reads tof.csv in pieces. Several TofChunkParser parse pieces on several threads, and this class checks in
/// the order of the file what concerns more than a piece: time, epochs, lines, refusals, the digest. From the
/// first piece that the parser cannot read, read_tof_row() reads row by row. The result does not depend on
/// the number of threads or pieces.
class TofReader {
 public:
  /// @param file   as messages name it
  /// @param names  must outlive the reader
  TofReader(std::shared_ptr<const MappedFile> map, std::string file, const NameLookup& names, Clock clock,
            TofReaderOptions options = {});
  TofReader(const TofReader&) = delete;
  TofReader& operator=(const TofReader&) = delete;

  /// Must be called first. Errors: those of the header.
  [[nodiscard]] Result<void> read_header();
  [[nodiscard]] bool has_epochs() const { return columns_->epoch >= 0; }
  /// Upper estimate of the number of rows.
  [[nodiscard]] std::size_t rows_estimate() const;

  /// Appends the arrivals of the next rows, in the order of the file, to `all`: those of a piece, or some
  /// thousands. No arrival may be added if rows were refused. False at the end. Errors: those of the rows;
  /// the rows before the error are in `all`.
  [[nodiscard]] Result<bool> append(std::vector<Arrival>& all);

  /// Position of the first row that has not been returned.
  [[nodiscard]] TofPosition position() const {
    return general_ ? TofPosition{csv_.offset(), csv_.next_line(), order_->times()}
                    : TofPosition{offset_, line_, order_->times()};
  }
  [[nodiscard]] std::size_t rows() const { return rows_; }  ///< so far, refused ones included
  /// The clock of the rows so far, on which a restart is continued.
  [[nodiscard]] const ContinuedClock& clock() const { return order_->times().restarts; }
  [[nodiscard]] TofRefusals& refusals() { return refusals_; }
  /// Warnings about the whole file, at the end.
  [[nodiscard]] std::vector<std::string> warnings() const;
  /// Digest of the file; at the end.
  [[nodiscard]] std::string sha256();

 private:
  [[nodiscard]] std::size_t seam(std::size_t offset) const;
  void start();
  void parse_window();
  void parse(std::size_t piece, std::size_t slot);
  bool take(TofChunk& chunk, std::size_t first);
  Result<bool> next_rows(std::vector<Arrival>& block);
  Result<bool> append_as_written(std::vector<Arrival>& all);
  [[nodiscard]] Result<void> check_text() const;
  [[nodiscard]] Error first_error() const;
  [[nodiscard]] Error text_error(const Error& otherwise) const;
  void digest_to(std::size_t offset);
  void give_back(std::size_t offset);

  std::shared_ptr<const MappedFile> map_;
  std::string_view text_;
  std::string file_;
  const NameLookup& names_;
  Clock clock_;
  TofReaderOptions options_;
  CsvReader csv_;  // the header, and rows in the general way
  std::optional<TofColumns> columns_;
  std::optional<OrderWatch> order_;
  TofRefusals refusals_;
  RepeatedRows repeated_;
  std::size_t rows_ = 0;
  std::size_t body_ = 0, offset_ = 0;  // where the rows begin; where those begin that have not been given out
  std::size_t pieces_ = 0, piece_ = 0;  // how many there are; how many have been given out
  int line_ = 1;                        // of offset_
  std::size_t given_back_ = 0;
  bool general_ = false, out_of_order_ = false;

  Sha256 digest_;
  std::size_t digested_ = 0;
  std::vector<TofChunk> chunks_;         // those that are parsed together, by their place among them
  std::vector<TofChunkParser> parsers_;  // of each
};

}  // namespace octant::io
