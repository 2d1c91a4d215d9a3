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

/// Score of a pose: negative log likelihood of the arrivals, up to a constant, under a mixture.
///
/// Each arrival is direct (Gaussian), an echo (uniformly late up to the longest range) or spurious (early,
/// rare). With the longest range D and the sigma s, the logarithms of the ratios of the densities at the peak
/// cap the cost of one arrival:
///   late   ln(0.7 / (sqrt(2 pi) s) / (0.2  / D)) = ln(1.4 D / s)
///   early  ln(0.7 / (sqrt(2 pi) s) / (0.01 / D)) = ln(28 D / s)
/// A shadowed beacon delays all its arrivals equally. It costs the cap once, and its arrivals cost only their
/// differences. The agreement of three beacons therefore counts more than that of three arrivals of one
/// beacon. The uncertainty of a beacon is a bias b common to its arrivals, at a cost of b^2 / (2 sigma_b^2).
/// A receiver with an axis that receives from behind adds a cost.
class Consensus {
 public:
  explicit Consensus(const SearchProblem& problem);

  /// Widens the sigmas of all arrivals by the possible error of a candidate [m].
  void set_extra_sigma(double extra_m);

  /// If false, axes of receivers and shadows of beacons are not evaluated and every arrival counts
  /// separately, because heading and offset of early candidates are only guesses.
  void judge_shadows(bool on) { judge_shadows_ = on; }

  /// Stops as soon as the score exceeds give_up.
  [[nodiscard]] double score(const PlanarState& state,
                             double give_up = std::numeric_limits<double>::infinity()) {
    return score(state, PlanarTurn(state.heading_rad), give_up);
  }
  /// @param heading  heading of the state
  [[nodiscard]] double score(const PlanarState& state, const PlanarTurn& heading, double give_up);

  /// Gauss-Newton iteration with one-sided Cauchy weights; without_group: a beacon to ignore. While arrivals
  /// are widened, it ends with a step below a tenth of the widening. Steps that increase the score are
  /// halved. Returns the information matrix (x, y, heading, offset) of the last step, in units of the widened
  /// sigmas.
  Eigen::Matrix4d refine(PlanarState& state, int iterations, std::size_t without_group = kNone) {
    Descent descent;
    return refine(state, iterations, without_group, descent);
  }
  /// State of an iteration, from which another one can continue.
  struct Descent {
    PlanarState state{};
    double score = std::numeric_limits<double>::infinity();
  };
  Eigen::Matrix4d refine(PlanarState& state, int iterations, std::size_t without_group, Descent& descent);

  /// Cycle offset for the pose of a state: a median, which late echoes hardly affect.
  [[nodiscard]] double best_offset(const PlanarState& state);

  /// Lower bound of the cost of an outlier at the current width, for an arrival or a shadowed beacon.
  [[nodiscard]] double least_cap() const;

  /// Adds the information on x, y and heading from those arrivals of a beacon that agree with the state.
  /// @param left_out  ranges to ignore  @return number of receivers involved
  std::size_t agreement(const PlanarState& state, std::size_t group, double sigmas,
                        std::span<const char> left_out, Eigen::Matrix3d& information);

  /// Returns true if an arrival deviates by more than `low` and less than `high` sigmas.
  [[nodiscard]] bool has_residual_between(const PlanarState& state, double low, double high);

  /// Returns true if both arrivals are within four sigmas, including the biases of their beacons.
  [[nodiscard]] bool explains(const PlanarState& state, const std::array<std::size_t, 2>& arrivals) const;

  /// Median absolute residual at a state [m].
  [[nodiscard]] double middle_misfit_m(const PlanarState& state);

  /// Lower bounds of the cost of an outlier.
  struct Caps {
    double late, early;
  };
  [[nodiscard]] Caps least_caps(std::size_t i, std::size_t group) const {
    return {std::min(caps_[i].late, group_caps_[group].late),
            std::min(caps_[i].early, group_caps_[group].early)};
  }
  /// Variance of an arrival including the bias of its beacon [m^2].
  [[nodiscard]] double variance_m2(std::size_t i, std::size_t group) const {
    return 1.0 / inverse_variance_[i] + bias_variance_[group];
  }

  /// Returns true if a beacon's arrivals have a common error that is modelled separately.
  [[nodiscard]] bool has_bias(std::size_t group) const { return bias_variance_[group] > 0; }

  /// Cost of a shadowed beacon.
  [[nodiscard]] double group_cap(std::size_t group) const { return group_caps_[group].late; }

  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

 private:
  /// A range in the form that the inner loops use.
  struct Geometry {
    double beacon_x_m, beacon_y_m, dz2_m2, lever_x_m, lever_y_m, range_m;
    double axis_x, axis_y, hearing2;  ///< cosine beyond which reception is unlikely, squared with its sign
    double behind_cost;               ///< cost of reception beyond it
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
  /// Cost of a group whose arrivals do not all agree, from its median residual.
  [[nodiscard]] double divided_group_cost(std::size_t group, double plain, bool& direct);
  [[nodiscard]] double middle_residual(std::size_t group);

  const SearchProblem& problem_;
  std::pmr::vector<Geometry> geometry_{scratch()};
  // For each range and each beacon at the current width.
  std::pmr::vector<double> inverse_variance_{scratch()}, bias_variance_{scratch()};
  std::pmr::vector<Caps> caps_{scratch()}, group_caps_{scratch()};
  // For each range at the current state: residual, cost of reception from behind, d range / d (x, y,
  // heading).
  std::pmr::vector<double> residual_{scratch()}, behind_{scratch()}, by_x_{scratch()}, by_y_{scratch()},
      by_heading_{scratch()}, sorted_{scratch()};
  double extra_m_ = 0.0;
  bool judge_shadows_ = true;
};

/// Information of the heading for an unknown position (Schur complement). @param A  matrix that begins with
/// x, y, heading
template <class Derived>
[[nodiscard]] double heading_information(const Eigen::MatrixBase<Derived>& A) {
  const double det = A(0, 0) * A(1, 1) - A(0, 1) * A(0, 1);
  if (!(det > 0)) return 0.0;
  return A(2, 2) -
         (A(1, 1) * A(0, 2) * A(0, 2) - 2 * A(0, 1) * A(0, 2) * A(1, 2) + A(0, 0) * A(1, 2) * A(1, 2)) / det;
}

}  // namespace octant
