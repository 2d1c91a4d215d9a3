// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/chain_protection.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "models/localizers/common/protection.h"
#include "models/trajectory/planar.h"

namespace octant {
namespace {

constexpr double kContradictionSigmas = 6.0;  ///< one in 1e9, as for one fix

double longer_axis_m2(const Eigen::Ref<const Eigen::MatrixXd>& P) {
  return largest_eigenvalue(P(0, 0), P(0, 1), P(1, 1));
}

/// The states' solution without one beacon, relative to that with it.
struct DriveWithout {
  bool determined = false;
  std::pmr::vector<NodeVector> shift{scratch()};
  ChainCovariance covariance;
};

DriveWithout drive_without(Trajectory& t, const Segment& segment, const SharedState& state, BeaconId beacon) {
  std::vector<std::size_t> left_out;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    ArrivalObservation& a = t.arrivals[i];
    if (a.beacon != beacon || a.rejection != Rejection::kUsed) continue;
    a.rejection = Rejection::kBeaconFault;
    left_out.push_back(i);
  }
  DriveWithout out;
  ChainFactor factor = factor_chain(t, segment, state);
  out.determined = factor.ok;
  if (factor.ok) {
    out.shift = std::move(factor.gradient);
    for (NodeVector& g : out.shift) g = -g;
    factor.solve(out.shift);
    out.covariance = chain_covariance(factor);
  }
  for (const std::size_t i : left_out) t.arrivals[i].rejection = Rejection::kUsed;
  return out;
}

}  // namespace

std::vector<double> chain_protection(Trajectory& t, const Segment& segment, const SharedState& state,
                                     const ChainCovariance& noise, std::span<const DriveInstant> instants,
                                     std::span<const PoseCovariance> covariances) {
  std::vector<double> worst_m(instants.size(), 0.0), widened(instants.size());
  std::vector<char> bounded(instants.size(), 1);
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const auto P = noise.planar_pose(instants[i].node - segment.first_node, instants[i].alpha);
    widened[i] = std::max(1.0, longer_axis_m2(covariances[i]) / longer_axis_m2(P));
  }
  std::set<BeaconId> beacons;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i)
    if (t.arrivals[i].rejection == Rejection::kUsed) beacons.insert(t.arrivals[i].beacon);
  for (const BeaconId beacon : beacons) {
    const DriveWithout without = drive_without(t, segment, state, beacon);
    if (!without.determined) return std::vector<double>(instants.size(), 0.0);
    for (std::size_t i = 0; i < instants.size(); ++i) {
      const std::size_t k = instants[i].node - segment.first_node;
      const double alpha = k + 1 < without.shift.size() ? instants[i].alpha : 0.0;
      Eigen::Vector2d shift = (1.0 - alpha) * without.shift[k].head<2>();
      if (alpha > 0.0) shift += alpha * without.shift[k + 1].head<2>();
      const double sigma_m =
          std::sqrt(widened[i] * longer_axis_m2(without.covariance.planar_pose(k, instants[i].alpha)));
      if (!(shift.norm() <= kContradictionSigmas * sigma_m)) bounded[i] = 0;
      worst_m[i] = std::max(worst_m[i], shift.norm() + kFaultySigmas * sigma_m);
    }
  }
  for (std::size_t i = 0; i < instants.size(); ++i)
    worst_m[i] = bounded[i] ? protection_level_m(longer_axis_m2(covariances[i]), worst_m[i]) : 0.0;
  return worst_m;
}

}  // namespace octant
