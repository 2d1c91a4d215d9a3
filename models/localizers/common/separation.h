// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "models/ids.h"
#include "models/physics/plane.h"
#include "models/support/scratch.h"
#include "models/trajectory/linearise.h"

namespace octant {

/// The risk that protection levels stand for: a fix that is ok lies beyond its level with at most this
/// probability,
///   half of it without a fault:   exp(-k^2 / 2) = kProtectionRisk / 2
///   half with one beacon at fault: kBeaconsAtRisk kBeaconFaultRate exp(-k^2 / 2) = kProtectionRisk / 2
/// for a beacon at fault, all or some of its arrivals off by anything, in at most kBeaconFaultRate of the
/// fixes, among kBeaconsAtRisk that are heard; for errors that are normal with the stated sigmas. What it
/// does not stand for: two beacons at fault at once by errors that agree, sigmas stated too small, a wrong
/// deployment.
inline constexpr double kProtectionRisk = 1e-5, kBeaconFaultRate = 1e-3, kBeaconsAtRisk = 10.0;
/// sqrt(-2 ln(5e-6)) and sqrt(-2 ln(5e-4)), of the distance in the plane, in sigmas of its longer axis.
inline constexpr double kFaultFreeSigmas = 4.941, kFaultySigmas = 3.899;

/// Sigmas beyond which a beacon counts as at fault: of a normal deviate, one in 1e9.
inline constexpr double kAtFaultSigmas = 6.0;

/// Variance of a position in the plane along its longer axis. @param P  x, y before all else
template <class Derived>
[[nodiscard]] double horizontal_variance(const Eigen::MatrixBase<Derived>& P) {
  return largest_eigenvalue(P(0, 0), P(0, 1), P(1, 1));
}

/// A fix held against what it would be without one of its beacons (solution separation: Blanch et al. 2012,
/// Advanced RAIM user algorithm description). With A, g the information and gradient of all observations in
/// use at the fix, A_i, g_i those of the beacon's arrivals r_i,
///   shift = (A - A_i)^-1 (g_i - g),   misfit = r_i' r_i + g_i' (A - A_i)^-1 g_i
/// whatever the beacon's arrivals are off by, the fix without them is not, so the fix is off by no more than
/// the shift and the error of that fix. Of a beacon without fault the misfit is chi-square distributed with a
/// degree of freedom for each of its arrivals.
struct BeaconSeparation {
  BeaconId beacon;
  int arrivals = 0;
  bool determined = false;   ///< without it there is still a fix
  double shift_m = 0.0;      ///< in the plane
  double variance_m2 = 0.0;  ///< of the fix without it, along the longer axis; noise alone
  double misfit = 0.0;       ///< over what the beacon's errors without a fault explain of it
};

/// What a fix's redundancy says of it.
struct Protection {
  double level_m = 0.0;  ///< horizontal protection level; 0: without one of its beacons there would be no fix
  BeaconId at_fault;     ///< the beacon whose arrivals contradict the others most, if any does beyond chance
  int beacons = 0;       ///< in use
};

/// The level of a fix that is held against others, of which each does without one beacon.
[[nodiscard]] inline double protection_level_m(double variance_m2, double worst_m) {
  const double fault_free = kFaultFreeSigmas * (variance_m2 > 0 ? std::sqrt(variance_m2) : 0.0);
  return fault_free > worst_m ? fault_free : worst_m;
}

/// Sums over the whitened rows of a least-squares fix, x and y first among its state, of all and beacon by
/// beacon: from them what the fix would be without each of its beacons.
class BeaconSums {
 public:
  /// @param beacons  for which there is room from the start
  explicit BeaconSums(int state_size, std::size_t beacons = 0) : n_(state_size), all_(state_size) {
    beacons_.reserve(beacons);
  }
  void clear() {
    all_ = RowSum(n_);
    beacons_.clear();
  }

  /// A row that is no beacon's: odometry, a heading from elsewhere.
  template <class Row>
  void add(const Row& by_state, double residual) {
    all_.add(by_state, residual);
  }
  /// @param common  whitened variance of what the beacon's errors without a fault add to the row
  template <class Row>
  void add(BeaconId beacon, const Row& by_state, double residual, double common) {
    all_.add(by_state, residual);
    RowSum& of = of_beacon(beacon);
    of.add(by_state, residual);
    ++of.rows;
    of.common += common;
  }
  /// A number of the state of which nothing else may be known.
  void add_information(int at, double information) { all_.A(at, at) += information; }

  [[nodiscard]] std::pmr::vector<BeaconSeparation> separations() const;
  /// @param variance_m2  of the fix in the plane, calibration's part included: by as much as that widens the
  /// noise's, the fix without a beacon is widened too
  [[nodiscard]] Protection protection(double variance_m2) const;
  /// The level alone, of a fix that keeps all of its beacons: 0 where one of them is at fault.
  [[nodiscard]] double level_m(double variance_m2) const {
    const Protection found = protection(variance_m2);
    return found.at_fault.valid() ? 0.0 : found.level_m;
  }

 private:
  struct RowSum {
    NodeBlock A;
    NodeVector g;
    double squares = 0.0, common = 0.0;
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
  [[nodiscard]] RowSum& of_beacon(BeaconId beacon);
  [[nodiscard]] BeaconSeparation separation(const OfBeacon& of) const;

  int n_;
  RowSum all_;
  std::pmr::vector<OfBeacon> beacons_{scratch()};
};

}  // namespace octant
