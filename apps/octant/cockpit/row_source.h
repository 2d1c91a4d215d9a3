// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "apps/octant/live/bad_lines.h"
#include "apps/octant/live/byte_source.h"
#include "apps/octant/session.h"
#include "io/live/live_rows.h"
#include "models/run.h"

namespace octant::app {

/// Rows of a live stream, or of a recording that is replayed.
class RowSource {
 public:
  using Sink = std::function<void(const io::LiveRow&)>;
  enum class Event { kRows, kQuiet, kEnd };
  virtual ~RowSource() = default;
  /// Passes on the rows that have come, after a wait of at most timeout_ms. Fails on read errors.
  [[nodiscard]] virtual Event read(int timeout_ms, const Sink& sink) = 0;
  /// Source in words, for people.
  [[nodiscard]] virtual std::string description() const = 0;
  /// Names that the stream has brought since the last call; null if there are no new ones. Earlier names keep
  /// their ids.
  [[nodiscard]] virtual const NameTable* new_names() { return nullptr; }
  /// Kinds of invalid lines with their counts.
  [[nodiscard]] virtual std::map<std::string, std::size_t> bad_lines() const { return {}; }
};

/// Opens a stream of live lines: "stdin" or "-", "tcp:PORT", "udp:PORT", "serial:DEVICE[:BAUD]" or a device.
/// Rows of beacons that are not among the names are passed on too, with new names, and are invalid lines.
[[nodiscard]] std::unique_ptr<RowSource> open_line_source(const std::string& where, NameTable names,
                                                          double constant_speed_mps, Session& session);
/// Source for a recording without a site file, which takes the names from the lines.
[[nodiscard]] std::unique_ptr<RowSource> open_nameless_source(const std::string& where, Session& session);
/// Replays arrivals and odometry of a recording. @param speed  relative to real time; 0: at once
[[nodiscard]] std::unique_ptr<RowSource> replay_source(MeasurementLog run, double speed);

}  // namespace octant::app
