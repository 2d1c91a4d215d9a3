// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the files of one run folder, part by part, for read_run() and RunStream.

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/run/read_run_options.h"
#include "io/tof/run_parts.h"
#include "io/tof/tof_reader.h"

namespace octant::io {

/// Fills a log; each file's digest goes into it.
class RunReader {
 public:
  RunReader(const std::string& folder, const NameTable& names, const Timing& timing,
            const ReadRunOptions& options);

  /// Checks the folder, reads run.yaml (which names the vehicle of rows without a name) and the header of
  /// tof.csv.
  [[nodiscard]] Result<void> begin();
  /// Reads all of tof.csv into the log.
  [[nodiscard]] Result<void> read_arrivals();
  /// Reads the next arrivals of tof.csv and replaces the content of `block`, which may stay empty. False at
  /// the end.
  [[nodiscard]] Result<bool> next_arrivals(std::vector<Arrival>& block);
  /// Reads bearings, scans, odometry, poses and truth. Points measured by hand refer to epochs: if the
  /// arrivals have not been read yet, one pose represents them.
  [[nodiscard]] Result<void> read_others();
  /// Final checks after all files have been read: returns an error if there is no usable data.
  [[nodiscard]] Result<void> finish();

  /// Position of the first row that next_arrivals() has not returned.
  [[nodiscard]] TofPosition position() const { return tof_ ? tof_->position() : end_; }
  /// Upper estimate of the number of rows of tof.csv.
  [[nodiscard]] std::size_t rows_estimate() const { return tof_ ? tof_->rows_estimate() : 0; }
  /// Appends the arrivals between two positions that position() returned to `arrivals`. Any thread may call
  /// it.
  [[nodiscard]] Result<void> read_again(TofPosition from, TofPosition to,
                                        std::vector<Arrival>& arrivals) const;

  [[nodiscard]] const MeasurementLog& log() const { return log_; }
  [[nodiscard]] MeasurementLog take_log() { return std::move(log_); }

 private:
  [[nodiscard]] std::string path(const char* name) const;
  [[nodiscard]] bool is_there(const std::string& file) const;
  [[nodiscard]] Result<void> check_folder() const;
  /// A file of the folder, and the size of the part that is read: all but a truncated last row.
  struct RunFileText {
    MappedFile map;
    std::size_t size;
    [[nodiscard]] std::string_view text() const { return map.text().substr(0, size); }
  };
  Result<std::optional<RunFileText>> load(const char* name);
  Result<bool> append_arrivals(std::vector<Arrival>& all);
  Result<void> read_header();
  Result<void> open_tof();
  Result<void> read_differences();
  Result<void> read_bearings();
  Result<void> read_scans();
  Result<void> read_odometry();
  Result<void> read_track(const char* name, std::vector<TimedPose>& poses);
  Result<void> read_points(const char* name, const char* instead_of, std::vector<TimedPose>& poses,
                           PoseAccuracy& accuracy);

  NameLookup lookup_;
  Clock clock_;
  ReadRunOptions options_;
  DistanceAsTime distance_;
  double range_max_m_ = std::numeric_limits<double>::infinity();
  MeasurementLog log_;
  std::shared_ptr<const MappedFile> tof_map_;
  std::unique_ptr<TofReader> tof_;  // null: there is none, or it has been read
  TofPosition end_;                 // then, of the end
  bool has_tof_ = false;
  bool has_clocks_ = false;  // tdoa.csv or toa.csv in place of tof.csv
  std::size_t arrivals_ = 0;
  VehicleId first_vehicle_;                                         // of the first arrival
  double first_time_s_ = std::numeric_limits<double>::quiet_NaN();  // of the first arrival
  ContinuedClock clock_of_tof_;
  TimeUnitCheck time_unit_;
};

}  // namespace octant::io
