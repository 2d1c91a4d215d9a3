// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/protection.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "models/trajectory/linearise.h"
#include "models/trajectory/planar.h"

namespace octant {
namespace {

constexpr double kNoise = 3.29;          ///< sigmas, two-sided 0.1 %
constexpr double kNonCentrality = 4.13;  ///< 3.29 + 0.84
constexpr double kUnnoticed = 1e-6;      ///< of a beacon's own information

struct OfBeacon {
  BeaconId beacon;
  double count = 0.0;
  NodeVector by_state;
};

}  // namespace

double horizontal_protection_m(const Trajectory& t, const Segment& segment, const SharedState& state,
                               const PoseCovariance& covariance) {
  const int n = t.block_size();
  NodeBlock A = NodeBlock::Zero(n, n);
  std::pmr::vector<OfBeacon> beacons(scratch());
  const auto add = [&](BeaconId beacon, const auto& by_state) {
    auto at =
        std::find_if(beacons.begin(), beacons.end(), [&](const OfBeacon& b) { return b.beacon == beacon; });
    if (at == beacons.end()) {
      beacons.push_back({beacon, 0.0, NodeVector::Zero(n)});
      at = beacons.end() - 1;
    }
    at->count += 1.0;
    at->by_state += by_state;
  };
  Segment rows = segment;
  if (n == 3 && segment.last_node - segment.first_node == 1 && has_planar_arrivals(t, segment, state)) {
    const PlanarNode at(t.nodes[segment.first_node].T_map_vehicle);
    PlanarWhitening whitening(state.speed_offset(t.run));
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
      const ArrivalObservation& a = t.arrivals[i];
      if (a.rejection != Rejection::kUsed) continue;
      whitening.take(a);
      const PlanarArrival row(a, at, state, whitening);
      const Eigen::Vector3d by(row.by_x(), row.by_y(), row.by_heading);
      sum += by.lazyProduct(by.transpose());
      add(a.beacon, by);
    }
    A = sum;
    rows.first_arrival = rows.last_arrival;
  }
  for_each_row(t, rows, state, [&](const ObservationRow& row) {
    A.noalias() += row.by_node.transpose() * row.by_node;
    if (row.kind == RowKind::kTof) add(row.beacon, row.by_node.transpose());
  });
  const NodeVector scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  // A heading that nothing tells takes no part.
  const NodeBlock scaled = scale.asDiagonal() * A * scale.asDiagonal() + 1e-12 * NodeBlock::Identity(n, n);
  const Eigen::LDLT<NodeBlock> ldlt(scaled);
  if (beacons.empty() || ldlt.info() != Eigen::Success) return 0.0;
  double worst_m = 0.0;
  for (const OfBeacon& b : beacons) {
    const NodeVector shift = scale.asDiagonal() * ldlt.solve(scale.asDiagonal() * b.by_state);
    const double remaining = b.count - b.by_state.dot(shift);
    if (!(remaining > kUnnoticed * b.count)) return 0.0;
    worst_m = std::max(worst_m, kNonCentrality / std::sqrt(remaining) * shift.head<2>().norm());
  }
  const double largest = largest_eigenvalue(covariance(0, 0), covariance(0, 1), covariance(1, 1));
  return worst_m + kNoise * std::sqrt(std::max(0.0, largest));
}

}  // namespace octant
