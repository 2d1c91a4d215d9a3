// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "models/changes/change_search.h"
#include "models/deployment.h"

namespace octant {

/// Result of the comparison of two visits.
struct Comparison {
  std::vector<Change> changes;  ///< significant changes, ordered by p
  std::vector<ChangeHypothesis>
      hypotheses;  ///< all tested hypotheses; owners are those of the first deployment
  ChangeSearch search;
  double p = 1.0;       ///< probability of the whole difference by chance
  double p_left = 1.0;  ///< probability of the difference that the changes do not explain
};

/// Compares a second visit with a deployment. A motion of the map as a whole is one of the hypotheses, so
/// that it is not attributed to single beacons. In a free network (inner constraints) the position of the map
/// has no meaning and does not affect the comparison. Two beacons that exchanged their positions are reported
/// as such.
/// @param before  names and positions  @param known  its parameters, in the order of the innovation
/// @param is_possible  selects the changes to test; empty: all
[[nodiscard]] Comparison compare(const Deployment& before, const KnownParameters& known,
                                 const Innovation& innovation,
                                 const std::function<bool(const ChangeHypothesis&)>& is_possible = {});

/// Compares two deployments of a site in the parameters that both have. If `now` was derived from `before` by
/// a recalibration, their errors are correlated, and the information of the second visit alone is recovered:
///   N = C_now^-1 - P^-1,   N (theta_2 - theta_1) = C_now^-1 (theta_now - theta_1),   P = C_before + drift +
///   released
/// Otherwise they are treated as independent, which is conservative if they share recordings.
[[nodiscard]] Comparison compare(const Deployment& before, const Deployment& now, const Drift& drift);
/// Returns true if a deployment was derived from another one by a recalibration.
[[nodiscard]] bool is_derived(const Deployment& now, const Deployment& before);

/// Parameters that changed according to a comparison.
[[nodiscard]] Released changed_parameters(const Comparison& comparison, const KnownParameters& known);
/// Covariance that is added to released parameters in addition to their drift, so that their old values have
/// no weight.
[[nodiscard]] Eigen::MatrixXd released_covariance(const KnownParameters& known, const Released& released,
                                                  Motion motion);
/// Drift of a deployment's parameters until a time, ISO 8601.
[[nodiscard]] Drift drift_between(const Deployment& before, const std::string& now);
/// Months between two times in ISO 8601; 0 if one of them is invalid or the second comes first.
[[nodiscard]] double months_between(const std::string& before, const std::string& now);

}  // namespace octant
