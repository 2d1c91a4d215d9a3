// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/linearise.h"

namespace octant {

void RobustLoss::evaluate(double residual, double& rho, double& weight) const {
  const double s2 = residual * residual;
  const double scale = residual > 0 ? late_scale : early_scale;
  if (scale <= 0) {
    rho = s2;
    weight = 1.0;
    return;
  }
  const double c2 = scale * scale;
  rho = c2 * std::log1p(s2 / c2);
  weight = 1.0 / (1.0 + s2 / c2);
}

Pose pose_at(const Trajectory& t, std::size_t node, double alpha) {
  return alpha == 0.0 ? t.nodes[node].T_map_vehicle : interpolate(t.nodes[node].T_map_vehicle, t.nodes[node + 1].T_map_vehicle, alpha);
}

InterpolationJacobian interpolation_jacobian(const Trajectory& t, std::size_t node, double alpha) {
  InterpolationJacobian J;
  const int dof = pose_dof(t.motion);
  J.by_node.topLeftCorner(dof, dof).diagonal().setConstant(1.0 - alpha);
  J.by_next.topLeftCorner(dof, dof).diagonal().setConstant(alpha);
  if (t.motion == Motion::kPlanar || alpha == 0.0) return J;
  // R(alpha) = Ra Exp(alpha phi), phi = Log(Ra' Rb); d phi = Jr^-1(phi) db - Jr^-1(-phi) da.
  const Eigen::Vector3d phi =
      log_rotation(t.nodes[node].T_map_vehicle.rotation.conjugate() * t.nodes[node + 1].T_map_vehicle.rotation);
  const Eigen::Matrix3d part = alpha * right_jacobian(alpha * phi);
  J.by_next.bottomRightCorner<3, 3>() = part * right_jacobian_inverse(phi);
  J.by_node.bottomRightCorner<3, 3>() =
      exp_rotation(-alpha * phi).toRotationMatrix() - part * right_jacobian_inverse(-phi);
  return J;
}

namespace {

/// Spreads a derivative by the interpolated pose over the two nodes.
void set_pose_derivative(const Trajectory& t, double alpha, const InterpolationJacobian& J, const Eigen::Matrix<double, 1, 6>& by_pose,
                         ObservationRow& row) {
  const int dof = pose_dof(t.motion);
  row.by_node.setZero(t.block_size());
  row.by_node.head(dof) = (by_pose * J.by_node).head(dof);
  row.has_next = alpha != 0.0;
  row.by_next.setZero(t.block_size());
  if (row.has_next) row.by_next.head(dof) = (by_pose * J.by_next).head(dof);
}

}  // namespace

int arrival_rows(const Trajectory& t, std::size_t index, const SharedState& state, ObservationRow* rows) {
  const ArrivalObservation& a = t.arrivals[index];
  const Pose T = pose_at(t, a.node, a.alpha);
  PathInput in;
  in.T_map_vehicle = &T;
  in.p_beacon_map_m = state.beacon_p_map_m[a.beacon.index()];
  in.p_receiver_vehicle_m = state.receiver_p_vehicle_m[a.receiver.index()];
  in.speed_mps = a.model_speed_mps + state.speed_offset(t.run);
  in.delay_s = state.delay_s(a.beacon, a.receiver) + (a.two_way ? t.turnaround_s : 0.0);
  if (t.has_cycle_offset) in.delay_s += t.nodes[a.node].cycle_offset_s;
  in.attenuation = state.attenuation ? &*state.attenuation : nullptr;
  in.T_hear_send = a.two_way ? &a.T_hear_send : nullptr;
  const PathOutput out = predict_arrival(in, t.motion);
  const InterpolationJacobian J = interpolation_jacobian(t, a.node, a.alpha);

  ObservationRow& tof = rows[0];
  const double k = -1.0 / a.sigma_s;
  tof.kind = RowKind::kTof;
  tof.index = index;
  tof.node = a.node;
  tof.residual = (a.tof_s - out.tof_s) / a.sigma_s;
  set_pose_derivative(t, a.alpha, J, k * out.tof_by_pose, tof);
  if (t.has_cycle_offset) tof.by_node[pose_dof(t.motion)] = k / t.nominal_speed_mps;
  tof.has_shared = true;
  tof.beacon = a.beacon;
  tof.receiver = a.receiver;
  tof.by_beacon = k * out.tof_by_beacon;
  tof.by_receiver = k * out.tof_by_receiver;
  tof.by_attenuation = k * out.tof_by_attenuation;
  tof.by_delay = k;
  tof.by_speed = k * out.tof_by_speed;
  if (!(a.log_amplitude_sigma > 0) || !state.attenuation) return 1;

  ObservationRow& amplitude = rows[1];
  const double ka = -1.0 / a.log_amplitude_sigma;
  amplitude = tof;
  amplitude.kind = RowKind::kAmplitude;
  amplitude.residual = (a.log_amplitude - out.log_amplitude) / a.log_amplitude_sigma;
  set_pose_derivative(t, a.alpha, J, ka * out.log_amplitude_by_pose, amplitude);
  amplitude.by_beacon = ka * out.log_amplitude_by_beacon;
  amplitude.by_receiver = ka * out.log_amplitude_by_receiver;
  amplitude.by_attenuation = ka * out.log_amplitude_by_attenuation;
  amplitude.by_delay = 0.0;
  amplitude.by_speed = 0.0;
  return 2;
}

int bearing_rows(const Trajectory& t, std::size_t index, const SharedState& state, ObservationRow* rows) {
  const BearingObservation& b = t.bearings[index];
  if (!b.reflector.valid() || t.motion != Motion::kPlanar) return 0;
  const Pose T = pose_at(t, b.node, b.alpha);
  const BearingOutput out = predict_bearing(T, state.beacon_p_map_m[b.reflector.index()], Eigen::Vector3d::Zero());
  const double k = -1.0 / b.sigma_rad;
  ObservationRow& row = rows[0];
  row.kind = RowKind::kBearing;
  row.index = index;
  row.node = b.node;
  row.residual = wrap_angle(b.bearing_rad - out.bearing_rad) / b.sigma_rad;
  Eigen::Matrix<double, 1, 6> by_pose = Eigen::Matrix<double, 1, 6>::Zero();
  by_pose.head<3>() = k * out.by_pose;
  set_pose_derivative(t, b.alpha, interpolation_jacobian(t, b.node, b.alpha), by_pose, row);
  row.has_shared = true;
  row.beacon = b.reflector;
  row.receiver = ReceiverId();
  row.by_beacon = k * out.by_reflector;
  row.by_receiver.setZero();
  row.by_attenuation.setZero();
  row.by_delay = row.by_speed = 0.0;
  return 1;
}

int pose_rows(const Trajectory& t, std::size_t index, ObservationRow* rows) {
  const PoseObservation& p = t.poses[index];
  const Pose T = pose_at(t, p.node, p.alpha);
  const InterpolationJacobian J = interpolation_jacobian(t, p.node, p.alpha);
  int count = 0;
  auto add = [&](double misfit, double sigma, const Eigen::Matrix<double, 1, 6>& by_pose) {
    if (!std::isfinite(sigma)) return;
    ObservationRow& row = rows[count++];
    row.kind = RowKind::kPose;
    row.index = index;
    row.node = p.node;
    row.has_shared = false;
    row.residual = misfit / sigma;
    set_pose_derivative(t, p.alpha, J, by_pose / sigma, row);
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
    ObservationRow& row = rows[count++];
    row.kind = RowKind::kOdometry;
    row.index = index;
    row.node = o.node;
    row.has_next = true;
    row.has_shared = false;
    row.residual = misfit / sigma;
    row.by_node.setZero(block);
    row.by_next.setZero(block);
    return row;
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
    ObservationRow& row = add(wrap_angle(o.T_before_after.heading_rad() - wrap_angle(B.heading_rad() - A.heading_rad())), o.heading_sigma_rad);
    row.by_node[2] = kh;
    row.by_next[2] = -kh;
    return count;
  }
  // E = (Ra' Rb)' Ro; e = Log E; by b: -Jr^-1(-e); by a: +Jr^-1(-e) (Ra' Rb)'.
  const Eigen::Matrix3d Rab = Rt * B.rotation.toRotationMatrix();
  const Eigen::Vector3d e = log_rotation(Eigen::Quaterniond(Rab.transpose() * o.T_before_after.rotation.toRotationMatrix()));
  const Eigen::Matrix3d Jl = right_jacobian_inverse(-e);
  const Eigen::Matrix3d by_a = Jl * Rab.transpose();
  for (int i = 0; i < 3; ++i) {
    ObservationRow& row = add(e[i], o.heading_sigma_rad);
    row.by_node.segment(3, 3) = kh * by_a.row(i);
    row.by_next.segment(3, 3) = -kh * Jl.row(i);
  }
  return count;
}

void build_chain_system(const Trajectory& t, const Segment& segment, const SharedState& state, const RobustLoss& loss, ChainSystem& system) {
  const std::size_t count = segment.last_node - segment.first_node;
  const int n = t.block_size();
  system.cost = 0.0;
  system.D.assign(count, NodeBlock::Zero(n, n));
  system.U.assign(count, NodeBlock::Zero(n, n));
  system.g.assign(count, NodeVector::Zero(n));
  for_each_row(t, segment, state, [&](const ObservationRow& row) {
    double rho = row.residual * row.residual, w = 1.0;
    if (is_robust(row.kind)) loss.evaluate(row.residual, rho, w);
    system.cost += 0.5 * rho;
    const std::size_t k = row.node - segment.first_node;
    system.D[k].noalias() += w * row.by_node.transpose() * row.by_node;
    system.g[k].noalias() += w * row.residual * row.by_node.transpose();
    if (!row.has_next) return;
    system.D[k + 1].noalias() += w * row.by_next.transpose() * row.by_next;
    system.g[k + 1].noalias() += w * row.residual * row.by_next.transpose();
    system.U[k].noalias() += w * row.by_node.transpose() * row.by_next;
  });
}

double chain_cost(const Trajectory& t, const Segment& segment, const SharedState& state, const RobustLoss& loss) {
  double cost = 0.0;
  for_each_row(t, segment, state, [&](const ObservationRow& row) {
    double rho = row.residual * row.residual, w = 1.0;
    if (is_robust(row.kind)) loss.evaluate(row.residual, rho, w);
    cost += 0.5 * rho;
  });
  return cost;
}

double arrival_residual(const Trajectory& t, const ArrivalObservation& a, const SharedState& state) {
  ObservationRow rows[2];
  // The index is only carried through; rows are computed from the observation in the trajectory's list.
  const auto index = static_cast<std::size_t>(&a - t.arrivals.data());
  arrival_rows(t, index, state, rows);
  return rows[0].residual;
}

}  // namespace octant
