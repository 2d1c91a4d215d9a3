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
  double least_score = 0.0;  ///< lower bound of the scores of poses that it may lead to
};

/// Circle that contains the origin of the vehicle.
struct Circle {
  double x_m, y_m, radius_m;
};
/// Intersections of two circles. If they do not meet, the point between them is returned twice; 0 for
/// concentric circles.
int intersect(const Circle& a, const Circle& b, std::array<PlanarState, 2>& out);

/// The best few of many candidates, best first. Among candidates that are closer than a distance only the
/// best is kept.
class TopList {
 public:
  TopList(std::size_t size, double apart_m, double apart_rad)
      : size_(size), apart_m_(apart_m), apart_rad_(apart_rad) {
    list_.reserve(size + 1);
  }
  /// Scores above this bound need not be evaluated completely.
  [[nodiscard]] double worst() const;
  void offer(const Candidate& candidate);
  [[nodiscard]] const std::pmr::vector<Candidate>& list() const { return list_; }

 private:
  std::size_t size_;
  double apart_m_, apart_rad_;
  std::pmr::vector<Candidate> list_{scratch()};
};

struct SearchOptions {
  int headings = 8;       ///< number of coarse headings in a full turn
  int max_pairs = 40;     ///< number of pairs of arrivals whose circles are intersected
  int max_cells = 400;    ///< number of cells of the grid that is used if pairs do not suffice
  std::size_t keep = 10;  ///< number of candidates that are refined
  /// Expected pose, which is tried first.
  std::optional<PlanarState> start{};
  /// For known beacons and a single epoch, restricts the search to poses whose score is within the margin of
  /// the best. Otherwise all proposals of pairs are tried.
  bool bounded = true;
  double margin = 2.0;
};

/// Pairs of ranges, distributed over the pairs of beacons: first earliest with earliest, then middle with
/// middle, then mixed.
[[nodiscard]] std::pmr::vector<std::array<std::size_t, 2>> choose_pairs(const SearchProblem& problem,
                                                                        std::size_t max_pairs);

/// Proposes poses from pairs of arrivals of different beacons. For each coarse heading it intersects the
/// circles around beacon minus lever arm; circles that do not quite meet give their closest points.
void propose_from_pairs(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
                        TopList& top);
/// Intersections of a pair's circles for a given heading, like `intersect`.
int pair_states(const SearchProblem& problem, const std::array<std::size_t, 2>& pair, double cosine,
                double sine, std::array<PlanarState, 2>& meet);

/// Proposes poses on a grid over the area that the received ranges allow, with the median as cycle offset.
/// For cycle offsets, which pairs of arrivals do not determine, and for epochs with mostly bearings.
void propose_from_grid(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
                       TopList& top);

/// Result of a search: distinct poses, best first, scored without widening.
struct SearchResult {
  std::pmr::vector<Candidate> poses{scratch()};
  std::pmr::vector<Eigen::Matrix4d> information{scratch()};  ///< information matrix of each pose
};

/// Complete search for a planar pose, with or without an expected pose.
[[nodiscard]] SearchResult search_pose(const SearchProblem& problem, const SearchOptions& options = {});

}  // namespace octant
