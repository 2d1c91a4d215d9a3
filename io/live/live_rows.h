// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "models/odometry_pose.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

/// Completes the pose that is open: {"flush": true}
struct LiveFlush {};
/// Content of a line; std::monostate for an empty line or a comment.
using LiveRow = std::variant<std::monostate, Arrival, OdometryStep, OdometryPose, LiveFlush>;

/// Lines of a live stream (schema `live`): a JSON object each, with the names of a run folder's columns:
///   {"time_s": 12.31, "beacon": "B1", "tof_s": 0.0123}         also epoch, vehicle, receiver, amplitude_v,
///   temperature_degC
///   {"time_s": 12.30, "dx_m": 0.01, "dy_m": 0, "dheading_rad": 0.002}    also vehicle; in space dz_m,
///   and qx, qy, qz, qw in place of dheading_rad
///   {"time_s": 12.30, "odometry_x_m": 3.1, "odometry_y_m": 0.2, "odometry_heading_rad": 1.2}    the pose in
///   odometry's own frame; in space odometry_z_m, and qx, qy, qz, qw in place of the heading
/// Keys that are not known are ignored.
class LiveReader {
 public:
  /// @param constant_speed_mps  speed with which distance_m may replace tof_s; 0: it may not
  explicit LiveReader(NameTable names, double constant_speed_mps = 0.0);
  ~LiveReader();
  LiveReader(LiveReader&&) noexcept;
  LiveReader& operator=(LiveReader&&) noexcept;

  /// Parses a line. Errors (found, expected): text that is not a row, a name that the deployment does not
  /// have. Never throws.
  [[nodiscard]] Result<LiveRow> row(std::string_view line) const;

 private:
  struct Names;
  std::unique_ptr<const Names> names_;
  double constant_speed_mps_ = 0.0;
};

/// Splits a stream of bytes into lines. Memory is bounded: a line longer than `most` bytes is only counted.
class LineCutter {
 public:
  explicit LineCutter(std::size_t most = 65536) : most_(most) {}

  /// Calls line(text) for each complete line, without its end, and too_long() for each line that was too
  /// long.
  template <class Line, class TooLong>
  void feed(std::string_view bytes, Line&& line, TooLong&& too_long) {
    while (!bytes.empty()) {
      const std::size_t end = bytes.find('\n');
      const std::string_view piece = bytes.substr(0, end);
      if (begun_.size() + piece.size() > most_) overlong_ = true;
      if (end == std::string_view::npos) {
        if (!overlong_) begun_.append(piece);
        return;
      }
      if (overlong_) {
        too_long();
      } else if (begun_.empty()) {
        line(without_cr(piece));
      } else {
        begun_.append(piece);
        line(without_cr(begun_));
      }
      begun_.clear();
      overlong_ = false;
      bytes.remove_prefix(end + 1);
    }
  }
  /// Processes the end of the stream; a line without an end counts too.
  template <class Line, class TooLong>
  void end(Line&& line, TooLong&& too_long) {
    if (overlong_ || !begun_.empty()) feed("\n", line, too_long);
  }

 private:
  static std::string_view without_cr(std::string_view text) {
    return text.substr(0, text.size() - (text.ends_with('\r') ? 1 : 0));
  }
  std::size_t most_;
  std::string begun_;
  bool overlong_ = false;
};

}  // namespace octant::io
