// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "models/localizers/least_squares/consensus.h"
#include "models/localizers/least_squares/search_problem.h"

namespace octant {

/// Number of different paths (beacon, receiver) that determine a pose uniquely: a pose with a redundancy of
/// four.
inline constexpr std::size_t kFewestPaths = 7;
/// Sigma up to which the heading counts as determined.
inline constexpr double kHeadingSigmaRad = 0.3;

// A rival of a pose is another pose that explains the arrivals equally well: its score is at most that of the
// pose plus a margin. Contradictions among the arrivals of one beacon (discord) cost every pose the same.
// Each further outlier, an arrival or a shadowed beacon, costs a rival at least the cap, so
//   outliers <= (score + margin - discord) / cap
// bounds their number and that of the beacons involved. The arrivals of all other beacons agree with a rival
// as far as they agree with each other.

/// Costs that arise in any pose from arrivals of one beacon at several receivers. Two ranges differ by at
/// most the distance between their receivers (triangle inequality); otherwise one of them is an outlier.
struct Discord {
  std::pmr::vector<double> cost{scratch()};  ///< cost of each beacon
  /// Marks ranges outside the majority of their beacon's ranges that agree with each other, or all if there
  /// is no majority.
  std::pmr::vector<char> is_odd{scratch()};
  double total = 0.0;
};
[[nodiscard]] Discord discord_of(const SearchProblem& problem, const Consensus& consensus);

/// The bound for a pose with the given score, at the current width of the consensus.
[[nodiscard]] std::size_t most_outliers(const Consensus& consensus, const Discord& discord, double score,
                                        double margin);

/// Returns true if no rival with this number of outliers exists. For every choice of the beacons with
/// outliers, the other arrivals that agree with the pose cover more than kFewestPaths from three beacons that
/// are not collinear, and determine the heading; only one pose satisfies them. Returns false otherwise, or if
/// the test would take long.
[[nodiscard]] bool excludes_rivals(const SearchProblem& problem, Consensus& consensus, const Discord& discord,
                                   const PlanarState& state, std::size_t outliers);

/// Pairs of ranges such that at least one of them is free of outliers for any choice of beacons with
/// outliers: all pairs within sets of n - outliers - 1 beacons, since covering a clique of k takes k - 1. Two
/// different sets are used, because the circles of a pair may intersect at a small angle. A beacon with
/// contradicting arrivals and no majority is represented by two of them.
/// @param outliers  less than the number of beacons minus one
[[nodiscard]] std::pmr::vector<std::array<std::size_t, 2>> covering_pairs(const SearchProblem& problem,
                                                                          const Discord& discord,
                                                                          std::size_t outliers);

}  // namespace octant
