// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <span>

#include "models/fix.h"
#include "models/ids.h"

namespace octant {

/// Possible distances at a site (Chang, section 2). The defaults accept everything.
struct RangeGates {
  double min_m = 0.0;                                      ///< d_min [m]
  double max_m = std::numeric_limits<double>::infinity();  ///< d_max [m]
};

/// An arrival in the form that the rules need. It does not depend on a deployment, so calibration can apply
/// the rules as well.
struct GatedArrival {
  BeaconId beacon;
  ReceiverId receiver;
  double heard_s = 0.0;  ///< time of reception
  double range_m = 0.0;  ///< range, or NaN if there is none
};

/// Chang's rule 1: a distance below d_min or above d_max is impossible (Rejection::kOutOfRange). All
/// functions here leave entries unchanged that are not kUsed. @param rejections one for each arrival
void reject_out_of_range(std::span<const GatedArrival> arrivals, const RangeGates& gates,
                         std::span<Rejection> rejections);

/// Chang's rule 2: of two consecutive signals of a beacon at a receiver that are less than d_min apart, the
/// later one is a reflection of the earlier one (Rejection::kReflection). The separation is the difference in
/// reception times multiplied by the speed. A train of echoes is rejected as a whole, because each one is
/// close to its predecessor. Reception times distinguish a second firing from an echo: it may come from the
/// same distance, but it comes later. If a log gives all rows of an epoch the same time, the distances are
/// compared instead, and equal distances count as two firings.
/// @param arrivals in order of heard_s; the cost is linear in their number while times differ
void reject_reflections(std::span<const GatedArrival> arrivals, double min_m, double speed_mps,
                        std::span<Rejection> rejections);

/// Applies both rules in the order of the paper.
void apply_range_gates(std::span<const GatedArrival> arrivals, const RangeGates& gates, double speed_mps,
                       std::span<Rejection> rejections);

}  // namespace octant
