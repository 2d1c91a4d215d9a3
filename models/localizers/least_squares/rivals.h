// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "models/localizers/least_squares/consensus.h"
#include "models/localizers/least_squares/search_problem.h"

namespace octant {

/// Different paths (beacon, receiver) that tell one pose from all others: a pose and four to spare.
inline constexpr std::size_t kFewestPaths = 7;
/// Of a heading that the arrivals tell.
inline constexpr double kHeadingSigmaRad = 0.3;

// A rival of a pose is another that explains the arrivals as well, or better: its score is at most the pose's
// and a margin. What a beacon's arrivals contradict each other by costs any pose the same; each outlier
// beside these, an arrival or a beacon in a shadow, costs a rival the cap at least, so
//   outliers <= (score + margin - discord) / cap
// bounds them, and with them the beacons that they are of. All other beacons' arrivals agree with a rival, as
// far as they agree with each other.

/// What arrivals of one beacon at several receivers cost in any pose: two ranges differ by no more than what
/// is between their receivers (triangle inequality), so where they do, one of them is an outlier.
struct Discord {
  std::pmr::vector<double> cost{scratch()};  ///< of each beacon
  /// Of each range: it is no part of the majority of its beacon's that agree with each other, or there is
  /// none.
  std::pmr::vector<char> is_odd{scratch()};
  double total = 0.0;
};
[[nodiscard]] Discord discord_of(const SearchProblem& problem, const Consensus& consensus);

/// That bound for a pose of the given score, at the consensus' present width.
[[nodiscard]] std::size_t most_outliers(const Consensus& consensus, const Discord& discord, double score,
                                        double margin);

/// Whether no rival with so many outliers can exist: whichever beacons they are of, of the arrivals that
/// agree with the pose those of the others, which agree with the rival too, are over kFewestPaths of three
/// beacons that are not in line, and tell the heading; there is one pose alone that they agree on. False
/// where that is not so, or where it would take long to tell.
[[nodiscard]] bool excludes_rivals(const SearchProblem& problem, Consensus& consensus, const Discord& discord,
                                   const PlanarState& state, std::size_t outliers);

/// Pairs of ranges of which one at least is without an outlier, whichever beacons so many outliers are of:
/// all pairs within sets of beacons, n - outliers - 1 of them, as a clique of k is covered by k - 1 and no
/// fewer. Twice, with other sets, as a pair may cut its circles flatly. A beacon whose arrivals contradict
/// each other without a majority is in them by two of them.
/// @param outliers  fewer than beacons less one
[[nodiscard]] std::pmr::vector<std::array<std::size_t, 2>> covering_pairs(const SearchProblem& problem,
                                                                          const Discord& discord,
                                                                          std::size_t outliers);

}  // namespace octant
