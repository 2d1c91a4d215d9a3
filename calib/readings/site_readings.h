// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/readings/reading.h"
#include "calib/solution/solution.h"

namespace octant::calib {

/// Times there and back for one-way times, or the other way round; none where each epoch has a clock of its
/// own.
[[nodiscard]] std::vector<Reading> other_ranging(const Site& site);
/// Positions of beacons, receivers or both in centimetres, millimetres, feet, inches.
/// @param some_only  only those beacons that are of another order of magnitude than the rest, or that the
/// ranges tell apart from it (mixed_units.h)
[[nodiscard]] std::vector<Reading> other_units(const Site& site, const std::vector<MeasurementLog>& runs,
                                               bool some_only);
/// Two of a few control points at each other's places. Of three that are all the datum each can be blamed by
/// itself, as it may move to where it agrees with the two others; an exchange explains the same with nothing
/// to adjust. None where there are more than a few.
[[nodiscard]] std::vector<Reading> exchanged_points(const Site& site);
/// Receivers exchanged, mirrored, turned.
[[nodiscard]] std::vector<Reading> other_wirings(const Site& site, const Solution& solution);
/// Heights of all beacons with the wrong sign (z counts downwards in the site file); none where none are
/// stated.
[[nodiscard]] std::vector<Reading> heights_downwards(const Site& site);
/// All times of flight longer or shorter by one delay that the site file does not have.
[[nodiscard]] std::vector<Reading> common_delay(const Site& site, double typical_range_m);
/// Each control point at another place than the stated one.
[[nodiscard]] std::vector<Reading> points_elsewhere(const Site& site);
/// Positions written in another frame than that of a vehicle (x forward, y left) or of a map (x, y as seen
/// from above): the receivers with a coordinate of the wrong sign or x and y exchanged, which turns or
/// mirrors them; the beacons mirrored. What changes nothing is left out. Where no pose and no odometry tells
/// left from right, a mirrored map and mirrored receivers are one and the same to the ranges.
[[nodiscard]] std::vector<Reading> other_site_frames(const Site& site);

/// Returns true if the site file gives the position of each beacon. A beacon without one can absorb a wrong
/// scale of the others.
[[nodiscard]] bool are_all_placed(const Site& site);
/// The site with what contradictions blame left open: control points, delays, receivers, the speed.
[[nodiscard]] Site without_what_is_blamed(const Site& site, const std::vector<Contradiction>& blamed);

}  // namespace octant::calib
