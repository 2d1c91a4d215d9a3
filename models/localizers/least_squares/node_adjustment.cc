// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/node_adjustment.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "models/trajectory/planar.h"
#include "models/trajectory/trajectory.h"

namespace octant {
namespace {

constexpr double kReadmitShare = 0.85;  ///< hysteresis, so that the marks converge

struct NormalEquations {
  NodeBlock H;
  NodeVector g;
  double cost = 0.0;
};

/// Bias of one beacon while its arrivals are accumulated.
struct Bias {
  BeaconId beacon;
  NodeVector coupling;
  double information = 0.0, gradient = 0.0;
};

void eliminate(const Bias& bias, NormalEquations& eq) {
  if (!bias.beacon.valid()) return;
  eq.H.noalias() -= bias.coupling * bias.coupling.transpose() / bias.information;
  eq.g.noalias() -= bias.coupling * (bias.gradient / bias.information);
  eq.cost -= 0.5 * bias.gradient * bias.gradient / bias.information;
}

/// Rows of one beacon are not adjacent in the log, so with biases the arrivals are visited by beacon.
void add_biased_arrivals(const Trajectory& t, const Segment& segment, const SharedState& state,
                         double uncertainty_m, NormalEquations& eq) {
  const int n = t.block_size();
  ObservationRow rows[2];
  for (std::size_t b = 0; b < state.beacon_p_map_m.size(); ++b) {
    Bias bias{BeaconId(), NodeVector::Zero(n), 0.0, 0.0};
    for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
      const ArrivalObservation& a = t.arrivals[i];
      if (a.beacon.index() != b || a.rejection != Rejection::kUsed) continue;
      arrival_rows(t, i, state, rows);
      const double uncertainty_s = uncertainty_m * a.legs() / (a.model_speed_mps + state.speed_offset(t.run));
      if (!bias.beacon.valid()) {
        bias.beacon = a.beacon;
        bias.information = 1.0 / (uncertainty_s * uncertainty_s);
      }
      const double by_bias = rows[0].by(kByDelay);
      eq.H.noalias() += rows[0].by_node.transpose() * rows[0].by_node;
      eq.g.noalias() += rows[0].residual * rows[0].by_node.transpose();
      eq.cost += 0.5 * rows[0].residual * rows[0].residual;
      bias.coupling.noalias() += by_bias * rows[0].by_node.transpose();
      bias.information += by_bias * by_bias;
      bias.gradient += by_bias * rows[0].residual;
    }
    eliminate(bias, eq);
  }
}

/// Adds the arrivals of a planar node without forming rows.
void add_planar_arrivals(const Trajectory& t, const Segment& segment, const SharedState& state,
                         NormalEquations& eq) {
  const PlanarNode at(t.nodes[segment.first_node].T_map_vehicle);
  ArrivalWhitening whitening(state.speed_offset(t.run));
  double H[6] = {}, g[3] = {}, squares = 0.0;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (a.rejection != Rejection::kUsed) continue;
    whitening.set(a);
    const PlanarArrival row(a, at, state, whitening);
    const double by[3] = {row.by_x(), row.by_y(), row.by_heading};
    for (int p = 0, e = 0; p < 3; ++p) {
      g[p] += by[p] * row.residual;
      for (int q = p; q < 3; ++q) H[e++] += by[p] * by[q];
    }
    squares += row.residual * row.residual;
  }
  for (int p = 0, e = 0; p < 3; ++p) {
    eq.g[p] += g[p];
    for (int q = p; q < 3; ++q, ++e) {
      eq.H(p, q) += H[e];
      if (q != p) eq.H(q, p) += H[e];
    }
  }
  eq.cost += 0.5 * squares;
}

/// A beacon with a position error gives a bearing error of this uncertainty over its distance.
double bearing_weight(const Trajectory& t, const BearingObservation& b, const SharedState& state,
                      double uncertainty_m) {
  if (uncertainty_m == 0.0) return 1.0;
  const double d2 = (state.beacon_p_map_m[b.reflector.index()] - t.nodes[b.node].T_map_vehicle.translation_m)
                        .head<2>()
                        .squaredNorm();
  return b.sigma_rad * b.sigma_rad /
         (b.sigma_rad * b.sigma_rad + uncertainty_m * uncertainty_m / std::max(d2, 1e-6));
}

NormalEquations normal_equations(const Trajectory& t, const Segment& segment, const SharedState& state,
                                 double uncertainty_m) {
  const int n = t.block_size();
  NormalEquations eq{NodeBlock::Zero(n, n), NodeVector::Zero(n), 0.0};
  const auto add = [&](const ObservationRow& row, double w) {
    eq.H.noalias() += w * row.by_node.transpose() * row.by_node;
    eq.g.noalias() += w * row.residual * row.by_node.transpose();
    eq.cost += 0.5 * w * row.residual * row.residual;
  };
  const auto weigh = [&](const ObservationRow& row) {
    add(row,
        row.kind == RowKind::kBearing ? bearing_weight(t, t.bearings[row.index], state, uncertainty_m) : 1.0);
  };
  Segment others = segment;
  others.first_arrival = others.last_arrival;
  if (uncertainty_m == 0.0) {
    const bool plain = n == 3 && has_planar_arrivals(t, segment, state);
    if (plain) add_planar_arrivals(t, segment, state, eq);
    for_each_row(t, plain ? others : segment, state, weigh);
    return eq;
  }
  for_each_row(t, others, state, weigh);
  add_biased_arrivals(t, segment, state, uncertainty_m, eq);
  return eq;
}

}  // namespace

NodeAdjustment adjust_node(Trajectory& t, const Segment& segment, const SharedState& state,
                           double range_uncertainty_m, int max_iterations) {
  constexpr double kOvershot = 0.25;
  NodeAdjustment out;
  Node& node = t.nodes[segment.first_node];
  NormalEquations eq = normal_equations(t, segment, state, range_uncertainty_m);
  double lambda = 0.0;
  for (int k = 0; k < max_iterations && !out.converged; ++k) {
    NodeBlock A = eq.H;
    A.diagonal() *= 1.0 + lambda;
    // Unobserved rotations (a single antenna on the axis) stay unchanged; information of 1/pi^2 is
    // negligible.
    add_vague_angles(t.motion, A);
    A.diagonal().array() += 1e-12 * (1.0 + A.diagonal().maxCoeff());
    const NodeVector step = -Eigen::LDLT<NodeBlock>(A).solve(eq.g);
    if (!step.allFinite()) break;
    const Node before = node;
    step_node(t, step, node);
    const double gain = -0.5 * eq.g.dot(step);
    const NormalEquations next = normal_equations(t, segment, state, range_uncertainty_m);
    if (next.cost <= eq.cost * (1.0 + 1e-12) + 1e-20) {
      out.converged = gain * (1.0 + lambda) <= 1e-10 * (1.0 + eq.cost);  // damping shortens the step
      // Gauss-Newton steps overshoot where residuals are large beside the distances.
      const bool overshot = eq.cost - next.cost < kOvershot * gain;
      lambda = overshot ? std::max(4.0 * lambda, 0.1) : lambda < 1e-6 ? 0.0 : 0.1 * lambda;
      eq = next;
    } else {
      node = before;
      out.converged = gain <= 1e-8 * (1.0 + eq.cost);  // remaining gain is rounding error
      lambda = std::max(10.0 * lambda, 1e-3);
    }
  }
  out.cost = eq.cost;
  out.information = eq.H;
  return out;
}

double allowed_residual_m(const Trajectory& t, const ArrivalObservation& a, const EpochFixModel& model,
                          double range_uncertainty_m, double sigmas) {
  const double speed = (a.model_speed_mps + model.state.speed_offset(t.run)) / a.legs();
  const double noise_m = a.sigma_s * speed;
  double variance = noise_m * noise_m + range_uncertainty_m * range_uncertainty_m;
  if (a.beacon.index() < model.beacon_covariance.size()) {
    const Pose T = pose_at(t, a.node, a.alpha);
    const Eigen::Vector3d v = T * model.state.receiver_p_vehicle_m[a.receiver.index()] -
                              model.state.beacon_p_map_m[a.beacon.index()];
    const double d = std::max(v.norm(), 1e-6);
    Eigen::Matrix<double, 5, 1> by;
    by << -v / d, speed, -d / (speed * a.legs());
    variance += std::max(0.0, by.dot(model.beacon_covariance[a.beacon.index()] * by));
  }
  return sigmas * std::sqrt(variance);
}

namespace {

/// Residual of each arrival in metres, and the median residual of its beacon (the lower one of two, because
/// echoes are late).
struct NodeResiduals {
  std::pmr::vector<double> own_m{scratch()}, beacon_m{scratch()};
};

NodeResiduals node_residuals_of(const Trajectory& t, const Segment& segment, const SharedState& state) {
  NodeResiduals out;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    const double speed = (a.model_speed_mps + state.speed_offset(t.run)) / a.legs();
    out.own_m.push_back(arrival_residual(t, a, state) * a.sigma_s * speed);
  }
  std::pmr::vector<double> same(scratch());
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    same.clear();
    for (std::size_t j = segment.first_arrival; j < segment.last_arrival; ++j)
      if (t.arrivals[j].beacon == t.arrivals[i].beacon) same.push_back(out.own_m[j - segment.first_arrival]);
    const auto middle = same.begin() + static_cast<std::ptrdiff_t>((same.size() - 1) / 2);
    std::ranges::nth_element(same, middle);
    out.beacon_m.push_back(*middle);
  }
  return out;
}

/// The allowance belongs to the beacon: its arrivals may deviate together by much, but among themselves only
/// by noise and by the effect of a wrong direction on the lever arm.
bool agrees_with_its_beacon(const Trajectory& t, const ArrivalObservation& a, const EpochFixModel& model,
                            double range_uncertainty_m, double sigmas, double off_m) {
  const Eigen::Vector3d& lever = model.state.receiver_p_vehicle_m[a.receiver.index()];
  const double d =
      (t.nodes[a.node].T_map_vehicle * lever - model.state.beacon_p_map_m[a.beacon.index()]).norm();
  const double turned_m = lever.norm() * range_uncertainty_m / std::max(d, range_uncertainty_m);
  return std::abs(off_m) <= allowed_residual_m(t, a, model, 1.5 * turned_m, sigmas);
}

}  // namespace

bool reject_arrivals(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                     double range_uncertainty_m, double sigmas) {
  bool changed = false;
  // Along a drive the error of a beacon appears from changing directions, so its arrivals share no error.
  const bool common = range_uncertainty_m > 0 && segment.last_node - segment.first_node == 1;
  const NodeResiduals residuals = common ? node_residuals_of(t, segment, model.state) : NodeResiduals{};
  const bool plain =
      segment.last_node - segment.first_node == 1 && has_planar_arrivals(t, segment, model.state);
  const PlanarNode at = plain ? PlanarNode(t.nodes[segment.first_node].T_map_vehicle) : PlanarNode();
  ArrivalWhitening whitening(model.state.speed_offset(t.run));
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    ArrivalObservation& a = t.arrivals[i];
    if (a.rejection == Rejection::kBeaconUnusable) continue;
    const double speed = (a.model_speed_mps + model.state.speed_offset(t.run)) / a.legs();
    if (plain) whitening.set(a);
    const double noise_m = a.sigma_s * speed;
    const double residual_m = noise_m * (plain ? PlanarArrival(a, at, model.state, whitening).residual
                                               : arrival_residual(t, a, model.state));
    const bool was_used = a.rejection == Rejection::kUsed;
    const double within = sigmas * (was_used ? 1.0 : kReadmitShare);
    // Residuals within noise need no further test.
    bool use = std::abs(residual_m) <= within * noise_m ||
               std::abs(residual_m) <= allowed_residual_m(t, a, model, range_uncertainty_m, within);
    if (use && common) {
      const double off_m =
          residuals.own_m[i - segment.first_arrival] - residuals.beacon_m[i - segment.first_arrival];
      use = agrees_with_its_beacon(t, a, model, range_uncertainty_m, within, off_m);
    }
    a.rejection = use ? Rejection::kUsed : residual_m > 0 ? Rejection::kLate : Rejection::kEarly;
    changed = changed || use != was_used;
  }
  return changed;
}

bool reject_bearings(Trajectory& t, const Segment& segment, const EpochFixModel& model, double uncertainty_m,
                     double sigmas) {
  bool changed = false;
  ObservationRow row;
  for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i) {
    BearingObservation& b = t.bearings[i];
    if (b.rejection == Rejection::kBeaconUnusable || bearing_rows(t, i, model.state, &row) == 0) continue;
    const double d =
        (model.state.beacon_p_map_m[b.reflector.index()] - t.nodes[b.node].T_map_vehicle.translation_m)
            .head<2>()
            .norm();
    double variance = b.sigma_rad * b.sigma_rad + std::pow(uncertainty_m / std::max(d, 1e-3), 2);
    if (b.reflector.index() < model.beacon_covariance.size())
      variance +=
          model.beacon_covariance[b.reflector.index()].topLeftCorner<2, 2>().trace() / std::max(d * d, 1e-6);
    const double off = row.residual * b.sigma_rad / std::sqrt(variance);
    const Rejection rejection = std::abs(off) <= sigmas ? Rejection::kUsed
                                : off > 0               ? Rejection::kLate
                                                        : Rejection::kEarly;
    changed = changed || rejection != b.rejection;
    b.rejection = rejection;
  }
  return changed;
}

NodeAdjustment adjust_and_reject(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                                 double range_uncertainty_m, double sigmas, CorrelatedArrivals& weights) {
  // The search ends near the optimum, not at it: the first gates are wider.
  constexpr double kFirstGate = 1.5;
  constexpr int kOutlierRounds = 8, kTailRounds = 10;
  const auto adjust = [&] {
    weights.weigh();
    return adjust_node(t, segment, model.state, range_uncertainty_m);
  };
  weights.narrow_tails();
  reject_arrivals(t, segment, model, range_uncertainty_m, kFirstGate * sigmas);
  reject_bearings(t, segment, model, range_uncertainty_m, 2 * kFirstGate * sigmas);
  NodeAdjustment adjustment = adjust();
  for (int round = 0; round < kOutlierRounds; ++round) {
    weights.restore();
    const bool arrivals = reject_arrivals(t, segment, model, range_uncertainty_m, sigmas);
    const bool bearings = reject_bearings(t, segment, model, range_uncertainty_m, sigmas);
    if (!arrivals && !bearings) break;
    adjustment = adjust();
  }
  for (int round = 0; round < kTailRounds && weights.widen_tails(model.state); ++round) {
    adjustment = adjust();
    weights.restore();
  }
  weights.weigh();
  return adjustment;
}

}  // namespace octant
