// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/tof_chunk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "io/text/csv_scan.h"
#include "io/text/plain_number.h"
#include "models/support/largest.h"

namespace octant::io {

namespace {

/// Numbers that read_plain_number() does not handle: blanks, exponents, nan, empty cells.
[[gnu::noinline]] bool read_odd_number(std::string_view text, double& value) {
  const NumberText kind = parse_number(text, value);
  if (kind == NumberText::kEmpty) value = std::numeric_limits<double>::quiet_NaN();
  return kind != NumberText::kNotNumber;
}

}  // namespace

/// The current cell, by the marks (commas, newlines, points) of the chunk.
struct TofChunkParser::Cursor {
  const char* text;            // the chunk
  const std::uint32_t* marks;  // of its first mark not used yet
  const char* begin;           // of the cell, blanks included
  const char* point;           // its first one, or its end
  const char* end;             // the comma or newline behind it

  /// Moves to the next cell. The last mark of the chunk is a newline, so this is safe while *end is not a
  /// newline.
  void next() {
    begin = end + 1;
    point = end = text + *marks++;
    while (*end == '.') end = text + *marks++;
  }
  [[nodiscard]] std::string_view cell() const {
    // All blanks are at most a space, and hardly any other character is.
    const bool plain =
        begin != end && static_cast<unsigned char>(*begin) > ' ' && static_cast<unsigned char>(end[-1]) > ' ';
    return plain ? std::string_view(begin, static_cast<std::size_t>(end - begin)) : trimmed(begin, end);
  }
  /// Without the carriage return before a newline.
  void trim_return() {
    --end;
    point = std::min(point, end);
  }
  [[nodiscard]] bool blank() const { return cell().empty(); }

  /// Any number, empty and nan (value NaN) included.
  [[gnu::always_inline]] bool number(double& value) const {
    return read_plain_number(begin, point, end, value) || read_odd_number(cell(), value);
  }
  [[nodiscard]] bool integer(std::int64_t& value) const {
    return read_plain_integer(begin, end, value) || parse_integer(cell(), value);
  }
};

struct TofChunkParser::Row {
  std::string_view beacon, vehicle, receiver;
  std::string_view tof;  // blanks included
  double level_dbm = std::numeric_limits<double>::quiet_NaN();
  double received_s = std::numeric_limits<double>::quiet_NaN();
  bool level_ok = true;  // asked for only where there is no amplitude
};

TofChunkParser::TofChunkParser(std::size_t columns_in_file, const TofColumns& columns,
                               const NameLookup& names, Clock clock)
    : cells_(columns_in_file, Cell::kIgnored),
      names_(&names),
      clock_(clock),
      has_epoch_(columns.epoch >= 0),
      has_level_(columns.level >= 0) {
  const std::pair<int, Cell> known[] = {{columns.time, Cell::kTime},
                                        {columns.beacon, Cell::kBeacon},
                                        {columns.tof, Cell::kTof},
                                        {columns.epoch, Cell::kEpoch},
                                        {columns.vehicle, Cell::kVehicle},
                                        {columns.receiver, Cell::kReceiver},
                                        {columns.amplitude, Cell::kAmplitude},
                                        {columns.level, Cell::kLevel},
                                        {columns.temperature, Cell::kTemperature},
                                        {columns.received, Cell::kReceived}};
  for (const auto& [column, cell] : known) {
    if (column >= 0) cells_[static_cast<std::size_t>(column)] = cell;
  }
}

/// Reads one line; false if the general method must read it.
[[gnu::always_inline]] inline bool TofChunkParser::parse_row(Cursor& cursor, TofChunk& out) {
  cursor.next();
  if (*cursor.end == '\n') return cursor.blank();  // a blank line is no row; a row has several cells
  Row row;
  Arrival& arrival = out.arrivals.emplace_back();
  const std::size_t last = cells_.size() - 1;
  for (std::size_t i = 0; i < last; ++i) {
    if (*cursor.end == '\n' || !read_cell(cells_[i], cursor, row, arrival)) return false;
    cursor.next();
  }
  const char* const end = cursor.end;
  if (*end == '\n' && end[-1] == '\r') cursor.trim_return();
  if (!read_cell(cells_[last], cursor, row, arrival)) return false;
  cursor.end = end;
  if (*end != '\n') {  // a comma at the end of each row is a habit of some programs
    cursor.next();
    if (*cursor.end != '\n' || !cursor.blank()) return false;
  }
  return settle(row, arrival, out);
}

[[gnu::always_inline]] inline bool TofChunkParser::read_cell(Cell cell, const Cursor& cursor, Row& row,
                                                             Arrival& arrival) const {
  switch (cell) {
    case Cell::kIgnored: return true;
    case Cell::kTime: return cursor.number(arrival.time_s) && std::isfinite(arrival.time_s);
    case Cell::kBeacon: row.beacon = cursor.cell(); return true;
    case Cell::kTof:
      row.tof = {cursor.begin, static_cast<std::size_t>(cursor.end - cursor.begin)};
      return cursor.number(arrival.tof_s);
    case Cell::kEpoch: return cursor.integer(arrival.epoch);
    case Cell::kVehicle: row.vehicle = cursor.cell(); return true;
    case Cell::kReceiver: row.receiver = cursor.cell(); return true;
    case Cell::kAmplitude: return cursor.number(arrival.amplitude_v);
    case Cell::kLevel: row.level_ok = cursor.number(row.level_dbm); return true;
    case Cell::kTemperature:
      return cursor.number(arrival.temperature_degC) && is_temperature(arrival.temperature_degC);
    case Cell::kReceived: return cursor.number(row.received_s);
  }
  return false;
}

/// Completes a row: ids, order, and the check for measurements.
inline bool TofChunkParser::settle(const Row& row, Arrival& arrival, TofChunk& out) {
  if (out.rows == 0) out.first_time_s = arrival.time_s;
  if (out.rows > 0 && arrival.time_s < out.last_time_s) return false;
  out.last_time_s = arrival.time_s;
  arrival.beacon = names_->beacon(row.beacon);
  arrival.vehicle = names_->vehicle(row.vehicle);
  if (!arrival.beacon.valid() || !arrival.vehicle.valid()) return false;
  arrival.receiver = names_->receiver(arrival.vehicle, row.receiver);
  if (!arrival.receiver.valid()) return false;
  if (has_epoch_) {
    std::int64_t& epoch = epoch_of_vehicle_[arrival.vehicle.index()];
    if (arrival.epoch != epoch) out.epochs.push_back({arrival.vehicle, arrival.epoch});
    epoch = arrival.epoch;
  }
  if (has_level_ && !(arrival.amplitude_v > 0.0)) {
    if (!row.level_ok) return false;
    arrival.amplitude_v = amplitude_of_level(row.level_dbm);
  }
  arrival.amplitude_v = usable_amplitude(arrival.amplitude_v);
  arrival.received_after_s = reception_delay_s(arrival.time_s, row.received_s);
  arrival.line = out.lines;
  ++out.rows;
  if (!(arrival.tof_s > 0.0) || arrival.tof_s > kLargestTof_s) {
    const std::string_view text = trimmed(row.tof.data(), row.tof.data() + row.tof.size());
    const Refusal refusal = refusal_of(text, arrival.tof_s, clock_);
    if (refusal == Refusal::kNone) return true;
    out.refused.push_back({out.lines, refusal, text});
    out.arrivals.pop_back();
  }
  return true;
}

void TofChunkParser::parse(std::string_view chunk, TofChunk& out) {
  out.regular = false;
  out.refused.clear();
  out.epochs.clear();
  out.rows = 0;
  out.lines = 0;
  if (!chunk.empty() && !chunk.ends_with('\n')) {
    out.copy.assign(kBeforeNumber, ' ');
    out.copy.append(chunk).append("\n");
    chunk = std::string_view(out.copy).substr(kBeforeNumber);
  }
  marks_.find(chunk);
  // Quotes may contain commas and newlines. In a text without quotes, rows begin and end at the seams of its
  // pieces.
  if (marks_.has_quote || marks_.has_nul || (marks_.has_high && !is_utf8(chunk))) return;
  epoch_of_vehicle_.assign(names_->names().vehicles.size(), kNoEpoch);
  Cursor cursor{.text = chunk.data(),
                .marks = marks_.offsets.data(),
                .begin = nullptr,
                .point = nullptr,
                .end = chunk.data() - 1};
  for (const std::uint32_t* const stop = cursor.marks + marks_.count; cursor.marks != stop; ++out.lines) {
    if (!parse_row(cursor, out)) return;
  }
  out.regular = true;
}

}  // namespace octant::io
