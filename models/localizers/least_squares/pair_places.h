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

/// Where a pose may be that explains two ranges, whatever its heading: about a point where their circles
/// without lever arms meet.
struct PairPlace {
  std::array<std::size_t, 2> pair;
  int side = 0;          ///< of both on which circles meet
  bool is_flat = false;  ///< they about touch: both sides are one place, between them
  bool is_long = false;  ///< poses about one within reach need not lead to it
  double x_m = 0.0, y_m = 0.0;
  Eigen::Matrix2d by_ranges = Eigen::Matrix2d::Zero();  ///< how it moves with both ranges, unless it is flat
  double reach_m = 0.0;                                 ///< how far from it the pose may be
  double bend_m = 0.0;                                  ///< by how much circles bend within reach
  double half_gap_m = 0.0;                              ///< half way to the other side
  double least_score = 0.0;                             ///< no pose within reach scores less
};

/// The places that pairs of ranges leave, and for each a bound of what a pose there may score: a range that
/// no pose within reach explains costs what an outlier costs.
class PairPlaces {
 public:
  /// @param consensus  at the width at which scores are bounded  @param headings  that are tried at a place
  PairPlaces(const SearchProblem& problem, const Consensus& consensus, const Discord& discord, int headings);

  /// The places of the pairs whose poses may score up to the bound, the most promising first.
  [[nodiscard]] std::pmr::vector<PairPlace> within(std::span<const std::array<std::size_t, 2>> pairs,
                                                   double bound) const;

  /// Of a place where circles about touch, whose lens may be long, keeps the part in which poses may score up
  /// to the bound; nothing where there is none.
  [[nodiscard]] std::optional<PairPlace> narrowed(const PairPlace& flat, double bound) const;

  /// Offers the poses at the place, for each heading that is tried, whose scores may be within the bound. For
  /// the bound the ranges are taken as linear in the heading's cosine and sine, so that a heading costs no
  /// root.
  /// @param widened  at the width at which poses are offered
  void propose(const PairPlace& place, Consensus& widened, double bound, TopList& top);

 private:
  /// A range, and what it costs at least at the width at which scores are bounded.
  struct Limit {
    Circle circle;  ///< of the vehicle's origin, without the lever arm
    double dz2_m2;
    double lever_m;  ///< horizontal
    double noise_m;  ///< by how far noise may shift the circle
    double variance_m2;
    Consensus::Caps caps;

    [[nodiscard]] double reach_m() const { return lever_m + noise_m; }
    /// @param late_m  range less distance  @param margin_m  by how far a pose may lessen it
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
  /// Sectors of headings, and for each a bound of what a pose in it may score.
  struct Sectors {
    OfHeadings cosine, sine;  ///< of their middles
    double half_width_rad = 0.0;
    OfHeadings least;
  };
  /// @return false where all are beyond the bound
  [[nodiscard]] bool bound_scores(const PairPlace& place, double bound, Sectors& sectors);
  void add_least_costs(const PairPlace& place, const Eigen::Matrix2d& by_turn, std::size_t group,
                       Sectors& sectors);
  [[nodiscard]] bool bound_finer_scores(const PairPlace& place, double bound);

  const SearchProblem& problem_;
  const Discord& discord_;
  std::pmr::vector<Limit> limits_{scratch()};          ///< of each range
  std::pmr::vector<std::size_t> earliest_{scratch()};  ///< range of each beacon
  std::pmr::vector<double> group_caps_{scratch()};     ///< of each beacon in a shadow
  Sectors sectors_, finer_;
  std::array<PlanarTurn, kFiner> finer_turns_;  ///< from a sector's middle to those of its parts
  OfHeadings of_group_, late_m_;
};

}  // namespace octant
