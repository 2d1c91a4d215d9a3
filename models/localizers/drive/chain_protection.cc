// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/chain_protection.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "models/localizers/common/arrival_rejections.h"
#include "models/localizers/common/protection.h"

namespace octant {
namespace {

/// The states' solution without one beacon, relative to that with it.
struct DriveWithout {
  bool determined = false;
  std::pmr::vector<NodeVector> shift{scratch()};
  ChainCovariance covariance;
};

DriveWithout drive_without(Trajectory& t, const Segment& segment, const SharedState& state, BeaconId beacon) {
  set_rejections(t, segment, beacon, Rejection::kUsed, Rejection::kBeaconFault);
  DriveWithout out;
  ChainFactor factor = factor_chain(t, segment, state);
  out.determined = factor.ok;
  if (factor.ok) {
    out.shift = std::move(factor.gradient);
    for (NodeVector& g : out.shift) g = -g;
    factor.solve(out.shift);
    out.covariance = chain_covariance(factor);
  }
  set_rejections(t, segment, beacon, Rejection::kBeaconFault, Rejection::kUsed);
  return out;
}

}  // namespace

std::vector<double> chain_protection(Trajectory& t, const Segment& segment, const SharedState& state,
                                     const ChainCovariance& noise, std::span<const DriveInstant> instants,
                                     std::span<const PoseCovariance> covariances) {
  const int dof = pose_dof(t.motion);
  std::vector<double> worst_m(instants.size(), 0.0), widened(instants.size());
  std::vector<char> bounded(instants.size(), 1);
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const auto P = noise.pose(instants[i].node - segment.first_node, instants[i].alpha, dof);
    widened[i] = std::max(1.0, horizontal_variance(covariances[i]) / horizontal_variance(P));
  }
  std::set<BeaconId> beacons;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i)
    if (t.arrivals[i].rejection == Rejection::kUsed) beacons.insert(t.arrivals[i].beacon);
  for (const BeaconId beacon : beacons) {
    const DriveWithout without = drive_without(t, segment, state, beacon);
    if (!without.determined) return std::vector<double>(instants.size(), 0.0);
    for (std::size_t i = 0; i < instants.size(); ++i) {
      const double shift_m = at_instant(without.shift, segment, instants[i], dof).head<2>().norm();
      const std::size_t k = instants[i].node - segment.first_node;
      const double sigma_m =
          std::sqrt(widened[i] * horizontal_variance(without.covariance.pose(k, instants[i].alpha, dof)));
      if (!(shift_m <= kAtFaultSigmas * sigma_m)) bounded[i] = 0;
      worst_m[i] = std::max(worst_m[i], shift_m + kFaultySigmas * sigma_m);
    }
  }
  for (std::size_t i = 0; i < instants.size(); ++i)
    worst_m[i] = bounded[i] ? protection_level_m(horizontal_variance(covariances[i]), worst_m[i]) : 0.0;
  return worst_m;
}

}  // namespace octant
