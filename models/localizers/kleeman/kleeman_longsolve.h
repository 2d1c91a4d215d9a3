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

// L. Kleeman, section 5.2: the position from distances to all beacons, as a weighted average of the best
// triples that agree.

struct LongsolveOptions {
  int triples = 7;           ///< averaged, of the 20 that 6 beacons form; at most 32
  int max_uses = 5;          ///< of one beacon's distance in the average
  int min_triples = 3;       ///< no triple is removed when only so many are left
  double recompute_m = 1.0;  ///< the errors of all triples are computed anew after a move longer than this
  double deviation_sigmas = 3.5;  ///< a triple, or a beacon, that deviates more disagrees
  /// How many beacons may be left out in turn, and longsolve run on the others, when what it gives
  /// contradicts its own distances. 0: as published, where a late beacon in the majority of the averaged
  /// triples may outvote the good ones.
  int max_exclusions = 2;
  int min_agreeing = 4;  ///< beacons; where fewer are heard, all of them (never fewer than 3)
  /// And more than this part of those heard. Two beacons in shadows leave four of six, which have one
  /// distance to spare: then one fix in 300 is a coincidence, decimetres off. Half, if a fix that may be
  /// wrong is better than none.
  double agreeing_share = 0.67;
  double ambiguity_margin = 4.0;  ///< two answers are equally good when their chi-squares differ by less
  double max_sigma_m = 1.0;       ///< a sigma of x or y beyond this is poor geometry
  HyperbolicFixOptions hyperbolic{};
};

/// What longsolve keeps from one call to the next: where it was, and the estimated errors of all triples near
/// there.
struct LongsolveMemory {
  bool placed = false;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  bool has_errors = false;
  Eigen::Vector2d errors_at_map_m = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> error;  ///< of x and y of each triple, for distances good to one metre
  std::vector<std::uint16_t> order;    ///< triples, least error first
};

struct LongsolveFix {
  FixStatus status = FixStatus::kTooFewArrivals;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  /// Derivatives of the position by the distances, a column a beacon; each row adds up to zero.
  Eigen::Matrix<double, 2, kKleemanBeacons> gain = Eigen::Matrix<double, 2, kKleemanBeacons>::Zero();
  double offset_m = 0.0;                             ///< by which all distances are too long
  std::array<double, kKleemanBeacons> residual_m{};  ///< distance less offset less what the position explains
  BeaconSet averaged;                                ///< in the triples of the average
  BeaconSet agreeing, late, early;                   ///< by the residuals, of all beacons given
  int triples = 0;                                   ///< in the average
  double chi2 = 0.0;                                 ///< of the agreeing beacons' residuals

  [[nodiscard]] bool ok() const { return status == FixStatus::kOk; }
};

/// Averages the best triples. Three beacons give one triple and no redundancy; with four or more, beacons
/// that are late are told from the others, and where they cannot be there is no fix.
class Longsolve {
 public:
  /// @param beacons  3 to 16, all that there are; those not heard are left out call by call
  Longsolve(std::span<const PlanBeacon> beacons, const LongsolveOptions& options);

  /// Memory of the right size, which solve() then never resizes.
  [[nodiscard]] LongsolveMemory memory() const;

  /// @param valid               beacons whose distances passed validation; a subset of distances.heard
  /// @param scale_sigma         relative sigma of the speed of sound, which all distances share
  /// @return kTooFewArrivals: fewer than three beacons heard. kPoorGeometry: no triple determines the place.
  /// kNoConsensus: too many distances disagree. kAmbiguous: another place explains them as well.
  [[nodiscard]] LongsolveFix solve(const OffsetDistances& distances, BeaconSet valid, double scale_sigma,
                                   LongsolveMemory& memory) const noexcept;

 private:
  using Triple = std::array<std::uint8_t, 3>;
  struct Solution;  ///< of one triple
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
  Eigen::Vector2d low_m_, high_m_;  ///< box round the beacons
};

}  // namespace octant
