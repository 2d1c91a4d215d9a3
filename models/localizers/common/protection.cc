// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/protection.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "models/trajectory/linearise.h"
#include "models/trajectory/planar.h"

namespace octant {
namespace {

constexpr double kDetermined = 1e-9;  ///< smallest pivot of an information whose diagonal is one

/// Sums over the rows of one beacon, or of all that are in use.
struct RowSum {
  NodeBlock A;
  NodeVector g;
  double squares = 0.0, common = 0.0;  ///< sum of the whitened variances that the beacon's own errors add
  int rows = 0;

  explicit RowSum(int n) : A(NodeBlock::Zero(n, n)), g(NodeVector::Zero(n)) {}
  template <class Row>
  void add(const Row& by, double residual) {
    A.noalias() += by.transpose() * by;
    g.noalias() += residual * by.transpose();
    squares += residual * residual;
  }
};

struct OfBeacon {
  BeaconId beacon;
  RowSum sum;
};

/// Sums by beacon and of all rows.
class BeaconSums {
 public:
  BeaconSums(const Trajectory& t, const Segment& segment, const SharedState& state,
             const BeaconErrors& errors)
      : n_(t.block_size()), errors_(errors), all_(n_) {
    Segment rows = segment;
    if (n_ == 3 && segment.last_node - segment.first_node == 1 && has_planar_arrivals(t, segment, state)) {
      add_planar(t, segment, state);
      rows.first_arrival = rows.last_arrival;
    }
    for_each_row(t, rows, state, [&](const ObservationRow& row) {
      all_.add(row.by_node, row.residual);
      if (row.kind != RowKind::kTof) return;
      RowSum& of = of_beacon(row.beacon);
      of.add(row.by_node, row.residual);
      Eigen::Matrix<double, 1, 5> by;
      by << row.by_beacon, row.by_delay, row.by_speed;
      count(of, row.beacon, by);
    });
    // A rotation that nothing tells is as unknown as an angle can be, and takes no part.
    for (int i = t.motion == Motion::kPlanar ? 2 : 3; i < pose_dof(t.motion); ++i)
      all_.A(i, i) += 1.0 / (std::numbers::pi * std::numbers::pi);
  }

  [[nodiscard]] const RowSum& all() const { return all_; }
  [[nodiscard]] const std::pmr::vector<OfBeacon>& beacons() const { return beacons_; }

 private:
  void add_planar(const Trajectory& t, const Segment& segment, const SharedState& state) {
    const PlanarNode at(t.nodes[segment.first_node].T_map_vehicle);
    PlanarWhitening whitening(state.speed_offset(t.run));
    for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
      const ArrivalObservation& a = t.arrivals[i];
      if (a.rejection != Rejection::kUsed) continue;
      whitening.take(a);
      const PlanarArrival row(a, at, state, whitening);
      const Eigen::RowVector3d by(row.by_x(), row.by_y(), row.by_heading);
      all_.add(by, row.residual);
      RowSum& of = of_beacon(a.beacon);
      of.add(by, row.residual);
      Eigen::Matrix<double, 1, 5> by_calibration;
      by_calibration << -row.by_distance * row.direction[0], -row.by_distance * row.direction[1],
          -row.by_distance * row.direction[2], whitening.by_tof,
          -row.by_distance * row.distance_m * whitening.slowness;
      count(of, a.beacon, by_calibration);
    }
  }

  void count(RowSum& of, BeaconId beacon, const Eigen::Matrix<double, 1, 5>& by) {
    ++of.rows;
    of.common += std::pow(by[3] * errors_.common_sigma_s, 2);
    if (beacon.index() < errors_.calibration.size())
      of.common += std::max(0.0, by.dot(errors_.calibration[beacon.index()] * by.transpose()));
  }

  RowSum& of_beacon(BeaconId beacon) {
    for (OfBeacon& b : beacons_)
      if (b.beacon == beacon) return b.sum;
    beacons_.push_back({beacon, RowSum(n_)});
    return beacons_.back().sum;
  }

  int n_;
  BeaconErrors errors_;
  RowSum all_;
  std::pmr::vector<OfBeacon> beacons_{scratch()};
};

/// Inverse of an information matrix, judged in units in which its diagonal is one; false where it is
/// singular.
bool invert(const NodeBlock& A, NodeBlock& inverse) {
  const NodeVector scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const NodeBlock scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const Eigen::LDLT<NodeBlock> ldlt(scaled);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > kDetermined)) return false;
  inverse = scale.asDiagonal() * ldlt.solve(NodeBlock::Identity(A.rows(), A.cols())) * scale.asDiagonal();
  return inverse.allFinite();
}

/// Quantile of the chi-square distribution at kAtFaultSigmas (Wilson and Hilferty 1931).
double misfit_limit(int degrees) {
  const double v = 2.0 / (9.0 * degrees);
  return degrees * std::pow(1.0 - v + kAtFaultSigmas * std::sqrt(v), 3);
}

BeaconSeparation separation(const OfBeacon& of, const RowSum& all) {
  BeaconSeparation out;
  out.beacon = of.beacon;
  out.arrivals = of.sum.rows;
  NodeBlock P;
  out.determined = invert(all.A - of.sum.A, P);
  if (!out.determined) return out;
  const NodeVector shift = P * (of.sum.g - all.g);
  out.shift_m = shift.head<2>().norm();
  out.variance_m2 = horizontal_variance(P);
  // Errors that are common to its arrivals stretch the misfit by at most this.
  out.misfit = (of.sum.squares + of.sum.g.dot(P * of.sum.g)) / (1.0 + of.sum.common);
  return out;
}

}  // namespace

std::pmr::vector<BeaconSeparation> separations(const Trajectory& t, const Segment& segment,
                                               const SharedState& state, const BeaconErrors& errors) {
  const BeaconSums sums(t, segment, state, errors);
  std::pmr::vector<BeaconSeparation> out(scratch());
  out.reserve(sums.beacons().size());
  for (const OfBeacon& of : sums.beacons()) out.push_back(separation(of, sums.all()));
  return out;
}

Protection protection_of(const Trajectory& t, const Segment& segment, const SharedState& state,
                         const PoseCovariance& covariance, const BeaconErrors& errors) {
  Protection out;
  const BeaconSums sums(t, segment, state, errors);
  NodeBlock P;
  if (sums.beacons().empty() || !invert(sums.all().A, P)) return out;
  const double variance_m2 = horizontal_variance(covariance);
  const double widened = std::max(1.0, variance_m2 / horizontal_variance(P));
  double worst_m = 0.0, worst_misfit = 1.0;
  bool all_determined = true;
  for (const OfBeacon& of : sums.beacons()) {
    const BeaconSeparation s = separation(of, sums.all());
    ++out.beacons;
    all_determined = all_determined && s.determined;
    if (!s.determined) continue;
    worst_m = std::max(worst_m, s.shift_m + kFaultySigmas * std::sqrt(widened * s.variance_m2));
    const double misfit = s.misfit / misfit_limit(s.arrivals);
    if (misfit > worst_misfit) {
      worst_misfit = misfit;
      out.at_fault = s.beacon;
    }
  }
  if (all_determined) out.level_m = protection_level_m(variance_m2, worst_m);
  return out;
}

}  // namespace octant
