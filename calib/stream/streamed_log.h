// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calib/stream/drives/drive_index.h"
#include "calib/stream/log_readings.h"
#include "calib/stream/stops/log_index.h"
#include "calib/stream/stops/log_passes.h"

namespace octant::calib {

/// Whether a run is a drive with odometry, not stops.
[[nodiscard]] inline bool is_drive(const MeasurementLog& run) {
  return !run.has_epochs && !run.odometry.empty();
}

/// The log of a source, which is read several times: runs that are stops, runs that are drives.
class StreamedLog : public LogReadings {
 public:
  /// All must outlive it.
  StreamedLog(const Site& site, ArrivalSource& source, const StreamPlan& plan);

  /// Reads all of it once, first.
  [[nodiscard]] Result<void> scan();
  /// Evenly spread stops and stretches of drives.
  [[nodiscard]] Result<Problem> part(int threads) const;
  /// What make_problem() would say of all of it. @param part  of it
  [[nodiscard]] std::vector<std::string> warnings(const Problem& part) const;
  [[nodiscard]] std::size_t states() const { return stops_.all_epochs() + drives_.nodes(); }

  /// To be called before any of those below. @param frame  site and runs without arrivals
  void begin(const Problem& frame, const SolveOptions& options, int workers, Course& course);
  [[nodiscard]] Result<Placed> place(const Estimate& estimate, double suspect_sigmas, bool mark) override;
  [[nodiscard]] Result<PassSum> pass(const Estimate& estimate, MarkPolicy marks) override;
  void accept() override;
  [[nodiscard]] Result<void> tell(const Estimate& estimate, FindingsGatherer& gatherer) override;

 private:
  const Site& site_;
  ArrivalSource& source_;
  LogIndex stops_;
  DriveIndex drives_;
  std::size_t piece_bytes_;
  std::vector<std::unique_ptr<LogReadings>> readings_;
};

}  // namespace octant::calib
