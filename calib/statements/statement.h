// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "calib/problem/parameters.h"
#include "calib/problem/problem.h"

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
  kDistance
};

/// One assumption of a site file.
struct Statement {
  What what = What::kSpeed;
  std::size_t index = 0;  ///< index of the beacon, receiver, run, coefficient or distance
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
  /// are blamed: one delay for all beacons, their delays together, a fixed speed. They are not tested by
  /// themselves, because real beacons differ by more than the noise. They are only alternatives to another
  /// contradicted assumption.
  [[nodiscard]] std::vector<Statement> common_causes() const;

  /// Layout in which some assumptions are released.
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
