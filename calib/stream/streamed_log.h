// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/log/calibration_log.h"
#include "calib/start/course.h"
#include "calib/stream/chunks/chunk_index.h"
#include "calib/stream/chunks/chunk_passes.h"
#include "calib/stream/drives/drive_index.h"
#include "calib/stream/log_readings.h"

namespace octant::calib {

/// The log of a source, which is read again for each look at it: drives in pieces (drives/), all else in
/// chunks (chunks/). One reading is one step of its adjustment (newton_steps.h).
class StreamedLog : public CalibrationLog {
 public:
  /// All outlive it.
  /// @param memory_bytes  bound of the process, by the size of what is read at once
  StreamedLog(const Site& site, ArrivalSource& source, const SolveOptions& options, Course& course,
              std::size_t memory_bytes);

  /// Its runs hold the arrivals of the sample, in the end those of every so many-th state.
  [[nodiscard]] const Problem& problem() const override { return frame_; }
  [[nodiscard]] Problem taken_problem() && { return std::move(frame_); }
  /// Reads all of it once. Evenly spread stops and stretches of drives.
  [[nodiscard]] Result<Sample> next_sample() override;
  [[nodiscard]] Result<double> place(Approach& start, double sigma) override;
  [[nodiscard]] Result<CalibrationStatistics> adjust_inliers(Estimate& estimate) override;
  void scale_noise(Estimate& estimate, double factor) override;
  [[nodiscard]] Result<LogFindings> findings(const Estimate& estimate) override;

 private:
  [[nodiscard]] Result<void> scan();
  /// Runs of stops alone are thinned by epochs, all others by stretches of time.
  [[nodiscard]] bool has_stops_alone(std::size_t run) const;
  [[nodiscard]] Result<Problem> part() const;
  void begin_readings();

  const Site& site_;
  ArrivalSource& source_;
  const SolveOptions& options_;
  Course& course_;
  StreamPlan plan_;
  ChunkIndex chunks_;
  DriveIndex drives_;
  bool is_scanned_ = false;
  Problem frame_;  ///< the log without its arrivals
  JoinedReadings readings_;
  std::size_t states_ = 0;
  std::optional<PassSum> first_sum_;  ///< at the start, where placing marked and summed up as well
};

}  // namespace octant::calib
