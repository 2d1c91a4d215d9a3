// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "models/trajectory/trajectory.h"

namespace octant {

/// A planar state as numbers, so that loops over a chain need neither quaternions nor atan2.
struct PlanarNode {
  double x_m = 0.0, y_m = 0.0, heading_rad = 0.0;
  double cosine = 1.0, sine = 0.0;  ///< of the heading

  PlanarNode() = default;
  explicit PlanarNode(const Pose& T) : x_m(T.translation_m.x()), y_m(T.translation_m.y()) {
    const Eigen::Quaterniond& q = T.rotation;
    cosine = 1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z());
    sine = 2.0 * (q.w() * q.z() + q.x() * q.y());
    heading_rad = std::atan2(sine, cosine);
  }
  PlanarNode(double x, double y, double heading)
      : x_m(x), y_m(y), heading_rad(heading), cosine(std::cos(heading)), sine(std::sin(heading)) {}
  [[nodiscard]] Pose pose() const { return Pose::planar(x_m, y_m, heading_rad); }
};

/// As wrap_angle, for differences that rarely need it.
[[nodiscard]] inline double wrap_difference(double angle_rad) {
  return angle_rad > M_PI || angle_rad <= -M_PI ? wrap_angle(angle_rad) : angle_rad;
}

/// Two states and the shortest turn from one to the other.
struct PlanarInterval {
  const PlanarNode& from;
  const PlanarNode& to;
  double turn_rad;
  PlanarInterval(const PlanarNode& a, const PlanarNode& b)
      : from(a), to(b), turn_rad(wrap_difference(b.heading_rad - a.heading_rad)) {}

  /// Linear in position and heading, as `interpolate`.
  [[nodiscard]] PlanarNode at(double alpha) const {
    if (alpha == 0.0) return from;
    PlanarNode s;
    s.x_m = (1.0 - alpha) * from.x_m + alpha * to.x_m;
    s.y_m = (1.0 - alpha) * from.y_m + alpha * to.y_m;
    const double d = alpha * turn_rad, d2 = d * d;
    s.heading_rad = from.heading_rad + d;
    constexpr double kSeriesRad = 0.05;  // where the terms left out are below 1e-17
    double c = 0.0, e = 0.0;
    if (d2 < kSeriesRad * kSeriesRad) {
      c = 1.0 - d2 / 2 * (1.0 - d2 / 12 * (1.0 - d2 / 30 * (1.0 - d2 / 56)));
      e = d * (1.0 - d2 / 6 * (1.0 - d2 / 20 * (1.0 - d2 / 42)));
    } else {
      c = std::cos(d);
      e = std::sin(d);
    }
    s.cosine = from.cosine * c - from.sine * e;
    s.sine = from.sine * c + from.cosine * e;
    return s;
  }
};

/// Whether the arrivals of a trajectory are single straight paths, heard at planar states and timed by the
/// vehicle's own clock: what PlanarArrival takes.
[[nodiscard]] inline bool has_planar_arrivals(const Trajectory& t, const Segment& segment,
                                              const SharedState& state) {
  return t.motion == Motion::kPlanar && !t.has_cycle_offset && !state.attenuation &&
         (segment.first_arrival == segment.last_arrival || !t.arrivals[segment.first_arrival].two_way);
}

/// What the arrivals of a run have in common, so that none of them divides by it.
class PlanarWhitening {
 public:
  /// @param speed_offset_mps  SharedState::speed_offset of the run
  explicit PlanarWhitening(double speed_offset_mps) : speed_offset_mps_(speed_offset_mps) {}
  void take(const ArrivalObservation& a) {
    if (a.sigma_s == sigma_s_ && a.model_speed_mps == model_speed_mps_) return;
    sigma_s_ = a.sigma_s;
    model_speed_mps_ = a.model_speed_mps;
    by_tof = -1.0 / sigma_s_;
    slowness = 1.0 / (model_speed_mps_ + speed_offset_mps_);
  }
  double by_tof = 0.0;    ///< d residual / d predicted time of flight, -1 / sigma
  double slowness = 0.0;  ///< s/m

 private:
  double speed_offset_mps_, sigma_s_ = 0.0, model_speed_mps_ = 0.0;
};

/// The measurement equation of such an arrival, whitened:
///   residual = (tof - |T o - p| / c - delay) / sigma
struct PlanarArrival {
  double residual = 0.0;
  double by_distance = 0.0;  ///< d residual / d distance
  double distance_m = 0.0;
  double direction[3] = {};         ///< unit vector from beacon to receiver
  double by_heading = 0.0;          ///< d residual / d heading
  double cosine = 1.0, sine = 0.0;  ///< of the heading

  /// @param at  state at the arrival
  PlanarArrival(const ArrivalObservation& a, const PlanarNode& at, const SharedState& state,
                const PlanarWhitening& w) {
    constexpr double kMinDistanceM = 1e-6;  // as predict_arrival
    const Eigen::Vector3d &o = state.receiver_p_vehicle_m[a.receiver.index()],
                          &p = state.beacon_p_map_m[a.beacon.index()];
    cosine = at.cosine;
    sine = at.sine;
    const double ox = cosine * o.x() - sine * o.y(), oy = sine * o.x() + cosine * o.y();
    const double vx = at.x_m + ox - p.x(), vy = at.y_m + oy - p.y(), vz = o.z() - p.z();
    distance_m = std::max(std::sqrt(vx * vx + vy * vy + vz * vz), kMinDistanceM);
    by_distance = w.by_tof * w.slowness;
    residual = (distance_m * w.slowness + state.delay_s(a.beacon, a.receiver) - a.tof_s) * w.by_tof;
    const double inverse = 1.0 / distance_m;
    direction[0] = vx * inverse;
    direction[1] = vy * inverse;
    direction[2] = vz * inverse;
    by_heading = by_distance * (direction[1] * ox - direction[0] * oy);
  }
  [[nodiscard]] double by_x() const { return by_distance * direction[0]; }
  [[nodiscard]] double by_y() const { return by_distance * direction[1]; }
};

/// Odometry between two planar states: misfit in the frame of the first and its weights,
///   off = step - R'(b - a),   turn = heading step - (heading b - heading a)
struct PlanarStep {
  double dx, dy;      ///< b - a, in the map
  double fx, fy;      ///< R off times the weight
  double turn, off2;  ///< misfit [rad], square of the other [m^2]
  double weight, weight_turn;
  double moment;  ///< derivative of the squares by the first heading, halved, turn apart

  /// @param step_turn_rad  heading of the step
  PlanarStep(const OdometryObservation& o, double step_turn_rad, const PlanarInterval& interval) {
    const PlanarNode &a = interval.from, &b = interval.to;
    dx = b.x_m - a.x_m;
    dy = b.y_m - a.y_m;
    const double sx = a.cosine * dx + a.sine * dy, sy = a.cosine * dy - a.sine * dx;
    const double ex = o.T_before_after.translation_m.x() - sx, ey = o.T_before_after.translation_m.y() - sy;
    weight = 1.0 / (o.distance_sigma_m * o.distance_sigma_m);
    weight_turn = 1.0 / (o.heading_sigma_rad * o.heading_sigma_rad);
    turn = wrap_difference(step_turn_rad - interval.turn_rad);
    fx = weight * (a.cosine * ex - a.sine * ey);
    fy = weight * (a.sine * ex + a.cosine * ey);
    moment = weight * (sx * ey - sy * ex);
    off2 = ex * ex + ey * ey;
  }
  [[nodiscard]] double cost() const { return 0.5 * (weight * off2 + weight_turn * turn * turn); }

  /// Adds the normal equations: blocks of the first state, of both, of the second.
  template <class Block, class Vector>
  void add_to(Block& D, Vector& g, Block& U, Block& D_next, Vector& g_next) const {
    const double cx = -weight * dy, cy = weight * dx;  // of position and heading of the first
    D(0, 0) += weight;
    D(1, 1) += weight;
    D(0, 2) += cx;
    D(1, 2) += cy;
    D(2, 0) += cx;
    D(2, 1) += cy;
    D(2, 2) += weight * (dx * dx + dy * dy) + weight_turn;
    U(0, 0) -= weight;
    U(1, 1) -= weight;
    U(2, 0) -= cx;
    U(2, 1) -= cy;
    U(2, 2) -= weight_turn;
    D_next(0, 0) += weight;
    D_next(1, 1) += weight;
    D_next(2, 2) += weight_turn;
    g[0] += fx;
    g[1] += fy;
    g[2] += moment + weight_turn * turn;
    g_next[0] -= fx;
    g_next[1] -= fy;
    g_next[2] -= weight_turn * turn;
  }
};

/// Of the symmetric matrix [xx xy; xy yy].
[[nodiscard]] inline double largest_eigenvalue(double xx, double xy, double yy) {
  return 0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy);
}

}  // namespace octant
