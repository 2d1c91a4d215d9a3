// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "models/physics/turn_series.h"
#include "models/trajectory/planar.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// Returns true if SpatialArrival applies to the arrivals of a segment.
[[nodiscard]] inline bool has_spatial_arrivals(const Trajectory& t, const Segment& segment,
                                               const SharedState& state) {
  return t.motion == Motion::kSpatial && has_plain_arrivals(t, segment, state);
}

/// Two states in space and the shortest rotation between them.
struct SpatialInterval {
  Eigen::Matrix3d R;                    ///< rotation of the first state
  Eigen::Matrix3d R_turn;               ///< rotation of the second state in the frame of the first, Exp(phi)
  Eigen::Quaterniond turn;              ///< the rotation as a quaternion
  Eigen::Vector3d from_m, to_m, phi;    ///< positions of both states; rotation vector
  double turn2 = 0.0, curvature = 0.0;  ///< squared length of phi; see `inverse_curvature`

  SpatialInterval(const Pose& a, const Pose& b)
      : R(a.rotation.toRotationMatrix()),
        turn(a.rotation.conjugate() * b.rotation),
        from_m(a.translation_m),
        to_m(b.translation_m),
        phi(log_rotation(turn)),
        turn2(phi.squaredNorm()),
        curvature(inverse_curvature(turn2)) {
    R_turn = turn.toRotationMatrix();
  }
};

/// Instant between two states and the derivatives of its rotation, like `InstantPose`. With K = [phi]x every
/// rotation is a polynomial in K that K^3 = -|phi|^2 K reduces to second degree:
///   Exp(alpha phi) = I + sine K + versine K^2
///   Exp(alpha phi) d turn / d turn of the next = alpha (I + next[0] K + next[1] K^2)
///   Exp(alpha phi) d turn / d turn of the first = I - alpha (I + node[0] K + node[1] K^2)
struct SpatialInstant {
  double alpha, sine, versine;
  double node[2], next[2];
  Eigen::Vector3d place_m;

  SpatialInstant(const SpatialInterval& i, double at)
      : alpha(at), place_m((1.0 - at) * i.from_m + at * i.to_m) {
    const double angle2 = alpha * alpha * i.turn2, c = i.curvature;
    // Jl(alpha phi) = I + a K + b K^2 times Jr^-1(phi) = I + K / 2 + c K^2 and Jr^-1(-phi) = I - K / 2 + c
    // K^2.
    const double lag = sine_lag_by_cube(angle2);
    const double a = alpha * versine_by_square(angle2), b = alpha * alpha * lag;
    sine = alpha * (1.0 - angle2 * lag);
    versine = alpha * a;
    const double even = c + b - i.turn2 * b * c, odd = a - i.turn2 * a * c;
    next[0] = odd + 0.5 * (1.0 - i.turn2 * b);
    next[1] = even + 0.5 * a;
    node[0] = odd - 0.5 * (1.0 - i.turn2 * b);
    node[1] = even - 0.5 * a;
  }
  /// Exp(alpha phi) v and its inverse.
  [[nodiscard]] Eigen::Vector3d turned(const SpatialInterval& i, const Eigen::Vector3d& v) const {
    const Eigen::Vector3d once = i.phi.cross(v);
    return v + sine * once + versine * i.phi.cross(once);
  }
  [[nodiscard]] Eigen::Vector3d turned_back(const SpatialInterval& i, const Eigen::Vector3d& v) const {
    const Eigen::Vector3d once = i.phi.cross(v);
    return v - sine * once + versine * i.phi.cross(once);
  }
};

/// Whitened measurement equation of a plain arrival in space:
///   residual = (tof - |T o - p| / c - delay) / sigma
/// with its derivatives by the states before and after it (by the first only if alpha is zero).
struct SpatialArrival {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  double residual = 0.0;
  double by_distance = 0.0;  ///< d residual / d distance
  double distance_m = 0.0;
  Eigen::Vector3d direction;        ///< unit vector from beacon to receiver, in the map
  Eigen::Vector3d direction_first;  ///< unit vector from beacon to receiver, in the frame of the first state
  Vector6 by_node, by_next;

  SpatialArrival(const ArrivalObservation& a, const SpatialInterval& i, const SpatialInstant& at,
                 const SharedState& state, const ArrivalWhitening& w) {
    constexpr double kMinDistanceM = 1e-6;  // the bound of predict_arrival
    const Eigen::Vector3d &o = state.receiver_p_vehicle_m[a.receiver.index()],
                          &p = state.beacon_p_map_m[a.beacon.index()];
    const Eigen::Vector3d arm = at.turned(i, o);  // in the frame of the first state
    const Eigen::Vector3d way = at.place_m - p + i.R * arm;
    distance_m = std::max(way.norm(), kMinDistanceM);
    by_distance = w.by_tof * w.slowness;
    residual = (distance_m * w.slowness + state.delay_s(a.beacon, a.receiver) - a.tof_s) * w.by_tof;
    direction = way * (1.0 / distance_m);
    direction_first = i.R.transpose() * direction;
    // d |T o - p| = (o x R'u) . turn at the instant = (arm x u) . Exp(alpha phi) turn
    const Eigen::Vector3d moment = arm.cross(direction_first), once = i.phi.cross(moment),
                          twice = i.phi.cross(once);
    const double first = (1.0 - at.alpha) * by_distance, second = at.alpha * by_distance;
    by_node.head<3>() = first * direction;
    by_node.tail<3>() = first * moment + second * (at.node[0] * once - at.node[1] * twice);
    by_next.head<3>() = second * direction;
    by_next.tail<3>() = second * (moment - at.next[0] * once + at.next[1] * twice);
  }
};

/// Odometry between two states in space: with (R, p) of each, E = (Ra'Rb)'Ro and e = Log E,
///   off = step - Ra'(pb - pa),   turn = e,   d e = Jr^-1(-e) ((Ra'Rb)' turn of a - turn of b)
class SpatialStep {
 public:
  SpatialStep(const OdometryObservation& o, const SpatialInterval& i)
      : i_(i),
        weight_(1.0 / (o.distance_sigma_m * o.distance_sigma_m)),
        weight_turn_(1.0 / (o.heading_sigma_rad * o.heading_sigma_rad)),
        step_(i.R.transpose() * (i.to_m - i.from_m)),
        off_(o.T_before_after.translation_m - step_),
        e_(log_rotation(i.turn.conjugate() * o.T_before_after.rotation)) {}

  [[nodiscard]] double cost() const {
    return 0.5 * (weight_ * off_.squaredNorm() + weight_turn_ * e_.squaredNorm());
  }

  /// Adds the normal equations: blocks of the first state, of the coupling, and of the second state.
  template <class Block, class Coupling, class Next, class Vector, class NextVector>
  void add_to(Block& D, Vector& g, Coupling& U, Next& D_next, NextVector& g_next) const {
    // Jr^-1(-e)' Jr^-1(-e) = I + d K^2 with K = [e]x, K^2 = e e' - |e|^2 I; and Jr^-1(-e)' e = e.
    const double e2 = e_.squaredNorm(), c = inverse_curvature(e2), d = 2.0 * c - 0.25 - c * c * e2;
    const Eigen::Vector3d e_first = i_.R_turn * e_;  // in the frame of the first state
    const double even = weight_turn_ * (1.0 - d * e2), odd = weight_turn_ * d;
    const double s2 = step_.squaredNorm();
    const Eigen::Vector3d pull = i_.R * (weight_ * off_), twist = weight_ * step_.cross(off_);
    const Eigen::Matrix3d lever = levers();  // -weight R [step]x
    const Eigen::Matrix3d turns = odd * e_first * e_first.transpose() - weight_ * step_ * step_.transpose(),
                          couples = even * i_.R_turn + odd * e_first * e_.transpose(),
                          turns_next = odd * e_ * e_.transpose();
    D.template topRightCorner<3, 3>() += lever;
    D.template bottomLeftCorner<3, 3>() += lever.transpose();
    D.template bottomRightCorner<3, 3>() += turns;
    D.diagonal().template head<3>().array() += weight_;
    D.diagonal().template tail<3>().array() += even + weight_ * s2;
    U.template bottomLeftCorner<3, 3>() -= lever.transpose();
    U.template bottomRightCorner<3, 3>() -= couples;
    U.diagonal().template head<3>().array() -= weight_;
    D_next.template bottomRightCorner<3, 3>() += turns_next;
    D_next.diagonal().template head<3>().array() += weight_;
    D_next.diagonal().template tail<3>().array() += even;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      g[k] += pull[i];
      g[3 + k] += twist[i] + weight_turn_ * e_first[i];
      g_next[k] -= pull[i];
      g_next[3 + k] -= weight_turn_ * e_[i];
    }
  }

 private:
  [[nodiscard]] Eigen::Matrix3d levers() const {
    Eigen::Matrix3d out;
    for (int k = 0; k < 3; ++k) out.row(k) = weight_ * step_.cross(i_.R.row(k).transpose()).transpose();
    return out;
  }

  const SpatialInterval& i_;
  double weight_, weight_turn_;
  Eigen::Vector3d step_, off_, e_;
};

}  // namespace octant
