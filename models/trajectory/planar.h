// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "models/trajectory/trajectory.h"

namespace octant {

/// Angle of a unit vector, in (-pi, pi]. Small angles are evaluated by a series instead of the library's
/// arctangent.
[[nodiscard]] inline double angle_of(double cosine, double sine) {
  constexpr double kSeries = 0.1;  // the first neglected term is below 1e-17
  if (!(cosine > 0.0) || std::abs(sine) > kSeries) return std::atan2(sine, cosine);
  const double s2 = sine * sine;
  return sine *
         (1.0 + s2 * (1.0 / 6 +
                      s2 * (3.0 / 40 + s2 * (5.0 / 112 +
                                             s2 * (35.0 / 1152 + s2 * (63.0 / 2816 + s2 * 231.0 / 13312))))));
}

/// Planar rotation as cosine and sine, so that chains of rotations need no trigonometric functions.
struct PlanarTurn {
  double cosine = 1.0, sine = 0.0;

  PlanarTurn() = default;
  PlanarTurn(double c, double s) : cosine(c), sine(s) {}
  explicit PlanarTurn(const Eigen::Quaterniond& q)
      : cosine(1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z())), sine(2.0 * (q.w() * q.z() + q.x() * q.y())) {}
  explicit PlanarTurn(double angle_rad) {
    constexpr double kSeriesRad = 0.05;  // the first neglected term is below 1e-17
    const double d = angle_rad, d2 = d * d;
    if (d2 < kSeriesRad * kSeriesRad) {
      cosine = 1.0 - d2 * (1.0 / 2 - d2 * (1.0 / 24 - d2 * (1.0 / 720 - d2 * (1.0 / 40320))));
      sine = d * (1.0 - d2 * (1.0 / 6 - d2 * (1.0 / 120 - d2 * (1.0 / 5040))));
    } else {
      cosine = std::cos(d);
      sine = std::sin(d);
    }
  }
  [[nodiscard]] double angle_rad() const { return angle_of(cosine, sine); }
  friend PlanarTurn operator*(const PlanarTurn& a, const PlanarTurn& b) {
    return {a.cosine * b.cosine - a.sine * b.sine, a.sine * b.cosine + a.cosine * b.sine};
  }
  /// Rotation from a to b.
  friend PlanarTurn between(const PlanarTurn& a, const PlanarTurn& b) {
    return {a.cosine * b.cosine + a.sine * b.sine, a.cosine * b.sine - a.sine * b.cosine};
  }
};

/// Planar state as plain numbers, so that loops over a chain need neither quaternions nor trigonometric
/// functions.
struct PlanarNode {
  double x_m = 0.0, y_m = 0.0;
  PlanarTurn heading;

  PlanarNode() = default;
  explicit PlanarNode(const Pose& T)
      : x_m(T.translation_m.x()), y_m(T.translation_m.y()), heading(T.rotation) {}
  PlanarNode(double x, double y, const PlanarTurn& heading_in) : x_m(x), y_m(y), heading(heading_in) {}

  [[nodiscard]] PlanarNode moved(double dx_m, double dy_m, double turn_rad) const {
    PlanarTurn h = heading * PlanarTurn(turn_rad);
    // One Newton step keeps the vector at unit length.
    const double scale = 1.5 - 0.5 * (h.cosine * h.cosine + h.sine * h.sine);
    return {x_m + dx_m, y_m + dy_m, {h.cosine * scale, h.sine * scale}};
  }
  /// z, roll and pitch are zero.
  [[nodiscard]] Pose pose() const {
    Pose T;
    T.translation_m = {x_m, y_m, 0.0};
    // Half the angle, computed from the larger of its cosine and sine.
    const double c = heading.cosine, s = heading.sine;
    if (c >= 0.0) {
      const double w = std::sqrt(0.5 * (1.0 + c));
      T.rotation = Eigen::Quaterniond(w, 0.0, 0.0, 0.5 * s / w);
    } else {
      const double z = std::copysign(std::sqrt(0.5 * (1.0 - c)), s);
      T.rotation = Eigen::Quaterniond(0.5 * s / z, 0.0, 0.0, z);
    }
    return T;
  }
};

/// Two states and the shortest rotation between them.
struct PlanarInterval {
  const PlanarNode& from;
  const PlanarNode& to;
  PlanarTurn turn;
  double turn_rad;
  PlanarInterval(const PlanarNode& a, const PlanarNode& b)
      : from(a), to(b), turn(between(a.heading, b.heading)), turn_rad(turn.angle_rad()) {}

  /// Linear in position and heading, like `interpolate`.
  [[nodiscard]] PlanarNode at(double alpha) const {
    if (alpha == 0.0) return from;
    return {(1.0 - alpha) * from.x_m + alpha * to.x_m, (1.0 - alpha) * from.y_m + alpha * to.y_m,
            from.heading * PlanarTurn(alpha * turn_rad)};
  }
};

/// Returns true if all arrivals of a segment are single straight paths, timed by the clock of the vehicle.
[[nodiscard]] inline bool has_plain_arrivals(const Trajectory& t, const Segment& segment,
                                             const SharedState& state) {
  return !t.has_cycle_offset && state.has_plain_paths() &&
         (segment.first_arrival == segment.last_arrival || !t.arrivals[segment.first_arrival].two_way);
}

/// Returns true if PlanarArrival applies to the arrivals of a segment, which requires planar states.
[[nodiscard]] inline bool has_planar_arrivals(const Trajectory& t, const Segment& segment,
                                              const SharedState& state) {
  return t.motion == Motion::kPlanar && has_plain_arrivals(t, segment, state);
}

/// Factors that consecutive arrivals share, so that most of them need no division.
class ArrivalWhitening {
 public:
  /// @param speed_offset_mps  SharedState::speed_offset of the run
  explicit ArrivalWhitening(double speed_offset_mps) : speed_offset_mps_(speed_offset_mps) {}
  void set(const ArrivalObservation& a) {
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

/// Whitened measurement equation of a plain arrival at a planar state:
///   residual = (tof - |T o - p| / c - delay) / sigma
struct PlanarArrival {
  double residual = 0.0;
  double by_distance = 0.0;  ///< d residual / d distance
  double distance_m = 0.0;
  double direction[3] = {};         ///< unit vector from beacon to receiver
  double by_heading = 0.0;          ///< d residual / d heading
  double cosine = 1.0, sine = 0.0;  ///< cosine and sine of the heading

  /// @param at  state at the arrival
  PlanarArrival(const ArrivalObservation& a, const PlanarNode& at, const SharedState& state,
                const ArrivalWhitening& w) {
    constexpr double kMinDistanceM = 1e-6;  // the bound of predict_arrival
    const Eigen::Vector3d &o = state.receiver_p_vehicle_m[a.receiver.index()],
                          &p = state.beacon_p_map_m[a.beacon.index()];
    cosine = at.heading.cosine;
    sine = at.heading.sine;
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

/// Odometry between two planar states: residual in the frame of the first state, and weights,
///   off = step - R'(b - a),   turn = heading step - (heading b - heading a)
struct PlanarStep {
  double dx, dy;      ///< b - a, in the map
  double fx, fy;      ///< weighted residual R off, in the map
  double turn, off2;  ///< heading residual [rad] and squared position residual [m^2]
  double weight, weight_turn;
  double moment;  ///< half the derivative of the squared position residual by the first heading, weighted

  PlanarStep(const OdometryObservation& o, const PlanarInterval& interval) {
    const PlanarNode &a = interval.from, &b = interval.to;
    const double c = a.heading.cosine, s = a.heading.sine;
    dx = b.x_m - a.x_m;
    dy = b.y_m - a.y_m;
    const double sx = c * dx + s * dy, sy = c * dy - s * dx;
    const double ex = o.T_before_after.translation_m.x() - sx, ey = o.T_before_after.translation_m.y() - sy;
    weight = 1.0 / (o.distance_sigma_m * o.distance_sigma_m);
    weight_turn = 1.0 / (o.heading_sigma_rad * o.heading_sigma_rad);
    turn = between(interval.turn, PlanarTurn(o.T_before_after.rotation)).angle_rad();
    fx = weight * (c * ex - s * ey);
    fy = weight * (s * ex + c * ey);
    moment = weight * (sx * ey - sy * ex);
    off2 = ex * ex + ey * ey;
  }
  [[nodiscard]] double cost() const { return 0.5 * (weight * off2 + weight_turn * turn * turn); }

  /// Adds the normal equations: blocks of the first state, of the coupling, and of the second state.
  template <class Block, class Coupling, class Next, class Vector, class NextVector>
  void add_to(Block& D, Vector& g, Coupling& U, Next& D_next, NextVector& g_next) const {
    const double cx = -weight * dy,
                 cy = weight * dx;  // derivatives by position and heading of the first state
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

}  // namespace octant
