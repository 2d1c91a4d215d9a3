// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "models/arrival_source.h"
#include "models/trajectory/stretches.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// A segment of a drive with kUnitNodes states, which begins where the one before it ends.
struct DriveUnit {
  double from_s = 0.0;
  std::size_t first_row = 0;  ///< row of the run's odometry at its first state
  std::size_t arrivals = 0;
  std::size_t first_block = 0, last_block = 0;  ///< blocks of the source with its arrivals, [first, last)
};
inline constexpr std::size_t kUnitNodes = kStretchNodes;

/// The drive of one vehicle in one run; without units if its states are not a drive (StateKind).
struct DriveChain {
  std::size_t run = 0;
  VehicleId vehicle;
  std::size_t nodes = 0, arrivals = 0;
  double until_s = 0.0;
  std::size_t last_row = 0;  ///< odometry row of its last state
  std::vector<DriveUnit> units;
  std::vector<std::size_t> stateless;  ///< arrivals of each beacon before the first or after the last state
  std::size_t stateless_count = 0;
  int stateless_line = 0;  ///< line of the first of them

  /// States of a unit, both ends included.
  [[nodiscard]] std::size_t nodes_of(std::size_t unit) const;
  [[nodiscard]] double end_of(std::size_t unit) const {
    return unit + 1 < units.size() ? units[unit + 1].from_s : until_s;
  }
};

/// Arrivals of a vehicle within some seconds, as subsample() groups them.
struct DriveGroup {
  VehicleId vehicle;
  std::int64_t key = 0;  ///< which seconds
  double first_s = 0.0, last_s = 0.0;
  std::size_t arrivals = 0;
  std::size_t first_block = 0, last_block = 0;  ///< blocks of the source, [first, last)
};
/// All of a run, in the order in which they begin.
struct DriveGroups {
  double length_s = 0.0;  ///< of each
  double begin_s = 0.0;
  std::size_t arrivals = 0;
  std::vector<DriveGroup> groups;
  std::vector<std::uint32_t> heard;  ///< group-major: arrivals of each beacon
  std::vector<std::size_t> latest;   ///< latest unit of each vehicle; SIZE_MAX: not known

  [[nodiscard]] std::int64_t key_at(double time_s) const;
};

/// Units of a drive that are worked on at once. Its first and last state are those of its neighbours as well.
struct DrivePiece {
  std::size_t chain = 0, first_unit = 0, last_unit = 0;  ///< [first, last)
  std::size_t nodes = 0, arrivals = 0, arrivals_before = 0;
  bool open_left = false, open_right = false;  ///< has a neighbour there
};

/// A piece that a worker processes.
struct DriveWork {
  const DrivePiece* piece = nullptr;
  MeasurementLog log;
  std::vector<Trajectory> trajectory;  ///< one: of the piece, a single segment
  [[nodiscard]] Trajectory& t() { return trajectory.front(); }
  [[nodiscard]] const Trajectory& t() const { return trajectory.front(); }
};

/// Bytes that a state and an arrival of a drive take while they are worked on.
inline constexpr std::size_t kBytesOfStateInWork = 1200, kBytesOfDriveArrivalInWork = 280;

/// Where the arrivals of drives lie among the blocks of a source, and in which pieces they are worked on.
class DriveIndex {
 public:
  /// Follows the rows of a source: add() of each block, then end(). Runs may be left out.
  DriveIndex(const ArrivalSource& source, const Site& site);
  void add(std::size_t run, const std::vector<Arrival>& block);
  void end(std::size_t piece_bytes);

  [[nodiscard]] const std::vector<DriveChain>& chains() const { return chains_; }
  [[nodiscard]] const std::vector<DrivePiece>& pieces() const { return pieces_; }
  [[nodiscard]] const DriveGroups& groups(std::size_t run) const { return groups_[run]; }
  /// A piece extended by one unit on each side with a neighbour.
  [[nodiscard]] DrivePiece widened(const DrivePiece& piece) const;
  [[nodiscard]] std::size_t arrivals() const { return arrivals_; }  ///< arrivals that belong to a state
  [[nodiscard]] std::size_t nodes() const { return nodes_; }
  [[nodiscard]] std::size_t beacons() const { return beacons_; }

  /// Replaces the content of `arrivals` by the arrivals of a group. Any thread may call it.
  [[nodiscard]] Result<void> read(const ArrivalSource& source, std::size_t run, const DriveGroup& group,
                                  std::vector<Arrival>& arrivals) const;
  /// A piece as a log: its odometry rows, first state to last, its arrivals, bearings and measured poses; the
  /// other lists of the run are unchanged.
  /// @return the number in the run of its first bearing
  [[nodiscard]] Result<std::size_t> read(const ArrivalSource& source, const DrivePiece& piece,
                                         MeasurementLog& log) const;
  /// Rows of a chain from the last one at or before a time to the first one at or behind another.
  [[nodiscard]] std::vector<OdometryStep> odometry_within(const ArrivalSource& source, std::size_t chain,
                                                          double from_s, double until_s) const;

 private:
  void group(DriveGroups& of_run, std::size_t block, const Arrival& a) const;
  [[nodiscard]] Result<void> read_arrivals(const ArrivalSource& source, const DrivePiece& piece,
                                           std::vector<Arrival>& arrivals) const;

  std::size_t vehicles_ = 0, beacons_ = 0, arrivals_ = 0, nodes_ = 0;
  std::vector<DriveChain> chains_;  ///< run-major
  std::vector<DriveGroups> groups_;
  std::vector<DrivePiece> pieces_;
  std::vector<std::size_t> blocks_, unit_of_chain_;  ///< so far: of each run, of each chain
};

}  // namespace octant::calib
