// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calib/problem/parameters.h"
#include "calib/problem/problem.h"
#include "calib/statements/refit.h"

namespace octant::calib {

/// Kinds of assumptions in a site file.
enum class What {
  kControlPoint,
  kPlace,  ///< position of a beacon with a prior
  kBeaconDelay,
  kReceiverDelay,
  kSiteDelay,
  kNoDelays,
  kOneDelay,   ///< one delay of the site for all beacons
  kDelays,     ///< delays of all beacons together, each with a prior
  kHeldSpeed,  ///< speed of the medium, fixed
  kSpeed,
  kReceiver,
  kAttenuation,
  kDistance,
  kHeights,  ///< heights of all beacons count upwards
  kLabels    ///< two beacons are at their own positions, and not at each other's
};

/// One assumption of a site file.
struct Statement {
  What what = What::kSpeed;
  std::size_t index = 0;  ///< index of the beacon, receiver, run, coefficient or distance
  std::size_t other = 0;  ///< index of the second beacon of kLabels
  bool operator==(const Statement&) const = default;
};

/// Columns of an assumption in a layout in which it is free; empty for a taped distance.
[[nodiscard]] std::vector<int> columns_of(const Statement& statement, const ParameterLayout& layout);

/// Returns true if an assumption fixes a value (a control point, no delay). It has no columns until it is
/// released.
[[nodiscard]] inline bool is_held(const Statement& s) {
  return s.what == What::kControlPoint || s.what == What::kNoDelays || s.what == What::kOneDelay ||
         s.what == What::kHeldSpeed;
}

/// Returns true for the position of a beacon.
[[nodiscard]] inline bool is_place(const Statement& s) {
  return s.what == What::kControlPoint || s.what == What::kPlace;
}

/// Returns true if an assumption is either true or replaced by one alternative, without a free parameter:
/// heights that count downwards, exchanged beacons.
[[nodiscard]] inline bool has_alternative(const Statement& s) {
  return s.what == What::kHeights || s.what == What::kLabels;
}

/// Returns true if a beacon has a height other than zero.
[[nodiscard]] bool has_heights(const Site& site);
/// Changes the sign of the heights of all beacons.
void turn_heights(Site& site);

/// Difference between the site file and a fit.
struct Difference {
  Eigen::VectorXd v;  ///< value of the fit minus value of the site file, internal units
  Eigen::MatrixXd covariance;
  double length_m = 0.0;       ///< effect at the beacons or the robot
  double freedoms = INFINITY;  ///< degrees of freedom of the covariance
  /// Squared difference, normalised by its covariance. If few data determine the covariance, it is that with
  /// the same likelihood ratio under a normal distribution (Student's t: nu ln(1 + t^2 / nu)).
  [[nodiscard]] double squares() const;
  /// Normal deviate with the chi-square probability of squares() (Wilson and Hilferty 1931, far in the tail).
  [[nodiscard]] double sigmas() const;
};

/// Returns true if an assumption, or an exchange of the beacon whose position it is, is among the released
/// ones.
[[nodiscard]] bool is_released(const Statement& s, const std::vector<Statement>& released);

/// An assumption that deviates significantly, before any new adjustment.
struct Suspect {
  Statement statement;
  double sigmas = 0.0;
};

/// Assumptions of a site file in a calibration.
class StatedSite {
 public:
  /// Problem and layout must outlive it.
  /// @param layout  layout of the calibration, in whose priors labels were corrected
  /// @param beacon_usable  for each beacon of the site
  StatedSite(const Problem& problem, const ParameterLayout& layout, std::vector<bool> beacon_usable)
      : problem_(problem), layout_(layout), beacon_usable_(std::move(beacon_usable)) {}

  [[nodiscard]] const Site& site() const { return problem_.site; }
  [[nodiscard]] const Problem& problem() const { return problem_; }
  [[nodiscard]] const ParameterLayout& layout() const { return layout_; }

  /// All assumptions that can be tested against the data.
  [[nodiscard]] std::vector<Statement> all() const;

  /// Assumptions that distort everything else a little if they are wrong, so that single correct assumptions
  /// are blamed: one delay for all beacons, their delays together, a fixed speed. They are only tested as
  /// alternatives to a suspected assumption.
  [[nodiscard]] std::vector<Statement> common_causes() const;

  /// The most significant deviations of a fit (statements.h), and control points most of whose arrivals were
  /// rejected.
  /// @param released  assumptions that the fit does not contain
  [[nodiscard]] std::vector<Suspect> suspects(const Fit& fit, const std::vector<Statement>& released,
                                              int threads) const;

  /// Exchange of a beacon with the one at whose stated position it was found.
  [[nodiscard]] std::optional<Statement> exchange_of(const Statement& place,
                                                     const Eigen::Vector3d& found_m) const;

  /// State under the alternative of an assumption; unchanged if it has none.
  [[nodiscard]] SharedState with_alternative(const Statement& statement, SharedState state) const;

  /// Layout in which some assumptions are released, or replaced by their alternatives.
  /// @param problem  output: problem with the corresponding site
  [[nodiscard]] ParameterLayout layout_without(const std::vector<Statement>& released,
                                               const SharedState& state, Problem& problem) const;

  /// Value in the site file, in the internal unit of the column.
  [[nodiscard]] double value(const Statement& statement, const ParameterLayout& layout, int column) const;
  /// Sigma in the site file; 0: fixed.
  [[nodiscard]] double sigma(const Statement& statement, const ParameterLayout& layout, int column) const;

 private:
  [[nodiscard]] double wide_sigma(const Statement& statement) const;

  const Problem& problem_;
  const ParameterLayout& layout_;
  std::vector<bool> beacon_usable_;
};

}  // namespace octant::calib
