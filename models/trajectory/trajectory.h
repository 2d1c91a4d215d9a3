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
#include "models/physics/pose.h"
#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/shared_state.h"

namespace octant {

/// Vehicle state at one instant: pose of a stationary epoch, or of a drive at the time of an odometry row.
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
      0.0;  ///< speed of the medium at the arrival's temperature, without the calibrated offset
  double log_amplitude = 0.0;  ///< ln(A / 1 V); used when log_amplitude_sigma > 0
  double log_amplitude_sigma = 0.0;
  bool two_way = false;
  Rejection rejection =
      Rejection::kUsed;         // next to the other byte to save memory: logs have millions of these
  std::int32_t hear_send = -1;  ///< two-way ranging: index into Trajectory::T_hear_send
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

/// Constraint of the motion prior between node and node + 1, or (step_s = 0) on the velocity of a node.
struct MotionObservation {
  std::size_t node = 0;
  double step_s = 0.0;
};

/// States that are linked with each other: one stationary epoch, or a part of a drive. Ranges [first, last)
/// into the lists of the Trajectory, each ordered by node.
struct Segment {
  std::size_t first_node = 0, last_node = 0;
  std::size_t first_arrival = 0, last_arrival = 0;
  std::size_t first_bearing = 0, last_bearing = 0;
  std::size_t first_pose = 0, last_pose = 0;
  std::size_t first_odometry = 0, last_odometry = 0;
  std::size_t first_motion = 0, last_motion = 0;
};

/// Composition of the states of a vehicle in a run.
struct StateSpace {
  std::size_t run = 0;  ///< index of the run
  VehicleId vehicle;
  Motion motion = Motion::kPlanar;
  bool has_cycle_offset = false;
  bool moving = false;                      ///< no epochs: states at odometry or arrival times
  double nominal_speed_mps = 343.0;         ///< converts cycle offsets into metres
  double turnaround_s = 0.0;                ///< two-way ranging only
  std::optional<MotionPrior> motion_prior;  ///< planar motion; states then carry their velocity

  /// Number of unknowns of a node: those of the pose, then the cycle offset (in metres at the medium's speed)
  /// or the velocity if there is one.
  [[nodiscard]] int block_size() const {
    return pose_dof(motion) + (has_cycle_offset ? 1 : 0) + (motion_prior ? 3 : 0);
  }
};

/// All states of one vehicle in one run, with the observations of them.
struct Trajectory : StateSpace {
  std::vector<Node> nodes;
  std::vector<Segment> segments;
  std::vector<ArrivalObservation> arrivals;
  std::vector<BearingObservation> bearings;
  std::vector<PoseObservation> poses;
  std::vector<OdometryObservation> odometry;
  std::vector<MotionObservation> motion_steps;
  /// Arrivals without a state: before the first odometry row, or in a gap of the measured poses.
  std::vector<std::size_t> stateless_arrivals;
  std::vector<Pose>
      T_hear_send;  ///< two-way ranging: pose at the request in the frame of the pose at reception
};

/// Calls visit(list, first, last) for each list of observations: the member of a trajectory that contains it,
/// and the members of a segment that contain its range.
template <class Visit>
void for_each_list(Visit&& visit) {
  visit(&Trajectory::arrivals, &Segment::first_arrival, &Segment::last_arrival);
  visit(&Trajectory::bearings, &Segment::first_bearing, &Segment::last_bearing);
  visit(&Trajectory::poses, &Segment::first_pose, &Segment::last_pose);
  visit(&Trajectory::odometry, &Segment::first_odometry, &Segment::last_odometry);
  visit(&Trajectory::motion_steps, &Segment::first_motion, &Segment::last_motion);
}

/// Index of the first observation of this node or a later one, within [first, last) of a list.
template <class Observation>
[[nodiscard]] std::size_t first_of_node(const std::vector<Observation>& list, std::size_t node,
                                        std::size_t first, std::size_t last) {
  const auto begin = list.begin();
  const auto at = std::partition_point(begin + static_cast<std::ptrdiff_t>(first),
                                       begin + static_cast<std::ptrdiff_t>(last),
                                       [node](const Observation& o) { return o.node < node; });
  return static_cast<std::size_t>(at - begin);
}

/// Amplitude from which the walk of an arrival is computed: the measured one for a directional receiver. Far
/// off its axis the walk grows without bound at the threshold, and the lateness of such a pulse must not
/// determine the pose.
[[nodiscard]] inline std::optional<double> walk_amplitude(const ArrivalObservation& a,
                                                          const SharedState& state) {
  const bool measured = a.log_amplitude_sigma > 0 && state.attenuation && state.attenuation->directional();
  return measured ? std::optional<double>(a.log_amplitude) : std::nullopt;
}

/// Path of an arrival, except for the vehicle's pose and cycle offset.
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

/// Properties of a site or a deployment that a trajectory depends on.
struct TrajectoryModel {
  Motion motion = Motion::kPlanar;
  Medium medium;
  Timing timing;
  Noise noise;
  std::optional<AttenuationModel> attenuation{};  ///< if given, logged amplitudes are observations
  /// Motion prior of each vehicle. Used for planar drives with neither odometry nor measured poses nor a
  /// cycle offset.
  std::vector<std::optional<MotionPrior>> motion_priors{};
};

/// Composition of the states of a vehicle at rest in run 0, in the medium of the model.
[[nodiscard]] StateSpace state_space(VehicleId vehicle, const TrajectoryModel& model);

/// Every `stride`-th segment of a trajectory with its observations.
[[nodiscard]] Trajectory some_segments(const Trajectory& trajectory, std::size_t stride);

/// Turns a trajectory into the single state of a vehicle at rest, from the arrivals and bearings of one of
/// its epochs. The previous contents are overwritten and their memory is reused.
void set_epoch(Trajectory& trajectory, std::span<const Arrival> arrivals, std::span<const Bearing> bearings,
               const TrajectoryModel& model);
/// A trajectory with one node and no observations, for a vehicle at rest. Call set_only_segment() after
/// adding observations.
[[nodiscard]] Trajectory standing_at(const Trajectory& like, const Node& node);
/// Makes one segment of everything in a trajectory.
void set_only_segment(Trajectory& trajectory);
/// Reserves memory for epochs with the given numbers of rows.
void reserve_epoch(Trajectory& trajectory, std::size_t arrivals, std::size_t bearings);

/// Converts an arrival into an observation of node 0, for a given speed of the medium.
[[nodiscard]] ArrivalObservation observe(const Arrival& arrival, const TrajectoryModel& model,
                                         double model_speed_mps);
/// Speed of the model's medium at the temperature of an arrival, if it has one, else of the site.
[[nodiscard]] double speed_of(const Arrival& arrival, const TrajectoryModel& model);

/// Measured pose at a time, by linear and spherical interpolation between neighbours at most max_gap_s apart;
/// false outside the measured time span.
[[nodiscard]] bool interpolate_poses(const std::vector<TimedPose>& poses, double time_s, double max_gap_s,
                                     Pose& T_map_vehicle);

/// Moves a state by a step in its unknowns (Trajectory::block_size() of them): pose in its own frame, then
/// cycle offset [m, at the medium's nominal speed] or velocity.
/// @param like  a trajectory with states of the same kind
template <class Step>
void step_node(const Trajectory& like, const Step& step, Node& node) {
  const int dof = pose_dof(like.motion);
  node.T_map_vehicle = retract(node.T_map_vehicle, step.head(dof), like.motion);
  if (like.has_cycle_offset) node.cycle_offset_s += step[dof] / like.nominal_speed_mps;
  if (like.motion_prior) node.velocity += step.template tail<3>();
}

/// Robust loss of an arrival's residual: Cauchy's loss with separate scales for late and early arrivals, in
/// sigmas. Sound never arrives early, so late outliers are down-weighted sooner.
struct RobustLoss {
  double late_scale = 0.0;  ///< 0: squared loss
  double early_scale = 0.0;
  /// Returns rho(r^2) and its derivative by r^2. The cost is rho / 2 and the weight rho'.
  void evaluate(double residual, double& rho, double& weight) const {
    const double s2 = residual * residual, scale = residual > 0 ? late_scale : early_scale;
    const double c2 = scale * scale;
    rho = scale > 0 ? c2 * std::log1p(s2 / c2) : s2;
    weight = scale > 0 ? 1.0 / (1.0 + s2 / c2) : 1.0;
  }
  /// Adds the cost of a residual and returns its weight.
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

/// Solves for the states of one segment with fixed shared parameters, by Levenberg-Marquardt on a
/// block-tridiagonal system. Writes nodes[first_node, last_node) of the trajectory.
StateSolveResult solve_states(Trajectory& trajectory, const Segment& segment, const SharedState& state,
                              const RobustLoss& loss, int max_iterations = 30);

/// Covariance of the state of a node, with fixed capacity.
using StateCovariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 7, 7>;

/// Covariance of the state of one node (block_size x block_size) within its segment, with all other states
/// marginalised and the shared parameters fixed. Empty if singular.
[[nodiscard]] StateCovariance node_covariance(const Trajectory& trajectory, const Segment& segment,
                                              std::size_t node, const SharedState& state);

/// Whitened residual (observed - predicted) / sigma of an arrival's time of flight at the trajectory's
/// states.
[[nodiscard]] double arrival_residual(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                      const SharedState& state);

}  // namespace octant
