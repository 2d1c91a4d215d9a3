// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/localizers/common/correlated_arrivals.h"
#include "models/localizers/least_squares/epoch_fix_model.h"
#include "models/trajectory/linearise.h"

namespace octant {

/// Result of adjusting one node by plain least squares.
struct NodeAdjustment {
  bool converged = false;
  double cost = 0.0;      ///< half the weighted sum of squares of the arrivals in use
  NodeBlock information;  ///< of the node's state, tangent of Motion (and cycle offset in metres)
};

/// Plain least squares (Levenberg-Marquardt) on the node of a one-node segment, arrivals marked rejected left
/// out. Where beacons are known only to range_uncertainty_m, each has a bias of that sigma, eliminated
/// beforehand: it is common to the beacon's arrivals, so that the heading still follows from what they differ
/// by.
[[nodiscard]] NodeAdjustment adjust_node(Trajectory& trajectory, const Segment& segment,
                                         const SharedState& state, double range_uncertainty_m,
                                         int max_iterations = 100);

/// Largest residual, in metres, that an arrival may have at the given sigmas: noise, calibration and
/// uncertainty together.
[[nodiscard]] double allowed_residual_m(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                        const EpochFixModel& model, double range_uncertainty_m,
                                        double sigmas);

/// Marks the arrivals of the segment by their residuals at the node's state: out beyond `sigmas`, back in
/// below 0.85 of it. Returns whether any mark has changed.
bool reject_arrivals(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                     double range_uncertainty_m, double sigmas);

/// Marks the labelled bearings of the segment likewise, those that are off by more than `sigmas`. They are
/// neither late nor early, so their reason is of the side they are off to.
bool reject_bearings(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                     double range_uncertainty_m, double sigmas);

/// Adjusts and rejects in turn until no rejection changes. Each arrival is judged by its own sigma and
/// weighed by what it adds to the others of its pair.
NodeAdjustment adjust_and_reject(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                                 double range_uncertainty_m, double sigmas, CorrelatedArrivals& weights);

}  // namespace octant
