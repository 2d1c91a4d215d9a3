// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "calib/lanes/stop_reduction.h"
#include "calib/lanes/stop_solve.h"
#include "calib/problem/parameters.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

struct ReducedSystem;

/// Floor of the information of an unobservable direction of a state, relative to the largest diagonal
/// element: above rounding errors, below any information. The general path of the tile uses the same value.
inline constexpr double kUnobservedFloor = 1e-14;

/// Arrivals of a trajectory, as much of each as the kernel needs. The stops of a tile lie far apart in a long
/// log, and fetching whole observations from there costs more than copying these in passing.
class StopArrivals {
 public:
  /// Allocates memory for all arrivals of a trajectory, at least one. Any thread may call add() for each of
  /// them, or for no arrival.
  explicit StopArrivals(const Trajectory& trajectory);
  void add(std::size_t i, const ArrivalObservation& arrival);

  /// Speed of the medium where it is the same for all arrivals.
  [[nodiscard]] double speed_mps() const { return speed_mps_; }
  [[nodiscard]] bool own_speeds() const { return own_speeds_; }

  [[nodiscard]] double tof_s(std::size_t i) const { return tof_s_[i]; }
  [[nodiscard]] bool used(std::size_t i) const { return path_[i] != kNotUsed; }
  [[nodiscard]] std::size_t beacon(std::size_t i) const { return path_[i] >> kReceiverBits; }
  [[nodiscard]] std::size_t receiver(std::size_t i) const { return path_[i] & (kMostReceivers - 1); }
  void prefetch(std::size_t first, std::size_t last) const;

  static constexpr std::size_t kReceiverBits = 12, kMostReceivers = 1U << kReceiverBits,
                               kMostBeacons = 1U << (31 - kReceiverBits);

 private:
  static constexpr std::uint32_t kNotUsed = 0xffffffff;
  std::unique_ptr<double[]>
      tof_s_;  // NOLINT(modernize-avoid-c-arrays): memory that is not touched before it is written
  std::unique_ptr<std::uint32_t[]> path_;  // NOLINT(modernize-avoid-c-arrays)
  double speed_mps_;
  std::atomic<bool> own_speeds_{false};
};

/// The stops of a tile turned sideways for the vector kernel: stationary planar epochs of arrivals, which is
/// what most of a long log is. Cost, gradient and Gauss-Newton matrix are those that the general path of the
/// tile gives.
class StopBlock {
 public:
  /// Returns true if the kernel supports the measurement equation of a trajectory: planar, one way, no time-
  /// walk, no bias of a pair, no drift, no motion prior.
  [[nodiscard]] static bool knows(const Trajectory& trajectory, const ParameterLayout& layout);
  /// Returns true if it supports a segment: one placed node, arrivals of one sigma, at most one measured
  /// pose, no other observations.
  [[nodiscard]] static bool takes(const Trajectory& trajectory, const Segment& segment);

  /// @param trajectory  not owned; `rewind` writes the nodes of the segments
  /// @param segments    ideally in an order in which neighbours have the same paths
  /// @param arrivals    those of the segments; not kept
  StopBlock(Trajectory* trajectory, const std::vector<std::size_t>& segments, const StopArrivals& arrivals,
            const ParameterLayout* layout);

  /// Solves for the epochs from where they were committed and returns their cost.
  double solve_states(const SharedState& state, const RobustLoss& loss);
  /// Adds the reduced system at the states of the last `solve_states` to the gradient and the lower triangle.
  /// `place` is the position of each column of the layout in it (-1: not in it).
  void reduce(const SharedState& state, const RobustLoss& loss, const std::vector<int>& place,
              ReducedSystem& system);
  void commit() { committed_ = states_; }
  /// Back to the states committed last, which the trajectory then shows too.
  void rewind();
  /// Marks the beacons and receivers of the arrivals in use.
  void collect_heard(std::vector<char>& beacons, std::vector<char>& receivers) const;

 private:
  struct Epoch {
    std::size_t segment = 0, node = 0, first_arrival = 0, last_arrival = 0;
    std::size_t pose = 0;  ///< measured, if there is one
  };
  /// Packs [first, last) share a list of beacons.
  struct PackGroup {
    std::size_t first = 0, last = 0;
    std::vector<std::int32_t> beacons;
  };
  /// Destination of a column of a group: no place if it is fixed, two places if they share it.
  struct ColumnTargets {
    int count = 0;
    int column[2] = {};  ///< columns of the tile's system
    double factor[2] = {};
  };

  /// Prefetches the data of a pack.
  void fetch(std::size_t p, const StopArrivals& arrivals) const;
  void group(const StopArrivals& arrivals);
  void pack(const StopArrivals& arrivals);
  [[nodiscard]] StopTables tables_at(const SharedState& state, const RobustLoss& loss);
  [[nodiscard]] StopPack pack_of(std::size_t p, const PackGroup& group) const;
  [[nodiscard]] std::size_t epochs_in(std::size_t p) const {
    return std::min(kLanes, epochs_.size() - p * kLanes);
  }
  void put(std::size_t epoch, const Node& node);
  void put(std::size_t epoch, const PoseObservation& pose);
  void show(std::size_t epoch);
  [[nodiscard]] std::vector<ColumnTargets> targets_of(const PackGroup& group, const SharedState& state,
                                                      const std::vector<int>& place) const;
  void add_group(const PackGroup& group, const StopTables& tables, const SharedState& state,
                 const std::vector<int>& place, ReducedSystem& system);

  Trajectory* trajectory_;
  const ParameterLayout* layout_;
  std::size_t first_receiver_ = 0, receivers_ = 0;  ///< receivers of the vehicle
  double sigma_s_ = 1.0;
  double speed_mps_ = 0.0;     ///< speed of the medium, if it is the same for all arrivals
  bool own_speeds_ = false;    ///< else
  std::vector<Epoch> epochs_;  ///< in the order of packing, eight a pack
  std::vector<PackGroup> groups_;
  std::vector<std::size_t> pack_first_;  ///< first slot of each pack
  std::vector<StopSlot> slots_;
  std::vector<Lanes> tof_s_, model_speed_mps_;  ///< values of each slot
  std::vector<StopPoses> poses_;                ///< poses of each pack, or empty
  std::vector<StopStates> states_, committed_;
  std::vector<double> beacon_table_, receiver_table_;
};

}  // namespace octant::calib
