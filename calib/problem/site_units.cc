// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/site_units.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calib/problem/ranges.h"

namespace octant::calib {
namespace {

constexpr double kOtherOrder = 8.0;  ///< ratio beyond which two coordinates of a site are of different orders
constexpr double kSigmaOfExtent =
    0.05;  ///< sigmas above this fraction of the site are assumed to be in its unit

bool is_placed(const SiteBeacon& b) { return b.position_m[0] && b.position_m[1]; }

double size_m(const SiteBeacon& b) {
  double largest = 0.0;
  for (const auto& x : b.position_m)
    if (x) largest = std::max(largest, std::abs(*x));
  return largest;
}

double extent_of(const Site& site) {
  const Eigen::AlignedBox3d box = box_of_places(site);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

/// Largest of all but a few times of flight; 0 without any.
double long_tof_s(const std::vector<MeasurementLog>& runs) {
  constexpr std::size_t kSome = 20'000;
  std::vector<double> tof_s;
  for (const MeasurementLog& run : runs)
    for (std::size_t i = 0; i < run.arrivals.size(); i += run.arrivals.size() / kSome + 1)
      tof_s.push_back(std::abs(run.arrivals[i].tof_s));
  if (tof_s.empty()) return 0.0;
  const std::size_t most = tof_s.size() * 9 / 10;
  return nth_smallest(std::move(tof_s), most);
}

Error too_long_a_delay(const std::string& file, int line, const std::string& key, double delay_s,
                       double longest_s) {
  std::string guess;
  for (const auto& [name, factor] :
       {std::pair{"milliseconds", 1e-3}, std::pair{"microseconds", 1e-6}, std::pair{"nanoseconds", 1e-9}})
    if (guess.empty() && factor * delay_s < 0.5 * longest_s)
      guess = fmt::format("is it in {}? Then write {:g}", name, factor * delay_s);
  return {.file = file,
          .line = line,
          .found = fmt::format("{} is {:g} s, longer than nine of ten times of flight ({:.4g} s)", key,
                               delay_s, longest_s),
          .expected = "a delay in seconds, the unit of tof_s",
          .advice = guess.empty() ? "check the unit" : guess};
}

}  // namespace

Eigen::AlignedBox3d box_of_places(const Site& site, const std::vector<TimedPose>& poses) {
  Eigen::AlignedBox3d box;
  for (const SiteBeacon& b : site.beacons)
    if (is_placed(b))
      box.extend(Eigen::Vector3d(*b.position_m[0], *b.position_m[1], b.position_m[2].value_or(0.0)));
  for (const TimedPose& pose : poses) box.extend(pose.T_map_vehicle.translation_m);
  return box;
}

double stated_extent_m(const Site& site, const std::vector<TimedPose>& poses) {
  const Eigen::AlignedBox3d box = box_of_places(site, poses);
  double extent = box.isEmpty() ? 0.0 : box.diagonal().norm();
  for (const ControlDistance& d : site.distances) extent = std::max(extent, d.distance_m);
  return extent;
}

const std::vector<LengthUnit>& length_units() {
  static const std::vector<LengthUnit> units = {
      {"centimetres", 0.01}, {"millimetres", 0.001}, {"feet", 0.3048}, {"inches", 0.0254}};
  return units;
}

std::optional<LengthUnit> unit_of_place(const Eigen::Vector3d& stated, const Eigen::Vector3d& found_m,
                                        double sigma_m) {
  constexpr double kShare = 0.01;
  for (const LengthUnit& unit : length_units()) {
    const double off = (unit.metres * stated - found_m).norm();
    const bool far_from_stated = (stated - found_m).norm() > 10 * (3 * sigma_m + kShare * found_m.norm());
    if (far_from_stated && off < 3 * sigma_m + kShare * found_m.norm()) return unit;
  }
  return {};
}

std::vector<bool> beacons_in_unit(const Site& site, const LengthUnit& unit) {
  std::vector<bool> large(site.beacons.size(), false);
  std::vector<double> sizes;
  for (const SiteBeacon& b : site.beacons)
    if (is_placed(b) && size_m(b) > 0) sizes.push_back(size_m(b));
  std::ranges::sort(sizes);
  std::size_t split = 0;
  double widest = kOtherOrder;
  for (std::size_t i = 1; i < sizes.size(); ++i)
    if (sizes[i] / sizes[i - 1] > widest) {
      widest = sizes[i] / sizes[i - 1];
      split = i;
    }
  if (split == 0 || unit.metres * sizes.back() > 3 * sizes[split - 1]) return large;
  for (std::size_t b = 0; b < large.size(); ++b)
    large[b] = is_placed(site.beacons[b]) && size_m(site.beacons[b]) >= sizes[split];
  return large;
}

Site in_unit(const Site& site, const LengthUnit& unit, const ScaledParts& parts) {
  Site other = site;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    if (parts.beacons[b])
      for (auto& x : other.beacons[b].position_m)
        if (x) *x *= unit.metres;
  const double large = kSigmaOfExtent * extent_of(other);
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    if (parts.beacons[b])
      for (auto& s : other.beacons[b].sigma_m)
        if (s && *s > large) *s *= unit.metres;
  if (!parts.receivers) return other;
  for (SiteReceiver& r : other.receivers) {
    r.position_m *= unit.metres;
    const double reach = r.position_m.norm();
    for (int i = 0; i < 3; ++i)
      if (r.sigma_m[i] > 0.2 * reach) r.sigma_m[i] *= unit.metres;
  }
  return other;
}

Result<void> check_site_units(const Site& site, const std::vector<MeasurementLog>& runs) {
  if (site.timing.clock == Clock::kCycleOffset || site.timing.delay_per.none()) return {};
  const double longest_s = long_tof_s(runs);
  if (!(longest_s > 0)) return {};
  if (site.timing.delay_s >= longest_s)
    return fail(too_long_a_delay(site.path, 0, "timing.delay_s", site.timing.delay_s, longest_s));
  for (const SiteBeacon& b : site.beacons)
    if (b.delay_s.value_or(0.0) >= longest_s)
      return fail(too_long_a_delay(site.path, b.line, "delay_s of beacon " + b.name, *b.delay_s, longest_s));
  return {};
}

}  // namespace octant::calib
