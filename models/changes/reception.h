// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace octant {

/// A beacon or receiver that was within reach and was received far less than expected.
struct Silence {
  std::string subject;                    ///< "B3", "robot/r0"
  double expected = 0.0, received = 0.0;  ///< arrivals, from since_s on
  bool is_partial = false;                ///< before since_s it was received as expected
  double since_s = 0.0;                   ///< time in the recording; for is_partial
};

/// Arrivals received from one beacon, or by one receiver, and the number expected.
struct Reception {
  double received = 0.0, expected = 0.0;  ///< numbers over the whole visit
  bool is_silent = false;
  Silence silence;  ///< for is_silent; the subject is left empty
};

/// Arrivals along the path of a visit, for a test of silence that needs no firing schedule.
///
/// An arrival shows that something was received at that instant and place. It is of beacon b with the
/// probability rho(d_b) / sum_i rho(d_i), where d are the distances to the beacons and rho is the relative
/// rate of reception at a distance (Cox's partial likelihood with Breslow's estimate of rho). The number
/// expected of b is therefore the sum over the arrivals of all others of rho(d_b) / sum_{i != b} rho(d_i).
/// A beacon that was out of reach has an expectation of zero and cannot be silent.
///
/// The null hypothesis is that b is received at least three quarters as often as the others. Counts are
/// negative binomial: Poisson with a rate that varies between beacons (obstacles, antennas), by as much as
/// the counts of the others show. Final parts of the recording are tested too, for a beacon that stops half
/// way. Receivers of a vehicle are tested in the same way, with equal distances.
class ReceptionLog {
 public:
  /// @param reach_m  largest distance at which reception is known, infinite where no limit is known
  ReceptionLog(std::size_t subjects, double reach_m) : subjects_(subjects), reach_m_(reach_m) {}
  /// Adds an arrival; in the order of time. @param distance_m  of each subject; infinite: not in view
  void add(double time_s, std::size_t subject, std::span<const double> distance_m);
  /// @param cluster  number of arrivals that are received or lost together
  [[nodiscard]] std::vector<Reception> judge(double cluster) const;

 private:
  friend class ReceptionJudge;
  std::size_t subjects_;
  double reach_m_;
  std::vector<double> time_s_;
  std::vector<std::size_t> subject_;  ///< subject of each arrival
  std::vector<float> distance_m_;     ///< distances of all subjects, arrival by arrival
};

/// Probability that a negative binomial count is at most this large.
/// @param variance  of the rate, relative to its mean squared; positive
[[nodiscard]] double negative_binomial_at_most(double count, double mean, double variance);

}  // namespace octant
