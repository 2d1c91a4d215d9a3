// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/site_readings.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/problem/site_units.h"
#include "calib/readings/mixed_units.h"
#include "calib/readings/wiring.h"
#include "calib/statements/statement_words.h"

namespace octant::calib {
namespace {

/// Maximum number of control points for which each exchange of two is examined.
constexpr std::size_t kFewPoints = 4;

Reading unit_reading(const LengthUnit& u, const ScaledParts& parts, const std::string& whose) {
  return {
      {ContradictionKind::kUnits, "positions of " + whose, "metres",
       fmt::format("that they are in {}", u.name), 0.0,
       fmt::format("multiply them (and their sigmas, where these are in {} too) by {:g}", u.name, u.metres)},
      [u, parts](const Site& site) { return in_unit(site, u, parts); },
      {}};
}

constexpr double kSamePlaceM = 1e-3;
constexpr std::size_t kPlacesOfAMap = 3;  ///< fewer positions are equivalent to their mirror image

/// Axes of the file (written as x and y) that are x forward and y left.
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

/// Returns true if it moves a receiver to a position of no other receiver; otherwise it is another wiring.
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

std::vector<Reading> other_ranging(const Site& site) {
  if (site.timing.clock == Clock::kCycleOffset) return {};
  const bool one_way = site.timing.ranging == Ranging::kOneWay;
  const auto read = [one_way](Site other) {
    other.timing.ranging = one_way ? Ranging::kTwoWay : Ranging::kOneWay;
    return other;
  };
  return {Reading{
      {ContradictionKind::kRanging, "the arrivals", one_way ? "one_way" : "two_way",
       one_way ? "that the times of flight are times there and back (two-way), though timing.ranging says "
                 "one_way"
               : "that the times of flight are one-way times, though timing.ranging says two_way, the time "
                 "there and back",
       0.0, one_way ? "state timing.ranging: two_way, and turnaround_s" : "state timing.ranging: one_way"},
      read,
      {}}};
}

std::vector<Reading> unit_by_ranges(const Site& site, const std::vector<MeasurementLog>& runs) {
  std::vector<bool> placed;
  for (const SiteBeacon& b : site.beacons)
    placed.push_back(std::ranges::any_of(b.position_m, [](const auto& x) { return x.has_value(); }));
  std::vector<Reading> readings;
  for (const LengthUnit& u : length_units()) {
    if (!are_all_in_unit_by_ranges(site, runs, u)) continue;
    readings.push_back(unit_reading(u, {placed, false}, "the beacons"));
    readings.push_back(unit_reading(u, {placed, true}, "the beacons and receivers"));
  }
  return readings;
}

std::vector<Reading> other_units(const Site& site, const std::vector<MeasurementLog>& runs, bool some_only) {
  const std::vector<bool> none(site.beacons.size(), false);
  std::vector<bool> all = none;
  for (std::size_t b = 0; b < all.size(); ++b)
    all[b] = std::ranges::any_of(site.beacons[b].position_m, [](const auto& x) { return x.has_value(); });
  const bool placed = std::ranges::find(all, true) != all.end();
  std::vector<Reading> readings;
  for (const LengthUnit& u : length_units()) {
    if (placed && !some_only) readings.push_back(unit_reading(u, {all, false}, "the beacons"));
    if (placed && !some_only) readings.push_back(unit_reading(u, {all, true}, "the beacons and receivers"));
    if (!some_only) readings.push_back(unit_reading(u, {none, true}, "the receivers"));
    std::vector<std::vector<bool>> shares = beacons_in_unit_by_ranges(site, runs, u);
    const std::vector<bool> by_size = beacons_in_unit(site, u);
    if (std::ranges::find(shares, by_size) == shares.end()) shares.push_back(by_size);
    for (const std::vector<bool>& some : shares) {
      std::vector<std::string> names;
      for (std::size_t b = 0; b < some.size(); ++b)
        if (some[b]) names.push_back(site.beacons[b].name);
      if (!names.empty())
        readings.push_back(unit_reading(u, {some, false}, fmt::format("beacons {}", fmt::join(names, ", "))));
    }
  }
  return readings;
}

std::vector<Reading> exchanged_points(const Site& site) {
  std::vector<std::size_t> points;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    if (site.beacons[b].is_control_point()) points.push_back(b);
  std::vector<Reading> readings;
  if (points.size() > kFewPoints) return readings;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const std::size_t a = points[i], b = points[j];
      readings.push_back({exchange_in_words(site.beacons[a], site.beacons[b]),
                          [a, b](const Site& stated) {
                            Site other = stated;
                            std::swap(other.beacons[a].position_m, other.beacons[b].position_m);
                            return other;
                          },
                          {}});
    }
  return readings;
}

std::vector<Reading> heights_downwards(const Site& site) {
  if (!has_heights(site)) return {};
  return {Reading{heights_in_words(),
                  [](const Site& stated) {
                    Site other = stated;
                    turn_heights(other);
                    return other;
                  },
                  {}}};
}

std::vector<Reading> common_delay(const Site& site, double typical_range_m) {
  constexpr double kWide = 0.1;  // share of the typical range within which the initialisation converges
  if (site.timing.clock == Clock::kCycleOffset || site.timing.delay_per.receiver) return {};
  const double sigma_s = kWide * typical_range_m / speed_mps(site.medium);
  if (largest_delay_sigma_s(site) > sigma_s) return {};
  const bool has_delays = !site.timing.delay_per.none();
  return {Reading{{ContradictionKind::kDelay, "all beacons",
                   has_delays ? "delays as in the site file" : "no delays (delay_per: none)",
                   "that all times of flight have one delay more", 0.0,
                   "state the delay of the devices: timing.delay_s with a delay_sigma_s"},
                  [sigma_s](const Site& stated) {
                    Site other = stated;
                    if (other.timing.delay_per.beacon)
                      for (SiteBeacon& b : other.beacons)
                        if (!b.delay_sigma_s) b.delay_sigma_s = other.timing.delay_sigma_s;
                    other.timing.delay_per.site = true;
                    other.timing.delay_sigma_s = sigma_s;
                    return other;
                  },
                  {}}};
}

std::vector<Reading> points_elsewhere(const Site& site) {
  std::vector<Reading> readings;
  for (std::size_t b = 0; b < site.beacons.size(); ++b) {
    if (!site.beacons[b].is_control_point()) continue;
    const std::string& name = site.beacons[b].name;
    const Eigen::Vector3d at = *site.beacons[b].place_m();
    readings.push_back(
        {{ContradictionKind::kControlPoint, name,
          fmt::format("at ({:.3f}, {:.3f}, {:.3f}) m, held fixed", at.x(), at.y(), at.z()),
          "that it is elsewhere: the others agree without it", 0.0,
          fmt::format("survey control point {} again, check its label and its line in the site file", name)},
         [b](const Site& stated) {
           Site other = stated;
           other.beacons[b].position_m = {};
           other.beacons[b].sigma_m = {};
           return other;
         },
         {}});
  }
  return readings;
}

std::vector<Reading> other_wirings(const Site& site, const Solution& solution, bool exchanges) {
  std::vector<Reading> readings;
  const std::vector<bool> doubtful = doubtful_receivers(site, solution.trajectories);
  for (std::size_t v = 0; v < site.vehicles.size(); ++v)
    for (const Wiring& wiring : wirings(site, VehicleId(v), doubtful)) {
      if (wiring.is_exchange() != exchanges) continue;
      readings.push_back(
          {{ContradictionKind::kWiring, "of " + site.vehicles[v].name, "wired as in the site file",
            "that " + wiring.words, 0.0, "check the cables, or exchange the places in the site file"},
           [v, wiring](const Site& stated) { return rewired(stated, VehicleId(v), wiring); },
           {}});
    }
  return readings;
}

bool are_all_placed(const Site& site) {
  return std::ranges::all_of(site.beacons, [](const SiteBeacon& b) { return b.place_m().has_value(); });
}

ReleasedSite without_what_is_blamed(const Site& site, const std::vector<Contradiction>& blamed) {
  constexpr double kLooseReceiver_m = 0.5, kLooseSpeed_mps = 30.0, kLooseDelay = 100.0;
  ReleasedSite released{site};
  Site& open = released.site;
  for (const Contradiction& c : blamed) {
    const auto names = [&](const std::string& name) {
      return (", " + c.subject + ",").find(", " + name + ",") != std::string::npos;
    };
    if (c.kind == ContradictionKind::kControlPoint || c.kind == ContradictionKind::kExchanged ||
        c.kind == ContradictionKind::kBeacon)
      for (SiteBeacon& b : open.beacons)
        if (names(b.name)) b.sigma_m = {}, released.parameters += 3;
    if (c.kind == ContradictionKind::kSpeed) open.speed_sigma_mps = kLooseSpeed_mps, ++released.parameters;
    if (c.kind == ContradictionKind::kReceiver)
      for (SiteReceiver& r : open.receivers)
        r.sigma_m.setConstant(kLooseReceiver_m), released.parameters += 3;
    if (c.kind != ContradictionKind::kDelay) continue;
    if (open.timing.delay_per.none()) open.timing.delay_per.beacon = true;
    open.timing.delay_sigma_s = kLooseDelay * std::max(site.timing.delay_sigma_s, site.noise.tof_sigma_s);
    for (SiteBeacon& b : open.beacons) b.delay_sigma_s.reset(), ++released.parameters;
  }
  return released;
}

std::vector<Reading> other_receiver_axes(const Site& site) {
  std::vector<Reading> readings;
  for (std::size_t v = 0; v < site.vehicles.size(); ++v) {
    if (site.vehicles[v].receiver_count < 2) continue;  // a single receiver has no left and right
    for (const AxesReading& axes : kAxes)
      if (is_another_array(site, v, axes))
        readings.push_back({{ContradictionKind::kWiring, "of " + site.vehicles[v].name,
                             "at their places in the vehicle frame",
                             "that the receivers of " + site.vehicles[v].name + " are " + axes.words, 0.0,
                             "write the receivers' places with x forward, y left and z up"},
                            [v, axes](const Site& stated) { return with_receivers_read(stated, v, axes); },
                            {}});
  }
  return readings;
}

std::vector<Reading> mirrored_map(const Site& site) {
  const auto placed = std::ranges::count_if(
      site.beacons, [](const SiteBeacon& b) { return b.position_m[0] && b.position_m[1]; });
  if (static_cast<std::size_t>(placed) < kPlacesOfAMap) return {};
  return {
      Reading{{ContradictionKind::kExchanged, "of the site file", "in a right-handed frame (z up)",
               "that their map is mirrored: x and y are exchanged, or one of them has the wrong sign", 0.0,
               "write the positions of the beacons in a right-handed frame: x and y as seen from above, "
               "counter-clockwise from x to y"},
              [](const Site& stated) { return with_map_mirrored(stated); },
              {}}};
}

}  // namespace octant::calib
