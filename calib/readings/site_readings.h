// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/readings/reading.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// Hypotheses that times are two-way instead of one-way, or vice versa; empty if each epoch has its own clock
/// offset.
[[nodiscard]] std::vector<Reading> other_ranging(const Site& site);
/// Hypotheses that all positions are in the unit that the ranges suggest (mixed_units.h). Usually empty.
[[nodiscard]] std::vector<Reading> unit_by_ranges(const Site& site, const std::vector<MeasurementLog>& runs);
/// Hypotheses that positions of beacons, receivers or both are in centimetres, millimetres, feet or inches.
/// @param some_only  only beacons of another order of magnitude than the rest, or that the ranges distinguish
/// from it (mixed_units.h)
[[nodiscard]] std::vector<Reading> other_units(const Site& site, const std::vector<MeasurementLog>& runs,
                                               bool some_only);
/// Hypotheses that two of a few control points are exchanged. If three control points are the whole datum,
/// each of them can be blamed alone, as it can move to where it agrees with the other two. An exchange
/// explains the same without a free parameter. Empty if there are more than a few.
[[nodiscard]] std::vector<Reading> exchanged_points(const Site& site);
/// Hypotheses that receivers are exchanged, mirrored or rotated.
/// @param exchanges  those that exchange two of three or more receivers; otherwise those of whole arrays
[[nodiscard]] std::vector<Reading> other_wirings(const Site& site, const Solution& solution, bool exchanges);
/// Hypothesis that the heights of all beacons have the wrong sign (z downwards in the site file); empty
/// without heights.
[[nodiscard]] std::vector<Reading> heights_downwards(const Site& site);
/// Hypothesis of one delay of all times of flight that the site file does not have.
[[nodiscard]] std::vector<Reading> common_delay(const Site& site, double typical_range_m);
/// Hypotheses that a control point is not at its position in the site file.
[[nodiscard]] std::vector<Reading> points_elsewhere(const Site& site);
/// Hypotheses that receivers are in another frame than the vehicle's (x forward, y left): a coordinate has
/// the wrong sign, or x and y are exchanged, which rotates or mirrors them. Those that are another wiring are
/// omitted.
[[nodiscard]] std::vector<Reading> other_receiver_axes(const Site& site);
/// Hypothesis that the beacons are mirrored: in a frame whose x and y are not as seen from above. Without
/// poses and odometry, mirrored receivers have the same ranges.
[[nodiscard]] std::vector<Reading> mirrored_map(const Site& site);

/// Returns true if the site file gives the position of each beacon. A beacon without one can absorb a wrong
/// scale of the others.
[[nodiscard]] bool are_all_placed(const Site& site);
/// Site in which some of what it states is released, and the number of parameters that are free by this.
struct ReleasedSite {
  Site site;
  std::size_t parameters = 0;
};
/// Releases the blamed positions, delays, receivers and speed.
[[nodiscard]] ReleasedSite without_what_is_blamed(const Site& site, const std::vector<Contradiction>& blamed);

}  // namespace octant::calib
