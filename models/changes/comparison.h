// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "models/changes/change_search.h"
#include "models/deployment.h"

namespace octant {

/// What a comparison of two visits found.
struct Comparison {
  std::vector<Change> changes;  ///< held to be changed, least p first
  std::vector<ChangeHypothesis>
      hypotheses;  ///< all that was tested; owners are those of the first deployment
  ChangeSearch search;
  double p = 1.0;       ///< of the whole difference by chance
  double p_left = 1.0;  ///< of what the changes leave of it
};

/// That the map moved as a whole is one of the changes that are looked for, so that no beacon is accused of
/// it; of a free network (inner constraints) the place has no meaning, and the comparison is free of it. Two
/// beacons that moved to each other's places are named as exchanged.
/// @param before  names and places  @param known  of it, as the innovation has its parameters
/// @param is_possible  whether a change is looked for; empty: all are
[[nodiscard]] Comparison compare(const Deployment& before, const KnownParameters& known,
                                 const Innovation& innovation,
                                 const std::function<bool(const ChangeHypothesis&)>& is_possible = {});

/// The changes between two deployments of a site, of all that both have. Where `now` was made of `before` by
/// a recalibration their errors hang together, and what the second visit said on its own is taken out of it
/// again:
///   N = C_now^-1 - P^-1,   N (theta_2 - theta_1) = C_now^-1 (theta_now - theta_1),   P = C_before + drift +
///   what was released
/// Else they are taken as independent, which is too careful where they share recordings.
[[nodiscard]] Comparison compare(const Deployment& before, const Deployment& now, const Drift& drift);
/// Whether a deployment was made of another one by a recalibration.
[[nodiscard]] bool is_derived(const Deployment& now, const Deployment& before);

/// The parameters that changed by what a comparison holds.
[[nodiscard]] Released changed_parameters(const Comparison& comparison, const KnownParameters& known);
/// Covariance that parameters get beside their drift when they are told anew: nothing of the old values is
/// believed.
[[nodiscard]] Eigen::MatrixXd released_covariance(const KnownParameters& known, const Released& released,
                                                  Motion motion);
/// Drift of a deployment's numbers until an instant, ISO 8601.
[[nodiscard]] Drift drift_between(const Deployment& before, const std::string& now);
/// What so many months are between two instants in ISO 8601; 0 where one of them cannot be read or the second
/// comes first.
[[nodiscard]] double months_between(const std::string& before, const std::string& now);

}  // namespace octant
