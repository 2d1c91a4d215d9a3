// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/site_frames.h"

#include <algorithm>
#include <array>
#include <utility>

namespace octant::calib {
namespace {

constexpr double kSamePlaceM = 1e-3;
constexpr std::size_t kPlacesOfAMap = 3;  ///< fewer are the same map mirrored

/// Where x forward and y left are, of what was written as x and y.
struct AxesReading {
  bool exchanged;
  double sign_x, sign_y;
  const char* words;
  [[nodiscard]] Eigen::Vector3d read(const Eigen::Vector3d& v) const {
    return exchanged ? Eigen::Vector3d(sign_x * v.y(), sign_y * v.x(), v.z())
                     : Eigen::Vector3d(sign_x * v.x(), sign_y * v.y(), v.z());
  }
};
constexpr std::array kAxes = {
    AxesReading{false, 1, -1, "mirrored, left called right: their y has the wrong sign"},
    AxesReading{false, -1, 1, "mirrored, front called rear: their x has the wrong sign"},
    AxesReading{true, 1, 1, "mirrored: their x and y are exchanged"},
    AxesReading{true, 1, -1, "turned: x counts to the right and y forward, not x forward and y left"},
    AxesReading{true, -1, 1, "turned: x counts to the left and y backward, not x forward and y left"},
    AxesReading{false, -1, -1, "turned: x counts backward and y to the right, not x forward and y left"}};

Site with_receivers_read(const Site& site, std::size_t vehicle, const AxesReading& axes) {
  Site other = site;
  for (SiteReceiver& r : other.receivers) {
    if (r.vehicle.index() != vehicle) continue;
    r.position_m = axes.read(r.position_m);
    r.sigma_m = axes.read(r.sigma_m).cwiseAbs();
    if (r.axis) r.axis = axes.read(*r.axis);
  }
  return other;
}

/// Whether it moves a receiver, and to where none of the others stands: that is another wiring.
bool is_another_array(const Site& site, std::size_t vehicle, const AxesReading& axes) {
  return std::ranges::any_of(site.receivers, [&](const SiteReceiver& r) {
    const Eigen::Vector3d read = axes.read(r.position_m);
    return r.vehicle.index() == vehicle && std::ranges::none_of(site.receivers, [&](const SiteReceiver& s) {
             return s.vehicle == r.vehicle && (s.position_m - read).norm() < kSamePlaceM;
           });
  });
}

Site with_map_mirrored(Site site) {
  for (SiteBeacon& b : site.beacons) {
    std::swap(b.position_m[0], b.position_m[1]);
    std::swap(b.sigma_m[0], b.sigma_m[1]);
  }
  return site;
}

}  // namespace

std::vector<Reading> other_site_frames(const Site& site) {
  std::vector<Reading> readings;
  for (std::size_t v = 0; v < site.vehicles.size(); ++v) {
    if (site.vehicles[v].receiver_count < 2) continue;  // one has no left and right
    for (const AxesReading& axes : kAxes)
      if (is_another_array(site, v, axes))
        readings.push_back({{ContradictionKind::kWiring, "of " + site.vehicles[v].name,
                             "at their places in the vehicle frame",
                             "that the receivers of " + site.vehicles[v].name + " are " + axes.words, 0.0,
                             "write the receivers' places with x forward, y left and z up"},
                            [v, axes](const Site& stated) { return with_receivers_read(stated, v, axes); },
                            {}});
  }
  const auto placed = std::ranges::count_if(
      site.beacons, [](const SiteBeacon& b) { return b.position_m[0] && b.position_m[1]; });
  if (static_cast<std::size_t>(placed) >= kPlacesOfAMap)
    readings.push_back(
        {{ContradictionKind::kExchanged, "of the site file", "in a right-handed frame (z up)",
          "that their map is mirrored: x and y are exchanged, or one of them has the wrong sign", 0.0,
          "write the positions of the beacons in a right-handed frame: x and y as seen from above, "
          "counter-clockwise from x to y"},
         [](const Site& stated) { return with_map_mirrored(stated); },
         {}});
  return readings;
}

}  // namespace octant::calib
