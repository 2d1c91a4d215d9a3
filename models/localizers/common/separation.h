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

/// Integrity risk of protection levels. The error of a fix that is ok exceeds its level with at most this
/// probability,
///   half of it without a fault:     exp(-k^2 / 2) = kProtectionRisk / 2
///   half with one faulty beacon:    kBeaconsAtRisk kBeaconFaultRate exp(-k^2 / 2) = kProtectionRisk / 2
/// All or some arrivals of the faulty beacon may have arbitrary errors, in at most kBeaconFaultRate of the
/// fixes, among kBeaconsAtRisk received beacons. Other errors are normal with the given sigmas. Not covered
/// are two faulty beacons with consistent errors, sigmas that are too small, and a wrong deployment.
inline constexpr double kProtectionRisk = 1e-5, kBeaconFaultRate = 1e-3, kBeaconsAtRisk = 10.0;
/// sqrt(-2 ln(5e-6)) and sqrt(-2 ln(5e-4)), for the planar distance in sigmas of its major axis.
inline constexpr double kFaultFreeSigmas = 4.941, kFaultySigmas = 3.899;

/// Threshold above which a beacon counts as faulty; a normal deviate exceeds it once in 1e9.
inline constexpr double kAtFaultSigmas = 6.0;

/// Variance of a planar position along its major axis. @param P  covariance that begins with x, y
template <class Derived>
[[nodiscard]] double horizontal_variance(const Eigen::MatrixBase<Derived>& P) {
  return largest_eigenvalue(P(0, 0), P(0, 1), P(1, 1));
}

/// Comparison of a fix with the fix without one of its beacons (solution separation: Blanch et al. 2012,
/// Advanced RAIM user algorithm description). With information A and gradient g of all observations in use at
/// the fix, and A_i, g_i of the beacon's arrivals r_i,
///   shift = (A - A_i)^-1 (g_i - g),   misfit = r_i' r_i + g_i' (A - A_i)^-1 g_i
/// The fix without the beacon does not depend on the errors of its arrivals. The error of the fix is
/// therefore at most the shift plus the error of the fix without the beacon. The misfit of a fault-free
/// beacon is chi-square distributed with one degree of freedom for each of its arrivals.
struct BeaconSeparation {
  BeaconId beacon;
  int arrivals = 0;
  bool determined = false;   ///< there is still a fix without it
  double shift_m = 0.0;      ///< planar shift
  double variance_m2 = 0.0;  ///< variance of the fix without it along the major axis, due to noise only
  double misfit = 0.0;       ///< misfit relative to the errors of a fault-free beacon
};

/// Result of the integrity test of a fix.
struct Protection {
  double level_m = 0.0;  ///< horizontal protection level; 0: without one of its beacons there would be no fix
  BeaconId at_fault;     ///< beacon that contradicts the others most, if significantly
  int beacons = 0;       ///< number in use
};

/// Protection level of a fix from its variance and the worst of the fixes without one beacon.
[[nodiscard]] inline double protection_level_m(double variance_m2, double worst_m) {
  const double fault_free = kFaultFreeSigmas * (variance_m2 > 0 ? std::sqrt(variance_m2) : 0.0);
  return fault_free > worst_m ? fault_free : worst_m;
}

/// Sums over the whitened rows of a least-squares fix, in total and for each beacon, from which the fix
/// without each beacon follows. The state begins with x and y.
class BeaconSums {
 public:
  /// @param beacons  number for which memory is reserved
  explicit BeaconSums(int state_size, std::size_t beacons = 0) : n_(state_size), all_(state_size) {
    beacons_.reserve(beacons);
  }
  void clear() {
    all_ = RowSum(n_);
    beacons_.clear();
  }

  /// Adds a row that belongs to no beacon: odometry or an external heading.
  template <class Row>
  void add(const Row& by_state, double residual) {
    all_.add(by_state, residual);
  }
  /// Adds a row of a beacon. @param common  whitened variance that the errors of a fault-free beacon add to
  /// the row
  template <class Row>
  void add(BeaconId beacon, const Row& by_state, double residual, double common) {
    all_.add(by_state, residual);
    RowSum& of = of_beacon(beacon);
    of.add(by_state, residual);
    ++of.rows;
    of.common += common;
  }
  /// Adds information about one component of the state, which may otherwise be undetermined.
  void add_information(int at, double information) { all_.A(at, at) += information; }

  [[nodiscard]] std::pmr::vector<BeaconSeparation> separations() const;
  /// @param variance_m2  planar variance of the fix including the calibration. The fix without a beacon is
  /// inflated by the ratio of this variance to that of the noise.
  [[nodiscard]] Protection protection(double variance_m2) const;
  /// Protection level of a fix that uses all of its beacons; 0 if one of them is faulty.
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
