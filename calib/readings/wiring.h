// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Wiring of a vehicle's receivers other than that of the site file.
struct Wiring {
  /// order[i]: receiver at whose position in the site file the i-th receiver of the vehicle really is;
  /// indices within the vehicle.
  std::vector<std::size_t> order;
  std::string words;  ///< "receivers fl and fr of robot are exchanged"

  /// Returns true if all but two of three or more receivers are where they are stated.
  [[nodiscard]] bool is_exchange() const;
};

/// Wirings that occur in practice, likelier ones first: two receivers exchanged, left and right mirrored, all
/// rotated by one or more positions (each wired as its neighbour), rotated and mirrored; for up to five
/// receivers also all others. Empty for one receiver.
/// @param doubtful  receivers of the site whose exchanges are examined if there are more than eight; empty:
/// all
[[nodiscard]] std::vector<Wiring> wirings(const Site& site, VehicleId vehicle,
                                          const std::vector<bool>& doubtful = {});

/// Receivers whose exchanges are examined: all of up to six, otherwise the six with the most rejected
/// arrivals.
[[nodiscard]] std::vector<bool> doubtful_receivers(const Site& site,
                                                   const std::vector<Trajectory>& trajectories);

/// Returns the site with a vehicle's receivers at the positions of a wiring; their names are unchanged.
[[nodiscard]] Site rewired(const Site& site, VehicleId vehicle, const Wiring& wiring);

}  // namespace octant::calib
