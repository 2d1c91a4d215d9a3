// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/shared_state.h"

namespace octant {

/// Vehicle state at one instant: the pose of a stationary epoch, or of a drive at the time of an odometry
/// row.
struct Node {
  double time_s = 0.0;
  std::int64_t epoch = kNoEpoch;
  Pose T_map_vehicle;
  double cycle_offset_s = 0.0;  ///< Clock::kCycleOffset only
  Eigen::Vector3d velocity =
      Eigen::Vector3d::Zero();  ///< map x, y [m/s] and turn rate [rad/s]; Trajectory::motion_prior only
  bool placed = false;          ///< false: no initial value yet
};

/// An arrival as an observation of the state between node and node + 1 (alpha = 0: of node alone).
struct ArrivalObservation {
  std::uint32_t node = 0;
  std::uint32_t arrival = 0;  ///< index into MeasurementLog::arrivals
  BeaconId beacon;
  ReceiverId receiver;
  double alpha = 0.0;
  double time_s = 0.0;
  double tof_s = 0.0;
  double sigma_s = 1.0;
  double model_speed_mps =
      0.0;                     ///< of the medium at the arrival's temperature, without the calibrated offset
  double log_amplitude = 0.0;  ///< ln(A / 1 V); used when log_amplitude_sigma > 0
  double log_amplitude_sigma = 0.0;
  bool two_way = false;
  Rejection rejection = Rejection::kUsed;  // beside the other byte: logs have millions of these
  std::int32_t hear_send = -1;             ///< two-way ranging: index into Trajectory::T_hear_send
  [[nodiscard]] double legs() const { return legs_of(two_way); }
};

struct BearingObservation {
  std::size_t node = 0;
  double alpha = 0.0;
  std::size_t bearing = 0;  ///< index into MeasurementLog::bearings
  BeaconId reflector;
  double bearing_rad = 0.0;
  double sigma_rad = 1.0;
  Rejection rejection = Rejection::kUsed;
};

/// A measured pose as an observation.
struct PoseObservation {
  std::size_t node = 0;
  double alpha = 0.0;
  Pose T_map_vehicle;
  double position_sigma_m = 0.01;
  double heading_sigma_rad = 0.01;   ///< infinite: heading unknown
  double attitude_sigma_rad = 0.01;  ///< spatial motion
};

/// Odometry between node and node + 1.
struct OdometryObservation {
  std::size_t node = 0;
  Pose T_before_after;
  double distance_sigma_m = 0.01;
  double heading_sigma_rad = 0.01;
};

/// What the motion prior says of node and node + 1, or (step_s = 0) of the velocity at a node.
struct MotionObservation {
  std::size_t node = 0;
  double step_s = 0.0;
};

/// States that hang together: one stationary epoch, or a stretch of a drive. Ranges [first, last) into the
/// lists of the Trajectory, each ordered by node.
struct Segment {
  std::size_t first_node = 0, last_node = 0;
  std::size_t first_arrival = 0, last_arrival = 0;
  std::size_t first_bearing = 0, last_bearing = 0;
  std::size_t first_pose = 0, last_pose = 0;
  std::size_t first_odometry = 0, last_odometry = 0;
  std::size_t first_motion = 0, last_motion = 0;
};

/// What the states of a vehicle in a run consist of.
struct StateSpace {
  std::size_t run = 0;  ///< index of the run
  VehicleId vehicle;
  Motion motion = Motion::kPlanar;
  bool has_cycle_offset = false;
  bool moving = false;                      ///< no epochs: states at odometry or arrival times
  double nominal_speed_mps = 343.0;         ///< turns cycle offsets into metres
  double turnaround_s = 0.0;                ///< of two-way ranging
  std::optional<MotionPrior> motion_prior;  ///< planar motion; states then carry their velocity

  /// Unknowns of a node: the pose's, then the cycle offset (in metres at the medium's speed) or the velocity
  /// where there is one.
  [[nodiscard]] int block_size() const {
    return pose_dof(motion) + (has_cycle_offset ? 1 : 0) + (motion_prior ? 3 : 0);
  }
};

/// All states of one vehicle in one run, with everything that was observed of them.
struct Trajectory : StateSpace {
  std::vector<Node> nodes;
  std::vector<Segment> segments;
  std::vector<ArrivalObservation> arrivals;
  std::vector<BearingObservation> bearings;
  std::vector<PoseObservation> poses;
  std::vector<OdometryObservation> odometry;
  std::vector<MotionObservation> motion_steps;
  /// Arrivals of the run that no state could carry (before the first odometry row, in a gap of the measured
  /// poses).
  std::vector<std::size_t> stateless_arrivals;
  std::vector<Pose>
      T_hear_send;  ///< two-way ranging: the pose when the vehicle asked in the frame of that when it heard
};

/// Calls visit(list, first, last) for each list of observations: the member of a trajectory that holds it,
/// and those of a segment that hold its range.
template <class Visit>
void for_each_list(Visit&& visit) {
  visit(&Trajectory::arrivals, &Segment::first_arrival, &Segment::last_arrival);
  visit(&Trajectory::bearings, &Segment::first_bearing, &Segment::last_bearing);
  visit(&Trajectory::poses, &Segment::first_pose, &Segment::last_pose);
  visit(&Trajectory::odometry, &Segment::first_odometry, &Segment::last_odometry);
  visit(&Trajectory::motion_steps, &Segment::first_motion, &Segment::last_motion);
}

/// Index of the first observation of a node or of one behind it, within [first, last) of a list.
template <class Observation>
[[nodiscard]] std::size_t first_of_node(const std::vector<Observation>& list, std::size_t node,
                                        std::size_t first, std::size_t last) {
  const auto begin = list.begin();
  const auto at = std::partition_point(begin + static_cast<std::ptrdiff_t>(first),
                                       begin + static_cast<std::ptrdiff_t>(last),
                                       [node](const Observation& o) { return o.node < node; });
  return static_cast<std::size_t>(at - begin);
}

/// The amplitude at which an arrival's walk is taken: the measured one of a directional receiver, as
/// PathInput has it. Far off its axis a receiver just hears, where the walk grows without bound: a pose must
/// not be told by how late that makes the pulse.
[[nodiscard]] inline std::optional<double> walk_amplitude(const ArrivalObservation& a,
                                                          const SharedState& state) {
  const bool measured = a.log_amplitude_sigma > 0 && state.attenuation && state.attenuation->directional();
  return measured ? std::optional<double>(a.log_amplitude) : std::nullopt;
}

/// Path of an arrival, but for the vehicle's pose and the offset of its cycle.
[[nodiscard]] inline PathInput path_of(const Trajectory& trajectory, const ArrivalObservation& a,
                                       const SharedState& state) {
  PathInput path =
      path_of(state, a.beacon, a.receiver, a.model_speed_mps + state.speed_offset(trajectory.run));
  if (a.two_way) {
    path.delay_s += trajectory.turnaround_s;
    path.T_hear_send = &trajectory.T_hear_send[static_cast<std::size_t>(a.hear_send)];
  }
  path.log_amplitude = walk_amplitude(a, state);
  return path;
}

/// What a trajectory needs to know of a site or a deployment.
struct TrajectoryModel {
  Motion motion = Motion::kPlanar;
  Medium medium;
  Timing timing;
  Noise noise;
  std::optional<AttenuationModel> attenuation{};  ///< with it logged amplitudes are observations
  /// Of each vehicle; used for drives with neither odometry nor measured poses, planar and without a cycle
  /// offset.
  std::vector<std::optional<MotionPrior>> motion_priors{};
};

/// What the states of a vehicle consist of in the model's own medium: of run 0, and standing.
[[nodiscard]] StateSpace state_space(VehicleId vehicle, const TrajectoryModel& model);

/// Every so many-th segment of a trajectory with what belongs to it.
[[nodiscard]] Trajectory some_segments(const Trajectory& trajectory, std::size_t stride);

/// Makes a trajectory of the one state of a standing vehicle, from the arrivals and bearings of one of its
/// epochs. What the trajectory held is overwritten, its memory is used again. Two-way ranging: the vehicle
/// stands.
void set_epoch(Trajectory& trajectory, std::span<const Arrival> arrivals, std::span<const Bearing> bearings,
               const TrajectoryModel& model);
/// The vehicle of a trajectory, standing at a node; what it observes there is to be added, and then the
/// segment of all that.
[[nodiscard]] Trajectory standing_at(const Trajectory& like, const Node& node);
/// One segment of all that a trajectory holds.
void set_only_segment(Trajectory& trajectory);
/// Takes the memory for epochs of that many rows.
void reserve_epoch(Trajectory& trajectory, std::size_t arrivals, std::size_t bearings);

/// An arrival as an observation of node 0, in a medium of that speed.
[[nodiscard]] ArrivalObservation observe(const Arrival& arrival, const TrajectoryModel& model,
                                         double model_speed_mps);
/// Speed of the model's medium at an arrival: at its own temperature where it brings one.
[[nodiscard]] double speed_of(const Arrival& arrival, const TrajectoryModel& model);

/// Measured pose at a time: linear and slerp between neighbours not further apart than max_gap_s; false
/// beyond the ends.
[[nodiscard]] bool interpolate_poses(const std::vector<TimedPose>& poses, double time_s, double max_gap_s,
                                     Pose& T_map_vehicle);

/// How far the residual of an arrival counts: Cauchy's loss with a scale for late and one for early arrivals,
/// in sigmas. Sound never arrives early, so echoes are forgiven sooner than arrivals from behind the wall.
struct RobustLoss {
  double late_scale = 0.0;  ///< 0: plain squares
  double early_scale = 0.0;
  /// rho(r^2) and its derivative by r^2, so that the cost is 1/2 rho and the weight rho'.
  void evaluate(double residual, double& rho, double& weight) const {
    const double s2 = residual * residual, scale = residual > 0 ? late_scale : early_scale;
    const double c2 = scale * scale;
    rho = scale > 0 ? c2 * std::log1p(s2 / c2) : s2;
    weight = scale > 0 ? 1.0 / (1.0 + s2 / c2) : 1.0;
  }
  /// Adds a residual's cost and returns its weight.
  [[nodiscard]] double weigh(double residual, double& cost) const {
    double rho = 0.0, weight = 1.0;
    evaluate(residual, rho, weight);
    cost += 0.5 * rho;
    return weight;
  }
};

/// Outcome of solving for the states of one segment for given shared parameters.
struct StateSolveResult {
  bool converged = false;
  int iterations = 0;
  double cost = 0.0;      ///< 1/2 sum of rho
  bool singular = false;  ///< the observations do not determine the states
};

/// Gauss-Newton (Levenberg-Marquardt) on the states of one segment, shared parameters held: a
/// block-tridiagonal system. Writes nodes[first_node, last_node) of the trajectory.
StateSolveResult solve_states(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                              const RobustLoss& loss, int max_iterations = 30);

/// Covariance of a node's state, in a room of its own.
using StateCovariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 7, 7>;

/// Covariance of one node's state (block_size x block_size) within its segment, all else marginalised, shared
/// parameters held. Empty if singular.
[[nodiscard]] StateCovariance node_covariance(const Trajectory& trajectory, const Segment& segment,
                                              std::size_t node, const SharedState& state);

/// Whitened residual (observed - predicted) / sigma of an arrival's time of flight at the trajectory's
/// states.
[[nodiscard]] double arrival_residual(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                      const SharedState& state);

}  // namespace octant
