// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/linearise.h"

#include <numbers>

#include "models/trajectory/planar.h"

namespace octant {

Pose pose_at(const Trajectory& t, std::size_t node, double alpha) {
  return alpha == 0.0 ? t.nodes[node].T_map_vehicle
                      : interpolate(t.nodes[node].T_map_vehicle, t.nodes[node + 1].T_map_vehicle, alpha);
}

namespace {

/// Returns true if a pose between two nodes depends on them linearly.
bool is_linear(const Trajectory& t, double alpha) { return t.motion == Motion::kPlanar || alpha == 0.0; }

/// Distributes a derivative by the pose at an instant to the two nodes.
void spread(const Trajectory& t, const InstantPose& at, const Eigen::Matrix<double, 1, 6>& by_pose,
            ObservationRow& row) {
  const int dof = pose_dof(t.motion), block = t.block_size();
  const double alpha = at.alpha;
  row.by_node.setZero(block);
  row.by_next.setZero(block);
  row.has_next = alpha != 0.0;
  if (is_linear(t, alpha)) {
    row.by_node.head(dof) = (1.0 - alpha) * by_pose.head(dof);
    if (row.has_next) row.by_next.head(dof) = alpha * by_pose.head(dof);
    return;
  }
  row.by_node.head<3>() = (1.0 - alpha) * by_pose.head<3>();
  row.by_next.head<3>() = alpha * by_pose.head<3>();
  row.by_node.segment<3>(3) = by_pose.tail<3>() * at.turn_by_node;
  row.by_next.segment<3>(3) = by_pose.tail<3>() * at.turn_by_next;
}

}  // namespace

void InstantPose::set(const Trajectory& t, std::size_t node, double new_alpha) {
  const Pose& A = t.nodes[node].T_map_vehicle;
  alpha = new_alpha;
  if (is_linear(t, alpha)) {
    T_map_vehicle = pose_at(t, node, alpha);
    return;
  }
  const Pose& B = t.nodes[node + 1].T_map_vehicle;
  if (node != node_) {
    node_ = node;
    phi_ = log_rotation(A.rotation.conjugate() * B.rotation);
    by_b_ = right_jacobian_inverse(phi_);
    by_a_ = right_jacobian_inverse(-phi_);
  }
  // R(alpha) = Ra Exp(alpha phi)
  const Eigen::Quaterniond turn = exp_rotation(alpha * phi_);
  T_map_vehicle = {(1 - alpha) * A.translation_m + alpha * B.translation_m, A.rotation * turn};
  const Eigen::Matrix3d part = alpha * right_jacobian(alpha * phi_);
  turn_by_next = part * by_b_;
  turn_by_node = turn.conjugate().toRotationMatrix() - part * by_a_;
}

namespace {

PathInput path_at(const Trajectory& t, const ArrivalObservation& a, const SharedState& state, const Pose& T) {
  PathInput in = path_of(t, a, state);
  in.T_map_vehicle = &T;
  if (t.has_cycle_offset)
    in.delay_s +=
        t.nodes[a.node].cycle_offset_s + state.drift(t.vehicle) * (a.time_s - t.nodes[a.node].time_s);
  return in;
}

}  // namespace

int arrival_rows(const Trajectory& t, std::size_t index, const SharedState& state, InstantPose& at,
                 ObservationRow* rows) {
  const ArrivalObservation& a = t.arrivals[index];
  at.set(t, a.node, a.alpha);
  const PathInput in = path_at(t, a, state, at.T_map_vehicle);
  const PathOutput out = predict_arrival(in, t.motion);

  ObservationRow& tof = rows[0];
  const double k = -1.0 / a.sigma_s;
  tof.kind = RowKind::kTof;
  tof.index = index;
  tof.node = a.node;
  tof.residual = (a.tof_s - out.tof_s) / a.sigma_s;
  spread(t, at, k * out.tof_by_pose, tof);
  if (t.has_cycle_offset) tof.by_node[pose_dof(t.motion)] = k / t.nominal_speed_mps;
  tof.has_shared = true;
  tof.beacon = a.beacon;
  tof.receiver = a.receiver;
  tof.by_beacon = k * out.tof_by_beacon;
  tof.by_receiver = k * out.tof_by_receiver;
  tof.by_attenuation = k * out.tof_by_attenuation;
  tof.by(kByDelay) = k;
  tof.by(kBySpeed) = k * out.tof_by_speed;
  tof.by(kByDrift) = t.has_cycle_offset ? k * (a.time_s - t.nodes[a.node].time_s) : 0.0;
  if (!(a.log_amplitude_sigma > 0) || !state.attenuation) return 1;

  ObservationRow& amplitude = rows[1];
  const double ka = -1.0 / a.log_amplitude_sigma;
  amplitude = tof;
  amplitude.kind = RowKind::kAmplitude;
  amplitude.residual = (a.log_amplitude - out.log_amplitude) / a.log_amplitude_sigma;
  spread(t, at, ka * out.log_amplitude_by_pose, amplitude);
  amplitude.by_beacon = ka * out.log_amplitude_by_beacon;
  amplitude.by_receiver = ka * out.log_amplitude_by_receiver;
  amplitude.by_attenuation = ka * out.log_amplitude_by_attenuation;
  amplitude.by_time_alone = {};
  return 2;
}

int bearing_rows(const Trajectory& t, std::size_t index, const SharedState& state, ObservationRow* rows) {
  const BearingObservation& b = t.bearings[index];
  if (!b.reflector.valid() || t.motion != Motion::kPlanar) return 0;
  InstantPose at;
  at.set(t, b.node, b.alpha);
  const BearingOutput out =
      predict_bearing(at.T_map_vehicle, state.beacon_p_map_m[b.reflector.index()], Eigen::Vector3d::Zero());
  const double k = -1.0 / b.sigma_rad;
  ObservationRow& row = rows[0];
  row.kind = RowKind::kBearing;
  row.index = index;
  row.node = b.node;
  row.residual = wrap_angle(b.bearing_rad - out.bearing_rad) / b.sigma_rad;
  Eigen::Matrix<double, 1, 6> by_pose = Eigen::Matrix<double, 1, 6>::Zero();
  by_pose.head<3>() = k * out.by_pose;
  spread(t, at, by_pose, row);
  row.has_shared = true;
  row.beacon = b.reflector;
  row.receiver = ReceiverId();
  row.by_beacon = k * out.by_reflector;
  row.by_receiver.setZero();
  row.by_attenuation.setZero();
  row.by_time_alone = {};
  return 1;
}

namespace {

/// Begins a row that depends on states only.
ObservationRow& begin_row(RowKind kind, std::size_t index, std::size_t node, bool has_next, double residual,
                          int block, ObservationRow& row) {
  row.kind = kind;
  row.index = index;
  row.node = node;
  row.has_next = has_next;
  row.has_shared = false;
  row.residual = residual;
  row.by_node.setZero(block);
  row.by_next.setZero(block);
  return row;
}

}  // namespace

int pose_rows(const Trajectory& t, std::size_t index, ObservationRow* rows) {
  const PoseObservation& p = t.poses[index];
  InstantPose at;
  at.set(t, p.node, p.alpha);
  const Pose& T = at.T_map_vehicle;
  int count = 0;
  const int block = t.block_size();
  auto add = [&](double misfit, double sigma, const Eigen::Matrix<double, 1, 6>& by_pose) {
    if (!std::isfinite(sigma)) return;
    spread(t, at, by_pose / sigma,
           begin_row(RowKind::kPose, index, p.node, false, misfit / sigma, block, rows[count++]));
  };
  using Row6 = Eigen::Matrix<double, 1, 6>;
  const Eigen::Vector3d off = p.T_map_vehicle.translation_m - T.translation_m;
  if (t.motion == Motion::kPlanar) {
    add(off.x(), p.position_sigma_m, -Row6::Unit(0));
    add(off.y(), p.position_sigma_m, -Row6::Unit(1));
    add(wrap_angle(p.T_map_vehicle.heading_rad() - T.heading_rad()), p.heading_sigma_rad, -Row6::Unit(2));
    return count;
  }
  for (int i = 0; i < 3; ++i) add(off[i], p.position_sigma_m, -Row6::Unit(i));
  const Eigen::Vector3d e = log_rotation(T.rotation.conjugate() * p.T_map_vehicle.rotation);
  const Eigen::Matrix3d by_rotation = -right_jacobian_inverse(-e);
  for (int i = 0; i < 3; ++i) {
    Row6 row = Row6::Zero();
    row.tail<3>() = by_rotation.row(i);
    add(e[i], i == 2 ? p.heading_sigma_rad : p.attitude_sigma_rad, row);
  }
  return count;
}

int odometry_rows(const Trajectory& t, std::size_t index, ObservationRow* rows) {
  const OdometryObservation& o = t.odometry[index];
  const Pose& A = t.nodes[o.node].T_map_vehicle;
  const Pose& B = t.nodes[o.node + 1].T_map_vehicle;
  const Eigen::Matrix3d Rt = A.rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d step = Rt * (B.translation_m - A.translation_m);
  const int dof = pose_dof(t.motion);
  const int block = t.block_size();
  int count = 0;
  auto add = [&](double misfit, double sigma) -> ObservationRow& {
    return begin_row(RowKind::kOdometry, index, o.node, true, misfit / sigma, block, rows[count++]);
  };
  const Eigen::Vector3d off = o.T_before_after.translation_m - step;
  const double kd = 1.0 / o.distance_sigma_m, kh = 1.0 / o.heading_sigma_rad;
  const Eigen::Matrix3d by_turn = skew(step);  // d(R' v) by a body rotation of A
  const int dims = dof == 3 ? 2 : 3;
  for (int i = 0; i < dims; ++i) {
    ObservationRow& row = add(off[i], o.distance_sigma_m);
    row.by_node.head(dims) = kd * Rt.row(i).head(dims);
    row.by_next.head(dims) = -kd * Rt.row(i).head(dims);
    if (dof == 3) {
      row.by_node[2] = -kd * by_turn(i, 2);
    } else {
      row.by_node.segment(3, 3) = -kd * by_turn.row(i);
    }
  }
  if (dof == 3) {
    ObservationRow& row =
        add(wrap_angle(o.T_before_after.heading_rad() - wrap_angle(B.heading_rad() - A.heading_rad())),
            o.heading_sigma_rad);
    row.by_node[2] = kh;
    row.by_next[2] = -kh;
    return count;
  }
  // E = (Ra' Rb)' Ro; e = Log E; by b: -Jr^-1(-e); by a: +Jr^-1(-e) (Ra' Rb)'.
  const Eigen::Matrix3d Rab = Rt * B.rotation.toRotationMatrix();
  const Eigen::Vector3d e =
      log_rotation(Eigen::Quaterniond(Rab.transpose() * o.T_before_after.rotation.toRotationMatrix()));
  const Eigen::Matrix3d Jl = right_jacobian_inverse(-e);
  const Eigen::Matrix3d by_a = Jl * Rab.transpose();
  for (int i = 0; i < 3; ++i) {
    ObservationRow& row = add(e[i], o.heading_sigma_rad);
    row.by_node.segment(3, 3) = kh * by_a.row(i);
    row.by_next.segment(3, 3) = -kh * Jl.row(i);
  }
  return count;
}

/// White-noise acceleration (Bar-Shalom, Li and Kirubarajan 2001, section 6.2). With its density q, over a
/// step of length h,
///   Q = q [h^3/3 h^2/2; h^2/2 h]; rows are whitened by Q = L L', L = sqrt(q) [sqrt(h^3/3) 0; sqrt(3 h)/2
///   sqrt(h)/2].
int motion_rows(const Trajectory& t, std::size_t index, ObservationRow* rows) {
  const MotionObservation& m = t.motion_steps[index];
  const MotionPrior& prior = *t.motion_prior;
  const int dof = pose_dof(t.motion), block = t.block_size();
  const Node& A = t.nodes[m.node];
  int count = 0;
  const auto add = [&](double residual) -> ObservationRow& {
    return begin_row(RowKind::kMotion, index, m.node, m.step_s > 0, residual, block, rows[count++]);
  };
  // Prior of an unknown heading: uniform on the circle. The residual is zero, because no direction is
  // preferred.
  if (m.step_s <= 0) add(0.0).by_node[2] = 1.0 / std::numbers::pi;
  for (int i = 0; i < 3; ++i) {
    const bool turn = i == 2;
    if (m.step_s <= 0) {
      const double k = 1.0 / (turn ? prior.turn_rate_rad_per_s : prior.speed_mps);
      add(-k * A.velocity[i]).by_node[dof + i] = -k;
      continue;
    }
    const Node& B = t.nodes[m.node + 1];
    const double h = m.step_s;
    const double root_q = turn ? prior.turn_acceleration_rad_per_s2 : prior.acceleration_mps2;
    const double moved = turn ? wrap_angle(B.T_map_vehicle.heading_rad() - A.T_map_vehicle.heading_rad())
                              : B.T_map_vehicle.translation_m[i] - A.T_map_vehicle.translation_m[i];
    const double misfit =
        h * A.velocity[i] - moved;  // predicted minus state, so that the residual is observed minus predicted
    const double change = A.velocity[i] - B.velocity[i];
    const double a = std::sqrt(3 / (h * h * h)) / root_q;  // L^-1 = [a 0; -b c]
    const double c = 2 / (std::sqrt(h) * root_q), b = c * 3 / (2 * h);
    ObservationRow& place = add(a * misfit);
    place.by_node[i] = a;
    place.by_node[dof + i] = a * h;
    place.by_next[i] = -a;
    ObservationRow& velocity = add(c * change - b * misfit);
    velocity.by_node[i] = -b;
    velocity.by_node[dof + i] = c - b * h;
    velocity.by_next[i] = b;
    velocity.by_next[dof + i] = -c;
  }
  return count;
}

void ChainSystem::clear(std::size_t count, int n) {
  cost = 0.0;
  D.assign(count, NodeBlock::Zero(n, n));
  U.assign(count, NodeBlock::Zero(n, n));
  g.assign(count, NodeVector::Zero(n));
}

void ChainSystem::add(const ObservationRow& row, std::size_t first_node, const RobustLoss& loss) {
  const double w = weigh(row, loss, cost);
  const std::size_t k = row.node - first_node;
  D[k].noalias() += w * row.by_node.transpose() * row.by_node;
  g[k].noalias() += w * row.residual * row.by_node.transpose();
  if (!row.has_next) return;
  D[k + 1].noalias() += w * row.by_next.transpose() * row.by_next;
  g[k + 1].noalias() += w * row.residual * row.by_next.transpose();
  U[k].noalias() += w * row.by_node.transpose() * row.by_next;
}

void build_chain_system(const Trajectory& t, const Segment& segment, const SharedState& state,
                        const RobustLoss& loss, ChainSystem& system) {
  system.clear(segment.last_node - segment.first_node, t.block_size());
  for_each_row(t, segment, state,
               [&](const ObservationRow& row) { system.add(row, segment.first_node, loss); });
}

double chain_cost(const Trajectory& t, const Segment& segment, const SharedState& state,
                  const RobustLoss& loss) {
  double cost = 0.0;
  for_each_row(t, segment, state,
               [&](const ObservationRow& row) { static_cast<void>(weigh(row, loss, cost)); });
  return cost;
}

namespace {

/// Fast path for plain arrivals, the most frequent kind: the first term of the measurement equation.
double plain_residual(const ArrivalObservation& a, const Eigen::Vector3d& p_receiver_map_m,
                      const SharedState& state, double speed_offset_mps) {
  const double distance_m = (p_receiver_map_m - state.beacon_p_map_m[a.beacon.index()]).norm();
  const double tof_s =
      distance_m / (a.model_speed_mps + speed_offset_mps) + state.delay_s(a.beacon, a.receiver);
  return (a.tof_s - tof_s) / a.sigma_s;
}

}  // namespace

double arrival_residual(const Trajectory& t, const ArrivalObservation& a, const SharedState& state) {
  const bool plain = state.has_plain_paths() && !a.two_way && !t.has_cycle_offset;
  if (plain && a.alpha != 0.0 && t.motion == Motion::kPlanar) {
    ArrivalWhitening whitening(state.speed_offset(t.run));
    whitening.set(a);
    const PlanarNode from(t.nodes[a.node].T_map_vehicle), to(t.nodes[a.node + 1].T_map_vehicle);
    return PlanarArrival(a, PlanarInterval(from, to).at(a.alpha), state, whitening).residual;
  }
  const Pose T = pose_at(t, a.node, a.alpha);
  if (!plain) return (a.tof_s - predict_arrival_value(path_at(t, a, state, T)).tof_s) / a.sigma_s;
  return plain_residual(a, T * state.receiver_p_vehicle_m[a.receiver.index()], state,
                        state.speed_offset(t.run));
}

double ArrivalResiduals::operator()(const ArrivalObservation& a) {
  if (!is_plain_ || a.two_way || a.alpha != 0.0) return arrival_residual(*t_, a, *state_);
  if (a.node != node_) {
    node_ = a.node;
    const Pose& T = t_->nodes[node_].T_map_vehicle;
    R_map_vehicle_ = T.rotation.toRotationMatrix();
    p_map_m_ = T.translation_m;
  }
  const Eigen::Vector3d& p_vehicle_m = state_->receiver_p_vehicle_m[a.receiver.index()];
  return plain_residual(a, R_map_vehicle_ * p_vehicle_m + p_map_m_, *state_, speed_offset_mps_);
}

}  // namespace octant
