// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/linear_ranges.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "models/localizers/least_squares/search_problem.h"
#include "models/trajectory/observed_range.h"

namespace octant {
namespace {

constexpr double kInLine =
    1e-4;  ///< relative to the largest pivot: collinear beacons do not determine the side

/// Mean range and position of each received beacon, in order of first appearance.
struct Heard {
  Eigen::Vector3d p_map_m;
  double range_m = 0.0;
  int count = 0;
  BeaconId beacon;
};

constexpr std::size_t kMaxHeard = 64, kMostCompared = 200;

bool takes_part(const ArrivalObservation& a, const std::vector<bool>& usable) {
  return usable[a.beacon.index()] && a.rejection != Rejection::kTriangle;
}

}  // namespace

bool reject_detours(Trajectory& t, const Segment& s, const SharedState& state, double sigmas) {
  bool any = false;
  if (s.last_arrival - s.first_arrival > kMostCompared) return false;
  std::array<double, kMostCompared> ranges_m;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
    ranges_m[i - s.first_arrival] = observed_range_m(t, t.arrivals[i], state);
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
    ArrivalObservation& a = t.arrivals[i];
    if (a.rejection != Rejection::kUsed) continue;
    const double range_m = ranges_m[i - s.first_arrival];
    for (std::size_t j = s.first_arrival; j < s.last_arrival && a.rejection == Rejection::kUsed; ++j) {
      const ArrivalObservation& b = t.arrivals[j];
      const double later_m = range_m - ranges_m[j - s.first_arrival];
      if (b.beacon != a.beacon || !(later_m > 0)) continue;
      const double apart_m =
          (state.receiver_p_vehicle_m[a.receiver.index()] - state.receiver_p_vehicle_m[b.receiver.index()])
              .norm();
      const double noise_m = a.model_speed_mps * std::sqrt(a.sigma_s * a.sigma_s + b.sigma_s * b.sigma_s);
      if (later_m > apart_m + sigmas * noise_m) a.rejection = Rejection::kTriangle;
    }
    any = any || a.rejection == Rejection::kTriangle;
  }
  return any;
}

bool place_by_linear_ranges(Trajectory& t, const Segment& s, const SharedState& state,
                            const std::vector<bool>& usable) {
  std::array<Heard, kMaxHeard> heard;
  std::size_t beacons = 0;
  double receiver_z_m = 0.0;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (!takes_part(a, usable)) continue;
    std::size_t at = 0;
    while (at < beacons && heard[at].beacon != a.beacon) ++at;
    if (at == kMaxHeard) continue;
    if (at == beacons) heard[beacons++] = {state.beacon_p_map_m[a.beacon.index()], 0.0, 0, a.beacon};
    heard[at].range_m += observed_range_m(t, a, state);
    ++heard[at].count;
    receiver_z_m = state.receiver_p_vehicle_m[a.receiver.index()].z();
  }
  if (beacons < 3) return false;
  // Relative to the first beacon, so that the squares do not cancel.
  const Eigen::Vector2d origin = heard[0].p_map_m.head<2>();
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
  for (std::size_t b = 0; b < beacons; ++b) {
    const Heard& h = heard[b];
    const double range_m = h.range_m / h.count, dz = h.p_map_m.z() - receiver_z_m;
    const Eigen::Vector2d p = h.p_map_m.head<2>() - origin;
    const double weight = h.count / std::max(range_m * range_m, 1e-6);
    const Eigen::Vector3d row(-2 * p.x(), -2 * p.y(), 1.0);
    N.noalias() += weight * row * row.transpose();
    rhs += weight * (range_m * range_m - dz * dz - p.squaredNorm()) * row;
  }
  const Eigen::Vector3d scale = N.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::Matrix3d> ldlt((scale.asDiagonal() * N * scale.asDiagonal()).eval());
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > kInLine)) return false;
  const Eigen::Vector3d solution = scale.asDiagonal() * ldlt.solve(scale.asDiagonal() * rhs);
  const Eigen::Vector2d p_m = origin + solution.head<2>();
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  Eigen::Vector4d m = Eigen::Vector4d::Zero();
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (!takes_part(a, usable)) continue;
    const Eigen::Vector3d& o = state.receiver_p_vehicle_m[a.receiver.index()];
    const Eigen::Vector3d v =
        Eigen::Vector3d(p_m.x(), p_m.y(), o.z()) - state.beacon_p_map_m[a.beacon.index()];
    const double distance = std::max(v.norm(), 1e-3);
    const Eigen::Vector2d u = v.head<2>() / distance;
    const Eigen::Vector4d row(u.x(), u.y(), u.x() * o.x() + u.y() * o.y(), u.y() * o.x() - u.x() * o.y());
    M.noalias() += row * row.transpose();
    m += (observed_range_m(t, a, state) - distance) * row;
  }
  M.diagonal().array() += 1e-9;
  const Eigen::Vector4d fine = M.ldlt().solve(m);
  if (!fine.allFinite()) return false;
  Node& node = t.nodes[s.first_node];
  node.T_map_vehicle = Pose::planar(p_m.x() + fine[0], p_m.y() + fine[1], std::atan2(fine[3], fine[2]));
  node.placed = true;
  return true;
}

}  // namespace octant
