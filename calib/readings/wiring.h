// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "models/site.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// A way in which a vehicle's receivers may be wired otherwise than the site file has it.
struct Wiring {
  /// order[i]: the receiver at whose stated place the vehicle's i-th receiver really is; indices within the
  /// vehicle.
  std::vector<std::size_t> order;
  std::string words;  ///< "receivers fl and fr of robot are exchanged"
};

/// Wirings that people make, the likelier first: two receivers exchanged, left and right mirrored, all turned
/// by one or more places (each wired as its neighbour), turned and mirrored; of up to five receivers all
/// others too. Nothing for one receiver.
/// @param doubtful  receivers of the site whose exchanges are looked at where there are more than eight;
/// empty: all
[[nodiscard]] std::vector<Wiring> wirings(const Site& site, VehicleId vehicle,
                                          const std::vector<bool>& doubtful = {});

/// Receivers whose exchanges are worth a look: all of up to six, else the six whose arrivals are left out
/// most.
[[nodiscard]] std::vector<bool> doubtful_receivers(const Site& site,
                                                   const std::vector<Trajectory>& trajectories);

/// The site with a vehicle's receivers at each other's places as a wiring has them, their names as they were.
[[nodiscard]] Site rewired(const Site& site, VehicleId vehicle, const Wiring& wiring);

}  // namespace octant::calib
