// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "models/physics/measurement.h"
#include "models/support/scratch.h"
#include "models/trajectory/trajectory.h"

namespace octant {

inline constexpr int kMaxBlock = 7;  ///< spatial pose and cycle offset
using NodeRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxBlock>;
using NodeVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxBlock, 1>;
using NodeBlock =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxBlock, kMaxBlock>;

enum class RowKind { kTof, kAmplitude, kBearing, kPose, kOdometry, kMotion };

/// One scalar observation, whitened: residual = (observed - predicted) / sigma, with its derivatives by the
/// states it depends on and by the shared parameters. Blocks that do not apply are zero and flagged.
struct ObservationRow {
  RowKind kind = RowKind::kTof;
  std::size_t index = 0;  ///< index into the trajectory's list of its kind
  double residual = 0.0;
  std::size_t node = 0;
  bool has_next = false;  ///< true if it depends on node + 1 too
  NodeRow by_node, by_next;
  bool has_shared = false;
  BeaconId beacon;
  ReceiverId receiver;
  Eigen::RowVector3d by_beacon, by_receiver;  ///< per metre
  AttenuationRow by_attenuation;              ///< per unit
  /// Derivatives by the parameters from kByDelay on, per SI unit.
  std::array<double, kPathNumbers - kByDelay> by_time_alone{};

  [[nodiscard]] double by(PathNumber what) const { return by_time_alone[what - kByDelay]; }
  [[nodiscard]] double& by(PathNumber what) { return by_time_alone[what - kByDelay]; }
};

/// Pose at an observation between node and node + 1.
[[nodiscard]] Pose pose_at(const Trajectory& trajectory, std::size_t node, double alpha);

/// Pose at an instant between two nodes and its derivatives by both. Reuse it for consecutive observations
/// while no node moves: observations within one odometry step share the rotation of that step.
class InstantPose {
 public:
  void set(const Trajectory& trajectory, std::size_t node, double alpha);

  double alpha = 0.0;
  Pose T_map_vehicle;
  /// Derivative of the rotation by that of either node, in space; in the plane the pose depends on both nodes
  /// linearly.
  Eigen::Matrix3d turn_by_node, turn_by_next;

 private:
  std::size_t node_ = SIZE_MAX;
  Eigen::Vector3d phi_;          ///< Log(Ra' Rb)
  Eigen::Matrix3d by_a_, by_b_;  ///< Jr^-1(-phi), Jr^-1(phi): d phi = by_b db - by_a da
};

/// Computes arrival_residual() for many arrivals. Consecutive arrivals of a state share its rotation. Nodes
/// and shared state must not change meanwhile.
class ArrivalResiduals {
 public:
  ArrivalResiduals(const Trajectory& trajectory, const SharedState& state)
      : t_(&trajectory),
        state_(&state),
        is_plain_(state.has_plain_paths() && !trajectory.has_cycle_offset),
        speed_offset_mps_(state.speed_offset(trajectory.run)) {}
  [[nodiscard]] double operator()(const ArrivalObservation& arrival);

 private:
  const Trajectory* t_;
  const SharedState* state_;
  bool is_plain_;
  double speed_offset_mps_;
  std::size_t node_ = SIZE_MAX;
  Eigen::Matrix3d R_map_vehicle_;
  Eigen::Vector3d p_map_m_;
};

/// Fill the whitened rows of one observation and return their number: up to 2 for an arrival, 1 for a
/// bearing, 6 for a pose, an odometry step or a motion step. `rows` must have room for them.
/// @param at  instant of the previous arrival, or empty
int arrival_rows(const Trajectory& trajectory, std::size_t index, const SharedState& state, InstantPose& at,
                 ObservationRow* rows);
inline int arrival_rows(const Trajectory& trajectory, std::size_t index, const SharedState& state,
                        ObservationRow* rows) {
  InstantPose at;
  return arrival_rows(trajectory, index, state, at, rows);
}
int bearing_rows(const Trajectory& trajectory, std::size_t index, const SharedState& state,
                 ObservationRow* rows);
int pose_rows(const Trajectory& trajectory, std::size_t index, ObservationRow* rows);
int odometry_rows(const Trajectory& trajectory, std::size_t index, ObservationRow* rows);
int motion_rows(const Trajectory& trajectory, std::size_t index, ObservationRow* rows);

/// Calls visit(row) for every row of the segment in use; rejected arrivals and bearings are skipped.
template <class Visitor>
void for_each_row(const Trajectory& trajectory, const Segment& segment, const SharedState& state,
                  Visitor&& visit) {
  ObservationRow rows[6];
  auto emit = [&](int count) {
    for (int i = 0; i < count; ++i) visit(rows[i]);
  };
  InstantPose at;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i)
    if (trajectory.arrivals[i].rejection == Rejection::kUsed)
      emit(arrival_rows(trajectory, i, state, at, rows));
  for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i)
    if (trajectory.bearings[i].rejection == Rejection::kUsed) emit(bearing_rows(trajectory, i, state, rows));
  for (std::size_t i = segment.first_pose; i < segment.last_pose; ++i) emit(pose_rows(trajectory, i, rows));
  for (std::size_t i = segment.first_odometry; i < segment.last_odometry; ++i)
    emit(odometry_rows(trajectory, i, rows));
  for (std::size_t i = segment.first_motion; i < segment.last_motion; ++i)
    emit(motion_rows(trajectory, i, rows));
}

/// The robust loss applies to arrivals and bearings, not to odometry and measured poses.
[[nodiscard]] inline bool is_robust(RowKind kind) {
  return kind == RowKind::kTof || kind == RowKind::kAmplitude || kind == RowKind::kBearing;
}

/// Adds the cost of a row and returns its weight.
[[nodiscard]] inline double weigh(const ObservationRow& row, const RobustLoss& loss, double& cost) {
  return (is_robust(row.kind) ? loss : RobustLoss{}).weigh(row.residual, cost);
}

/// Weighted sum of squares of a segment and its Gauss-Newton system in the states. The system is
/// block-tridiagonal: diagonal blocks D, coupling U to the next node, gradient g.
struct ChainSystem {
  double cost = 0.0;
  std::pmr::vector<NodeBlock> D{scratch()}, U{scratch()};
  std::pmr::vector<NodeVector> g{scratch()};

  /// Resizes and sets to zero for `count` states of n unknowns.
  void clear(std::size_t count, int n);
  /// @param first_node  node of the first block
  void add(const ObservationRow& row, std::size_t first_node, const RobustLoss& loss);
};
void build_chain_system(const Trajectory& trajectory, const Segment& segment, const SharedState& state,
                        const RobustLoss& loss, ChainSystem& system);
[[nodiscard]] double chain_cost(const Trajectory& trajectory, const Segment& segment,
                                const SharedState& state, const RobustLoss& loss);

}  // namespace octant
