// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/least_squares/search_problem.h"
#include "models/physics/pose_equations.h"
#include "models/trajectory/planar.h"

namespace octant {

/// How well a pose explains the arrivals: a negative log likelihood, up to a constant, of a mixture.
///
/// Each arrival is direct (Gaussian), an echo (late by anything up to the longest range) or spurious (early,
/// rare). With the longest range D and the sigma s the logarithms of the ratios of densities at the peak cap
/// what one arrival may cost:
///   late   ln(0.7 / (sqrt(2 pi) s) / (0.2  / D)) = ln(1.4 D / s)
///   early  ln(0.7 / (sqrt(2 pi) s) / (0.01 / D)) = ln(28 D / s)
/// A beacon in an obstacle's shadow delays all its arrivals alike: it costs the cap once, and its arrivals
/// then only what they differ among themselves. So the agreement of three beacons weighs more than that of
/// three arrivals of one beacon. What is not known of a beacon is a bias b that its arrivals have in common
/// and that costs b^2 / (2 sigma_b^2). A receiver with an axis that would have to hear from behind costs
/// extra.
class Consensus {
 public:
  explicit Consensus(const SearchProblem& problem);

  /// Widens all arrivals: what a candidate may be off by [m].
  void set_extra_sigma(double extra_m);

  /// While heading and offset are still guesses, neither a receiver's axis nor a beacon's shadow is evidence
  /// of anything: with this, every arrival takes part on its own.
  void judge_shadows(bool on) { judge_shadows_ = on; }

  /// Stops as soon as the score passes give_up.
  [[nodiscard]] double score(const PlanarState& state,
                             double give_up = std::numeric_limits<double>::infinity()) {
    return score(state, PlanarTurn(state.heading_rad), give_up);
  }
  /// @param heading  the state's
  [[nodiscard]] double score(const PlanarState& state, const PlanarTurn& heading, double give_up);

  /// Gauss-Newton with one-sided Cauchy weights from where the state is; without_group: a beacon left out.
  /// While arrivals are widened, a step by a tenth of that is the last. Returns the information matrix (x, y,
  /// heading, offset) of the last step, in units of the widened sigmas.
  /// A step that makes the score worse is taken back by half.
  Eigen::Matrix4d refine(PlanarState& state, int iterations, std::size_t without_group = kNone) {
    Descent descent;
    return refine(state, iterations, without_group, descent);
  }
  /// Where the last step came from; lets one refinement go on where another ended.
  struct Descent {
    PlanarState state{};
    double score = std::numeric_limits<double>::infinity();
  };
  Eigen::Matrix4d refine(PlanarState& state, int iterations, std::size_t without_group, Descent& descent);

  /// Offset that suits the arrivals at the state's pose: a median that echoes, which are late, do not pull
  /// far.
  [[nodiscard]] double best_offset(const PlanarState& state);

  /// What an outlier costs at the present width at least, be it an arrival or a beacon in a shadow.
  [[nodiscard]] double least_cap() const;

  /// Adds up what those of a beacon's arrivals tell of x, y and heading that agree with the state.
  /// @param left_out  of each range  @return receivers that they came to
  std::size_t agreement(const PlanarState& state, std::size_t group, double sigmas,
                        std::span<const char> left_out, Eigen::Matrix3d& information);

  /// Whether an arrival is off by more than `low` sigmas and less than `high`.
  [[nodiscard]] bool has_residual_between(const PlanarState& state, double low, double high);

  /// Whether both arrivals are within four sigmas, each with its beacon's bias.
  [[nodiscard]] bool explains(const PlanarState& state, const std::array<std::size_t, 2>& arrivals) const;

  /// Middle size of the residuals at a state [m].
  [[nodiscard]] double middle_misfit_m(const PlanarState& state);

  /// What an arrival costs at least that is off by more than it or its beacon may be.
  struct Caps {
    double late, early;
  };
  [[nodiscard]] Caps least_caps(std::size_t i, std::size_t group) const {
    return {std::min(caps_[i].late, group_caps_[group].late),
            std::min(caps_[i].early, group_caps_[group].early)};
  }
  /// Of an arrival, with its beacon's bias [m^2].
  [[nodiscard]] double variance_m2(std::size_t i, std::size_t group) const {
    return 1.0 / inverse_variance_[i] + bias_variance_[group];
  }

  /// Whether a beacon's arrivals have an error in common that is reckoned apart from their own.
  [[nodiscard]] bool has_bias(std::size_t group) const { return bias_variance_[group] > 0; }

  /// What a beacon in a shadow costs.
  [[nodiscard]] double group_cap(std::size_t group) const { return group_caps_[group].late; }

  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

 private:
  /// A range as the loops take it.
  struct Geometry {
    double beacon_x_m, beacon_y_m, dz2_m2, lever_x_m, lever_y_m, range_m;
    double axis_x, axis_y, hearing2;  ///< cosine beyond which it hardly hears, squared with its sign
    double behind_cost;               ///< of hearing from beyond that
  };
  struct Part {
    std::size_t first, last;
  };
  [[nodiscard]] Part all() const { return {0, geometry_.size()}; }
  void set_residuals(const PlanarState& state, const PlanarTurn& heading, Part part);
  void set_rows(const PlanarState& state, const PlanarTurn& heading, Part part);
  [[nodiscard]] double group_cost(std::size_t group, bool& direct);
  [[nodiscard]] double arrival_cost(std::size_t i, double residual) const;
  [[nodiscard]] double bearing_cost(const SearchBearing& b, const PlanarState& state,
                                    const PlanarTurn& heading) const;
  double add_group(std::size_t group, PoseEquations& eq);
  void add_bearing(const SearchBearing& b, const PlanarState& state, const PlanarTurn& heading,
                   PoseEquations& eq) const;

  void share_behind_cost();
  [[nodiscard]] Caps caps_for(double variance_m2) const;
  /// Cost of the group by way of its middle residual, where its arrivals do not all agree.
  [[nodiscard]] double divided_group_cost(std::size_t group, double plain, bool& direct);
  [[nodiscard]] double middle_residual(std::size_t group);

  const SearchProblem& problem_;
  std::pmr::vector<Geometry> geometry_{scratch()};
  // Of each range and of each beacon at the present width.
  std::pmr::vector<double> inverse_variance_{scratch()}, bias_variance_{scratch()};
  std::pmr::vector<Caps> caps_{scratch()}, group_caps_{scratch()};
  // Of each range at the present state: residual, cost of hearing from behind, d range / d (x, y, heading).
  std::pmr::vector<double> residual_{scratch()}, behind_{scratch()}, by_x_{scratch()}, by_y_{scratch()},
      by_heading_{scratch()}, sorted_{scratch()};
  double extra_m_ = 0.0;
  bool judge_shadows_ = true;
};

/// What is left of the heading's information when the position is open (Schur complement). @param A  x, y,
/// heading first among its rows
template <class Derived>
[[nodiscard]] double heading_information(const Eigen::MatrixBase<Derived>& A) {
  const double det = A(0, 0) * A(1, 1) - A(0, 1) * A(0, 1);
  if (!(det > 0)) return 0.0;
  return A(2, 2) -
         (A(1, 1) * A(0, 2) * A(0, 2) - 2 * A(0, 1) * A(0, 2) * A(1, 2) + A(0, 0) * A(1, 2) * A(1, 2)) / det;
}

}  // namespace octant
