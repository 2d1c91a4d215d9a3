// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "apps/octant/cockpit/append_file.h"
#include "models/odometry_pose.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::app {

/// Decides which arrivals share a pose.
enum class StopMode {
  kUndecided,  ///< no arrival yet
  kRows,       ///< the rows carry their epoch
  kMarked,     ///< the operator marks begin and end of each stop
  kDrive       ///< no epochs: the vehicle moves continuously
};

/// A stop as the operator sees it.
struct RecordedStop {
  double first_s = 0.0, last_s = 0.0;
  std::size_t arrivals = 0;
  std::set<std::uint32_t> beacons{};  ///< received ones
};

/// A position measured by hand for a stop: a row of points.csv.
struct ControlPoint {
  double x_m = 0.0, y_m = 0.0, sigma_m = 0.0;
  std::string name;
};

struct RecorderCounts {
  std::size_t arrivals = 0, odometry = 0;                ///< written to the run
  std::size_t late = 0, between_stops = 0, deleted = 0;  ///< written to unused.csv
  std::size_t stop_is_over = 0, unknown = 0;             ///< likewise
  std::size_t late_odometry = 0;                         ///< increments among them are in the next row
  std::size_t lost = 0;         ///< rows that the memory could not keep while writing failed
  std::size_t clock_steps = 0;  ///< times at which the sender's clock was set back
};

/// Writes a live stream into a run folder, which is readable at any moment. Rows may come in any order within
/// the lateness. Arrivals that cannot be part of the run are in unused.csv with the reason, so that no row is
/// lost. Not for several threads.
class RunRecorder {
 public:
  RunRecorder(std::string folder, NameTable names, Motion motion, double lateness_s);

  /// Replaces the names by longer lists that begin with the same ones.
  void set_names(NameTable names);
  /// Creates the folder with run.yaml.
  [[nodiscard]] Result<void> begin(const std::string& run_yaml);
  void add(Arrival arrival);
  /// Writes an arrival to unused.csv, because a name in it is not in the site file.
  void add_unknown(const Arrival& arrival, const char* reason);
  void add(OdometryStep step);
  void add(OdometryPose pose);
  /// Writes the rows that no earlier row can precede any more.
  /// @param all  all rows: the stream is quiet or over
  [[nodiscard]] Result<void> flush(bool all);
  /// Descriptors of the open files, to wait for the disk. The caller closes them.
  [[nodiscard]] std::vector<int> descriptors() const;

  /// Begins a stop. Error: the rows define the stops, or the run is a drive with odometry.
  /// @return its epoch
  [[nodiscard]] Result<std::int64_t> begin_stop();
  [[nodiscard]] Result<void> end_stop();
  /// Moves the arrivals of a stop to unused.csv.
  [[nodiscard]] Result<void> delete_stop(std::int64_t epoch);
  /// Writes points.csv. Error: there is no such stop.
  [[nodiscard]] Result<void> set_point(std::int64_t epoch, const ControlPoint& point);

  [[nodiscard]] StopMode mode() const { return mode_; }
  [[nodiscard]] std::optional<std::int64_t> open_stop() const { return open_stop_; }
  [[nodiscard]] const std::map<std::int64_t, RecordedStop>& stops() const { return stops_; }
  [[nodiscard]] const std::map<std::int64_t, ControlPoint>& points() const { return points_; }
  /// Rows that are written.
  [[nodiscard]] const RecorderCounts& counts() const { return written_counts_; }
  [[nodiscard]] const std::string& folder() const { return folder_; }

 private:
  /// Rows that wait for earlier ones, by time.
  template <class Row>
  struct Waiting {
    std::deque<Row> rows;
    double written_s = -std::numeric_limits<double>::infinity();  ///< time of the last written row
    double newest_s = written_s;                                  ///< that was received
    std::size_t behind = 0;                                       ///< consecutive late rows
  };
  template <class Row>
  bool insert(Waiting<Row>& waiting, Row& row);
  void continue_epochs(Arrival& arrival);
  void choose_mode(const Arrival& arrival);
  [[nodiscard]] Result<void> leave_drive();
  bool append(AppendFile& file, const std::string& row);
  void write(const Arrival& arrival);
  void write_unused(const Arrival& arrival, const char* reason);
  void write(const OdometryPose& pose);
  void write_step(OdometryStep step);
  [[nodiscard]] Result<void> set_points();
  [[nodiscard]] Result<void> forget_stop(std::int64_t epoch, std::size_t deleted);
  [[nodiscard]] std::string row_of(const Arrival& arrival, bool with_epoch) const;

  std::string folder_;
  NameTable names_;
  Motion motion_;
  std::vector<std::string> beacon_fields_, vehicle_fields_, receiver_fields_;
  double lateness_s_, offset_s_ = 0.0, newest_s_ = -std::numeric_limits<double>::infinity();
  StopMode mode_ = StopMode::kUndecided;
  std::unique_ptr<AppendFile> tof_, odometry_, unused_;
  Waiting<Arrival> arrivals_;
  Waiting<OdometryStep> steps_;
  Waiting<OdometryPose> poses_;
  std::map<std::uint32_t, Pose> last_pose_;  ///< by vehicle, in the frame of its odometry
  std::set<std::uint32_t> anchored_;         ///< vehicles whose first odometry row is written
  std::map<std::uint32_t, Pose> late_step_;  ///< by vehicle: increments that came too late for their row
  struct Epochs {
    std::int64_t largest = -1, offset = 0;
    std::size_t clock_steps = 0;  ///< that are considered
  };
  std::map<std::uint32_t, Epochs> epochs_;  ///< by vehicle
  std::map<std::uint32_t, std::int64_t> current_epoch_;
  std::set<std::pair<std::uint32_t, std::int64_t>> finished_epochs_;
  std::optional<std::int64_t> open_stop_;
  std::int64_t next_stop_ = 0;
  std::map<std::int64_t, RecordedStop> stops_;
  std::map<std::int64_t, ControlPoint> points_;
  RecorderCounts counts_, written_counts_;
};

}  // namespace octant::app
