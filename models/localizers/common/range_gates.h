// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <span>

#include "models/fix.h"
#include "models/ids.h"

namespace octant {

/// Distances that are possible at a site (Chang, section 2). The defaults let everything pass.
struct RangeGates {
  double min_m = 0.0;                                      ///< d_min [m]
  double max_m = std::numeric_limits<double>::infinity();  ///< d_max [m]
};

/// An arrival as the rules see it: needs no deployment, so that a calibration can apply them too.
struct GatedArrival {
  BeaconId beacon;
  ReceiverId receiver;
  double heard_s = 0.0;  ///< instant of hearing
  double range_m = 0.0;  ///< distance it stands for; not a number: none
};

/// Chang's first rule: a distance below d_min or above d_max is impossible; Rejection::kOutOfRange.
/// Entries that are not kUsed are left as they are, by all functions here. @param rejections one for each
/// arrival
void reject_out_of_range(std::span<const GatedArrival> arrivals, const RangeGates& gates,
                         std::span<Rejection> rejections);

/// Chang's second rule: of two consecutive signals of a beacon at a receiver that are less than d_min apart
/// (as lengths: in the instants of hearing times the speed), the later is a reflection of the earlier;
/// Rejection::kReflection. A train of echoes goes as a whole, each being close behind the one before.
/// Instants tell a second firing from an echo: it may come from the same distance, but it comes later. Where
/// a log gives all rows of an epoch one instant, the distances themselves are compared, and equal distances
/// count as two firings.
/// @param arrivals in order of heard_s; linear in their number while instants differ
void reject_reflections(std::span<const GatedArrival> arrivals, double min_m, double speed_mps,
                        std::span<Rejection> rejections);

/// Both rules, in the paper's order.
void apply_range_gates(std::span<const GatedArrival> arrivals, const RangeGates& gates, double speed_mps,
                       std::span<Rejection> rejections);

}  // namespace octant
