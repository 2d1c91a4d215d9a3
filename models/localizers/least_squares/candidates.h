// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "models/localizers/least_squares/consensus.h"
#include "models/localizers/least_squares/search_problem.h"

namespace octant {

struct Candidate {
  PlanarState state;
  double score = 0.0;
  double least_score = 0.0;  ///< no pose that it may lead to scores less
};

/// Circle on which the origin of the vehicle lies.
struct Circle {
  double x_m, y_m, radius_m;
};
/// Intersections of two circles, or twice the point between them where they do not meet; 0 if concentric.
int intersect(const Circle& a, const Circle& b, std::array<PlanarState, 2>& out);

/// The best few of many candidates, best first. Of those closer than apart only the best is kept.
class TopList {
 public:
  TopList(std::size_t size, double apart_m, double apart_rad)
      : size_(size), apart_m_(apart_m), apart_rad_(apart_rad) {
    list_.reserve(size + 1);
  }
  /// Scores beyond it need not be computed to the end.
  [[nodiscard]] double worst() const;
  void offer(const Candidate& candidate);
  [[nodiscard]] const std::pmr::vector<Candidate>& list() const { return list_; }

 private:
  std::size_t size_;
  double apart_m_, apart_rad_;
  std::pmr::vector<Candidate> list_{scratch()};
};

struct SearchOptions {
  int headings = 8;       ///< coarse headings over the full turn
  int max_pairs = 40;     ///< pairs of arrivals whose circles are cut
  int max_cells = 400;    ///< of the grid, where pairs do not do
  std::size_t keep = 10;  ///< candidates that are refined
  /// Where the pose may well be: the first to be held against others.
  std::optional<PlanarState> start{};
  /// Among beacons that are known (no uncertainty), of one epoch, nothing is looked for but poses whose score
  /// is within the margin of the best, or below. Without bounds all that pairs propose is tried.
  bool bounded = true;
  double margin = 2.0;
};

/// Pairs of ranges, spread over the pairs of beacons: first all earliest with earliest, then middle with
/// middle, then mixed.
[[nodiscard]] std::pmr::vector<std::array<std::size_t, 2>> choose_pairs(const SearchProblem& problem,
                                                                        std::size_t max_pairs);

/// Poses that pairs of arrivals of different beacons allow: for each coarse heading the circles about beacon
/// less lever arm are cut; circles that do not quite meet give their closest points.
void propose_from_pairs(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
                        TopList& top);
/// Where a pair's circles meet, with the lever arms at a heading: positions, as `intersect`.
int pair_states(const SearchProblem& problem, const std::array<std::size_t, 2>& pair, double cosine,
                double sine, std::array<PlanarState, 2>& meet);

/// Poses on a grid over the area that the heard beacons' ranges allow; the cycle offset is a median. For
/// cycle offsets, of which pairs of arrivals tell nothing, and for what is mostly bearings.
void propose_from_grid(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
                       TopList& top);

/// What a search found: distinct poses, best first, scored without any widening.
struct SearchResult {
  std::pmr::vector<Candidate> poses{scratch()};
  std::pmr::vector<Eigen::Matrix4d> information{scratch()};  ///< of each
};

/// The whole search for a planar pose, from nothing or from a start.
[[nodiscard]] SearchResult search_pose(const SearchProblem& problem, const SearchOptions& options = {});

}  // namespace octant
