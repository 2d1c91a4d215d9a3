// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/localizers/common/correlated_arrivals.h"
#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/trajectory/linearise.h"

namespace octant {

/// Result of the least-squares adjustment of one node.
struct NodeAdjustment {
  bool converged = false;
  double cost = 0.0;  ///< half the weighted sum of squared residuals
  NodeBlock
      information;  ///< information of the node's state in the tangent of Motion (and cycle offset in metres)
};

/// Least-squares adjustment (Levenberg-Marquardt) of the node of a one-node segment, without rejected
/// arrivals. Beacons known to range_uncertainty_m have a bias with that sigma each, common to their arrivals
/// and eliminated, so that the heading still follows from differences between arrivals.
[[nodiscard]] NodeAdjustment adjust_node(Trajectory& trajectory, const Segment& segment,
                                         const SharedState& state, double range_uncertainty_m,
                                         int max_iterations = 100);

/// Largest acceptable residual of an arrival, in metres, for the given number of sigmas of noise, calibration
/// and uncertainty.
[[nodiscard]] double allowed_residual_m(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                        const EpochFixModel& model, double range_uncertainty_m,
                                        double sigmas);

/// Marks the arrivals of the segment by their residuals at the node's state: rejected beyond `sigmas`,
/// accepted again below 0.85 of it. Returns true if any mark changed.
bool reject_arrivals(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                     double range_uncertainty_m, double sigmas);

/// Marks the labelled bearings of the segment in the same way, if they deviate by more than `sigmas`. The
/// sign of the deviation selects kLate or kEarly, although bearings are neither.
bool reject_bearings(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                     double range_uncertainty_m, double sigmas);

/// Alternates adjustment and rejection until no rejection changes. Each arrival is judged by its own sigma
/// and weighted by the information that it adds to the others of its pair.
NodeAdjustment adjust_and_reject(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                 double range_uncertainty_m, double sigmas, CorrelatedArrivals& weights);

}  // namespace octant
