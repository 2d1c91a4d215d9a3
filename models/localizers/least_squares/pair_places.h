// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/least_squares/candidates.h"
#include "models/localizers/least_squares/consensus.h"
#include "models/localizers/least_squares/rivals.h"

namespace octant {

/// Region of possible poses that explain two ranges, for any heading: around an intersection of their circles
/// without lever arms.
struct PairPlace {
  std::array<std::size_t, 2> pair;
  int side = 0;          ///< selects one of the two intersections
  bool is_flat = false;  ///< the circles nearly touch, so both intersections are one region between them
  bool is_long = false;  ///< poses within reach need not converge to it
  double x_m = 0.0, y_m = 0.0;
  Eigen::Matrix2d by_ranges = Eigen::Matrix2d::Zero();  ///< derivative by both ranges, unless it is flat
  double reach_m = 0.0;                                 ///< radius of the region
  double bend_m = 0.0;       ///< deviation of the circles from straight lines within reach
  double half_gap_m = 0.0;   ///< half the distance to the other intersection
  double least_score = 0.0;  ///< lower bound of the score within reach
};

/// Regions of poses that pairs of ranges allow, with a lower bound of the score in each: a range that no pose
/// within reach explains costs as much as an outlier.
class PairPlaces {
 public:
  /// @param consensus  at the width of the bounds  @param headings  number of headings tried in a region
  PairPlaces(const SearchProblem& problem, const Consensus& consensus, const Discord& discord, int headings);

  /// Regions of the pairs whose poses may score up to the bound, the most promising first.
  [[nodiscard]] std::pmr::vector<PairPlace> within(std::span<const std::array<std::size_t, 2>> pairs,
                                                   double bound) const;

  /// Restricts the elongated region of touching circles to the part in which poses may score up to the bound;
  /// no value if it is empty.
  [[nodiscard]] std::optional<PairPlace> narrowed(const PairPlace& flat, double bound) const;

  /// Offers poses in the region for each heading whose score may be within the bound. For the bound the
  /// ranges are linearised in cosine and sine of the heading, so that a heading needs no square root.
  /// @param widened  at the width of the offered poses
  void propose(const PairPlace& place, Consensus& widened, double bound, TopList& top);

 private:
  /// A range with its lower cost bound at the width of the bounds.
  struct Limit {
    Circle circle;  ///< circle of the vehicle's origin, without the lever arm
    double dz2_m2;
    double lever_m;  ///< horizontal length of the lever arm
    double noise_m;  ///< possible shift of the circle by noise
    double variance_m2;
    Consensus::Caps caps;

    [[nodiscard]] double reach_m() const { return lever_m + noise_m; }
    /// @param late_m  range minus distance  @param margin_m  by which a pose may reduce it
    [[nodiscard]] double least_cost(double late_m, double margin_m) const {
      const double off_m = std::max(std::abs(late_m) - margin_m, 0.0);
      return std::min(0.5 * off_m * off_m / variance_m2, late_m > 0 ? caps.late : caps.early);
    }
  };
  [[nodiscard]] double least_score(const PairPlace& place, double bound) const;
  [[nodiscard]] PairPlace place_on(const std::array<std::size_t, 2>& pair, int side,
                                   const PlanarState& at) const;
  [[nodiscard]] bool flat_place(const std::array<std::size_t, 2>& pair, PairPlace& place) const;
  [[nodiscard]] Eigen::Matrix2d place_by_turn(const PairPlace& place) const;

  static constexpr int kMostHeadings = 72, kFiner = 4;
  using OfHeadings = Eigen::Array<double, Eigen::Dynamic, 1, 0, kMostHeadings, 1>;
  /// Sectors of headings with a lower score bound in each.
  struct Sectors {
    OfHeadings cosine, sine;  ///< cosines and sines of the sectors' middles
    double half_width_rad = 0.0;
    OfHeadings least;
  };
  /// @return false if all sectors exceed the bound
  [[nodiscard]] bool bound_scores(const PairPlace& place, double bound, Sectors& sectors);
  void add_least_costs(const PairPlace& place, const Eigen::Matrix2d& by_turn, std::size_t group,
                       Sectors& sectors);
  [[nodiscard]] bool bound_finer_scores(const PairPlace& place, double bound);

  const SearchProblem& problem_;
  const Discord& discord_;
  std::pmr::vector<Limit> limits_{scratch()};          ///< one for each range
  std::pmr::vector<std::size_t> earliest_{scratch()};  ///< earliest range of each beacon
  std::pmr::vector<double> group_caps_{scratch()};     ///< cost of each shadowed beacon
  Sectors sectors_, finer_;
  std::array<PlanarTurn, kFiner> finer_turns_;  ///< rotations from a sector's middle to those of its parts
  OfHeadings of_group_, late_m_;
};

}  // namespace octant
