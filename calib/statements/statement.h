// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "calib/problem/parameters.h"
#include "calib/problem/problem.h"

namespace octant::calib {

/// What kind of thing a site file states.
enum class What {
  kControlPoint,
  kBeaconDelay,
  kReceiverDelay,
  kSiteDelay,
  kNoDelays,
  kOneDelay,   ///< of the site, for all beacons
  kDelays,     ///< those of all beacons together, each with a prior
  kHeldSpeed,  ///< the medium's, exactly
  kSpeed,
  kReceiver,
  kAttenuation,
  kDistance
};

/// One thing that a site file states.
struct Statement {
  What what = What::kSpeed;
  std::size_t index = 0;  ///< of the beacon, receiver, run, coefficient or distance
  bool operator==(const Statement&) const = default;
};

/// Columns of a statement in a layout in which it may move; none of a taped distance.
[[nodiscard]] std::vector<int> columns_of(const Statement& statement, const ParameterLayout& layout);

/// Whether a statement is held (a control point, no delay): it has no columns of its own until it is
/// released.
[[nodiscard]] inline bool is_held(const Statement& s) {
  return s.what == What::kControlPoint || s.what == What::kNoDelays || s.what == What::kOneDelay ||
         s.what == What::kHeldSpeed;
}

/// What a site file states, as a calibration believes it.
class StatedSite {
 public:
  /// Problem and layout must outlive it.
  /// @param layout  of the calibration, its priors as the labels were mended  @param beacon_usable  of the
  /// site
  StatedSite(const Problem& problem, const ParameterLayout& layout, std::vector<bool> beacon_usable)
      : problem_(problem), layout_(layout), beacon_usable_(std::move(beacon_usable)) {}

  [[nodiscard]] const Site& site() const { return problem_.site; }
  [[nodiscard]] const Problem& problem() const { return problem_; }
  [[nodiscard]] const ParameterLayout& layout() const { return layout_; }

  /// Everything that can be held against the data.
  [[nodiscard]] std::vector<Statement> all() const;

  /// What bends everything else a little where it is wrong, so that single good statements are blamed for it:
  /// one delay for all beacons, their delays together, a speed that is held. No tests of their own, as real
  /// beacons differ by more than the arrivals' noise tells: only what is blamed on another statement may be
  /// one of these.
  [[nodiscard]] std::vector<Statement> common_causes() const;

  /// A layout in which some statements are not believed.
  /// @param problem  out: with the site as it is believed then
  [[nodiscard]] ParameterLayout layout_without(const std::vector<Statement>& released,
                                               const SharedState& state, Problem& problem) const;

  /// As the site file has it, internal unit of that column of a layout.
  [[nodiscard]] double value(const Statement& statement, const ParameterLayout& layout, int column) const;
  /// Sigma by which the site file states it; 0: held.
  [[nodiscard]] double sigma(const Statement& statement, const ParameterLayout& layout, int column) const;

 private:
  [[nodiscard]] double wide_sigma(const Statement& statement) const;

  const Problem& problem_;
  const ParameterLayout& layout_;
  std::vector<bool> beacon_usable_;
};

}  // namespace octant::calib
