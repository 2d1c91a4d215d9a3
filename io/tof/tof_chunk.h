// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the fast way through a piece of tof.csv. It settles what nearly all files hold, and
// otherwise says that it cannot.

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
  /// All rows were read. If not, the others mean nothing: something is wrong, or odd (quotes), and
  /// read_tof_row() must look.
  bool regular = false;
  std::vector<Arrival> arrivals;  ///< behind those that were there before
  std::vector<RefusedRow> refused;
  std::vector<EpochBegin> epochs;  ///< each time a vehicle's epoch differs from that of its row before
  std::size_t rows = 0;            ///< refused ones included
  int lines = 0;
  double first_time_s = 0.0, last_time_s = 0.0;  ///< of all rows, between which time does not decrease
  std::string copy;                              ///< of a piece that lacks its last newline
};

/// Reads pieces of one file; each thread has one of its own.
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
    kTemperature
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
