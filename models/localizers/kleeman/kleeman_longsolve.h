// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/fix.h"
#include "models/localizers/kleeman/kleeman_validation.h"
#include "models/localizers/least_squares/hyperbolic_fix.h"

namespace octant {

// L. Kleeman, section 5.2: position from distances to all beacons, as a weighted average of the best triples
// that agree.

struct LongsolveOptions {
  int triples = 7;                ///< number averaged, of the 20 triples of 6 beacons; at most 32
  int max_uses = 5;               ///< largest number of uses of one beacon's distance in the average
  int min_triples = 3;            ///< triples are removed only while more than these are left
  double recompute_m = 1.0;       ///< the errors of all triples are computed again after a longer move
  double deviation_sigmas = 3.5;  ///< a triple or beacon with a larger deviation disagrees
  /// Number of beacons that may be excluded, one after the other, if the result contradicts its own
  /// distances. Longsolve is then run on the others. 0: as published; a late beacon in the majority of the
  /// averaged triples may then outvote the good ones.
  int max_exclusions = 2;
  int min_agreeing = 4;  ///< number of beacons that must agree, or all (at least 3) if fewer are received
  /// Share of the received beacons that must agree. With two shadowed beacons out of six, four remain, with
  /// one redundant distance; then one fix in 300 is a coincidence with an error of decimetres. Use one half
  /// if a fix that may be wrong is better than none.
  double agreeing_share = 0.67;
  double ambiguity_margin = 4.0;  ///< two solutions are equally good if their chi-squares differ by less
  double max_sigma_m = 1.0;       ///< sigmas of x or y above this are poor geometry
  HyperbolicFixOptions hyperbolic{};
};

/// State of longsolve between calls: last position, and estimated errors of all triples near it.
struct LongsolveMemory {
  bool placed = false;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  bool has_errors = false;
  Eigen::Vector2d errors_at_map_m = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d>
      error;  ///< errors of x and y of each triple, for distances with a sigma of one metre
  std::vector<std::uint16_t> order;  ///< triples in order of their errors, smallest first
};

struct LongsolveFix {
  FixStatus status = FixStatus::kTooFewArrivals;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  /// Derivatives of the position by the distances, one column for each beacon; the sum of each row is zero.
  Eigen::Matrix<double, 2, kKleemanBeacons> gain = Eigen::Matrix<double, 2, kKleemanBeacons>::Zero();
  double offset_m = 0.0;                             ///< common excess of all distances
  std::array<double, kKleemanBeacons> residual_m{};  ///< distance minus offset minus predicted distance
  BeaconSet averaged;                                ///< beacons in the averaged triples
  BeaconSet agreeing, late, early;                   ///< judged by the residuals of all given beacons
  int triples = 0;                                   ///< number of averaged triples
  double chi2 = 0.0;                                 ///< chi-square of the agreeing beacons

  [[nodiscard]] bool ok() const { return status == FixStatus::kOk; }
};

/// Averages the best triples. Three beacons give one triple without redundancy. With four or more, late
/// beacons are identified; if they cannot be, there is no fix.
class Longsolve {
 public:
  /// @param beacons  all 3 to 16 beacons; those without a distance are skipped in each call
  Longsolve(std::span<const PlanBeacon> beacons, const LongsolveOptions& options);

  /// Memory of the required size, which solve() does not resize.
  [[nodiscard]] LongsolveMemory memory() const;

  /// @param valid               beacons whose distances passed validation; a subset of distances.heard
  /// @param scale_sigma         relative sigma of the speed of sound, common to all distances
  /// @return kTooFewArrivals: fewer than three beacons. kPoorGeometry: no triple determines the position.
  /// kNoConsensus: too many distances disagree. kAmbiguous: another position explains them equally well.
  [[nodiscard]] LongsolveFix solve(const OffsetDistances& distances, BeaconSet valid, double scale_sigma,
                                   LongsolveMemory& memory) const noexcept;

 private:
  using Triple = std::array<std::uint8_t, 3>;
  struct Solution;  ///< solution of one triple
  struct Average;
  struct Problem;

  [[nodiscard]] LongsolveFix attempt(const Problem& problem, BeaconSet wanted, const Eigen::Vector2d& start,
                                     LongsolveMemory& memory) const noexcept;
  [[nodiscard]] LongsolveFix search_exclusions(const Problem& problem, const Eigen::Vector2d& start,
                                               LongsolveMemory& memory) const noexcept;
  [[nodiscard]] bool quick(const Problem& problem, BeaconSet subset, const LongsolveMemory& memory,
                           Eigen::Vector2d& p) const noexcept;
  [[nodiscard]] bool solve_triple(const Problem& problem, std::uint16_t triple, const Eigen::Vector2d& start,
                                  Solution& solution) const noexcept;
  void estimate_errors(const Eigen::Vector2d& at, LongsolveMemory& memory) const noexcept;
  void resolve(const Problem& problem, LongsolveFix& fix) const noexcept;
  [[nodiscard]] bool acceptable(const Problem& problem, const LongsolveFix& fix) const noexcept;
  [[nodiscard]] bool ambiguous(const Problem& problem, const LongsolveFix& fix,
                               LongsolveMemory& memory) const noexcept;
  [[nodiscard]] Eigen::Vector2d first_guess(BeaconSet valid) const noexcept;
  [[nodiscard]] double outside_m(const Eigen::Vector2d& p) const noexcept;
  [[nodiscard]] bool within(const Triple& triple, BeaconSet set) const noexcept {
    return set[triple[0]] && set[triple[1]] && set[triple[2]];
  }

  std::vector<PlanBeacon> beacons_;
  std::vector<Triple> triples_;
  LongsolveOptions options_;
  Eigen::Vector2d low_m_, high_m_;  ///< bounding box of the beacons
};

}  // namespace octant
