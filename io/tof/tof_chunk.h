// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: fast parser of a piece of tof.csv. It reads the usual rows, and reports all others as not
// regular.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/text/csv_marks.h"
#include "io/tof/run_parts.h"
#include "io/tof/tof_rows.h"
#include "models/run.h"

namespace octant::io {

/// The rows of a piece. Lines count from 0, the piece's first.
struct TofChunk {
  struct RefusedRow {
    int line;
    Refusal refusal;
    std::string_view text;
  };
  struct EpochBegin {
    VehicleId vehicle;
    std::int64_t epoch;
  };
  /// All rows were read. Otherwise the other members are invalid, because of an error or an unusual form
  /// (quotes), and read_tof_row() must read the piece.
  bool regular = false;
  std::vector<Arrival> arrivals;  ///< appended to the existing ones
  std::vector<RefusedRow> refused;
  std::vector<EpochBegin> epochs;  ///< each change of a vehicle's epoch from one row to the next
  std::size_t rows = 0;            ///< refused ones included
  int lines = 0;
  double first_time_s = 0.0, last_time_s = 0.0;  ///< first and last time of all rows, which do not decrease
  std::string copy;                              ///< copy of a piece without a final newline
};

/// Parses pieces of one file; each thread has its own.
class TofChunkParser {
 public:
  TofChunkParser(std::size_t columns_in_file, const TofColumns& columns, const NameLookup& names,
                 Clock clock);

  /// @param chunk  whole lines; kBeforeNumber bytes before it may be read (those of the header line)
  void parse(std::string_view chunk, TofChunk& out);

 private:
  enum class Cell : std::uint8_t {
    kIgnored,
    kTime,
    kBeacon,
    kTof,
    kEpoch,
    kVehicle,
    kReceiver,
    kAmplitude,
    kLevel,
    kTemperature,
    kReceived
  };
  struct Row;  // cells of a row that depend on each other

  struct Cursor;  // where a row is being read

  bool parse_row(Cursor& cursor, TofChunk& out);
  [[nodiscard]] bool read_cell(Cell cell, const Cursor& cursor, Row& row, Arrival& arrival) const;
  bool settle(const Row& row, Arrival& arrival, TofChunk& out);

  std::vector<Cell> cells_;
  const NameLookup* names_;
  Clock clock_;
  bool has_epoch_, has_level_;
  CsvMarks marks_;
  std::vector<std::int64_t> epoch_of_vehicle_;
};

}  // namespace octant::io
