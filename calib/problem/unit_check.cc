// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/unit_check.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "calib/problem/ranges.h"
#include "calib/problem/site_units.h"

namespace octant::calib {
namespace {

/// Median ranges lie between a hundredth and three extents of a site, most often near two fifths.
constexpr double kShortest = 0.003, kLongest = 3.0, kUsual = 0.4;
constexpr double kFastestMps = 5.0;
constexpr std::size_t kPairsNeeded = 50, kNeighbours = 6;
constexpr double kTogetherS = 0.25;

/// Delay of an arrival in addition to its path: the prior mean of the delay, which applies once for any kind
/// of delay (prior_state), and the turnaround.
double stated_lateness_s(const Site& site, const Arrival& a) {
  const Timing& timing = site.timing;
  const double delay_s =
      timing.delay_per.beacon ? beacon_delay_prior(site, a.beacon.index()).value : timing.delay_s;
  return delay_s + (timing.ranging == Ranging::kTwoWay ? timing.turnaround_s : 0.0);
}

std::optional<Finding> wrong_unit(const Site& site, const MeasurementLog& run, double extent) {
  std::vector<double> tof;
  for (const Arrival& a : run.arrivals) {
    // Radio's delays may be many times its ways. One that is longer than the time is misstated itself.
    const double late_s = stated_lateness_s(site, a), all_s = std::abs(a.tof_s);
    tof.push_back(all_s > late_s ? all_s - late_s : all_s);
  }
  const double c = speed_mps(site.medium), median_tof_s = median(std::move(tof));
  const double legs = site.timing.legs(), ratio = median_tof_s * c / legs / extent;
  if (ratio <= kLongest && (ratio >= kShortest || site.timing.clock == Clock::kCycleOffset)) return {};
  struct Unit {
    const char* name;
    double factor, off;
  };
  std::vector<Unit> units = {{"milliseconds", 1e-3, 0},
                             {"microseconds", 1e-6, 0},
                             {"nanoseconds", 1e-9, 0},
                             {"metres", legs / c, 0},
                             {"millimetres", 1e-3 * legs / c, 0}};
  for (Unit& u : units) u.off = std::abs(std::log(ratio * u.factor / kUsual));
  std::ranges::sort(units, {}, &Unit::off);
  std::string guess;
  for (const Unit& u : units)
    if (ratio > kLongest && u.off < std::log(10.0))
      guess += (guess.empty() ? "" : " or ") + std::string(u.name);
  return Finding{
      "unit",
      fmt::format("the median time of flight of {:.4g} s makes {:.4g} m at a site {:.4g} m across: {}",
                  median_tof_s, ratio * extent, extent,
                  guess.empty() ? "check the unit of tof_s and medium.speed_mps"
                                : "tof_s looks like " + guess + ", not seconds")};
}

/// A beacon's place where the site knows it to a tenth of its extent.
std::optional<Eigen::Vector3d> known_place(const SiteBeacon& b, double extent, double& sigma_m) {
  sigma_m = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!b.position_m[i] || !b.sigma_m[i] || *b.sigma_m[i] > 0.1 * extent) return {};
    sigma_m = std::max(sigma_m, *b.sigma_m[i]);
  }
  return b.place_m();
}

/// Two ranges from one place: they differ by no more than the beacons' distance and add up to no less.
struct PairOfRanges {
  double first_m, second_m, apart_m, slack_m;
  [[nodiscard]] bool contradicts(double factor) const {
    return factor * std::abs(first_m - second_m) > apart_m + slack_m ||
           factor * (first_m + second_m) < apart_m - slack_m;
  }
};

std::vector<PairOfRanges> pairs_of_ranges(const Site& site, const MeasurementLog& run, double extent) {
  std::vector<PairOfRanges> pairs;
  Eigen::AlignedBox3d array;
  for (const SiteReceiver& r : site.receivers) array.extend(r.position_m);
  const double c = speed_mps(site.medium);
  const double common_m = (array.isEmpty() ? 0.0 : array.diagonal().norm()) +
                          3 * c * (site.noise.tof_sigma_s + largest_delay_sigma_s(site));
  std::vector<double> sigma(site.beacons.size());
  std::vector<std::optional<Eigen::Vector3d>> place;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    place.push_back(known_place(site.beacons[b], extent, sigma[b]));
  const std::size_t stride = 1 + run.arrivals.size() / 20'000;
  for (std::size_t i = 0; i < run.arrivals.size(); i += stride)
    for (std::size_t j = i + 1; j < std::min(run.arrivals.size(), i + 1 + kNeighbours); ++j) {
      const Arrival& a = run.arrivals[i];
      const Arrival& b = run.arrivals[j];
      const auto &pa = place[a.beacon.index()], &pb = place[b.beacon.index()];
      const bool together = run.has_epochs ? a.epoch == b.epoch : std::abs(b.time_s - a.time_s) <= kTogetherS;
      if (a.beacon == b.beacon || a.vehicle != b.vehicle || !pa || !pb || !together) continue;
      const double apart = (*pa - *pb).norm(),
                   moved = run.has_epochs ? 0.0 : kFastestMps * std::abs(b.time_s - a.time_s);
      pairs.push_back(
          {stated_range_m(site, run, a), stated_range_m(site, run, b), apart,
           common_m + moved + 0.03 * apart + 2 * (sigma[a.beacon.index()] + sigma[b.beacon.index()])});
    }
  return pairs;
}

std::optional<Finding> factor_two(const Site& site, const MeasurementLog& run, double extent) {
  if (site.timing.clock == Clock::kCycleOffset) return {};
  const std::vector<PairOfRanges> pairs = pairs_of_ranges(site, run, extent);
  if (pairs.size() < kPairsNeeded) return {};
  const auto share = [&](double factor) {
    return static_cast<double>(std::ranges::count_if(
               pairs, [factor](const PairOfRanges& p) { return p.contradicts(factor); })) /
           static_cast<double>(pairs.size());
  };
  const double as_stated = share(1.0);
  if (as_stated < 0.1) return {};
  for (const double factor : {0.5, 2.0}) {
    if (share(factor) > std::min(0.02, 0.2 * as_stated)) continue;
    return Finding{
        "two_way",
        fmt::format("{:.0f} % of the pairs of ranges contradict the beacons' distances, hardly any do when "
                    "all ranges are {}: {}",
                    100 * as_stated, factor < 1 ? "halved" : "doubled",
                    factor < 1 ? "tof_s looks like the time there and back (timing.ranging: two_way)"
                               : "tof_s looks like half of what timing.ranging makes of it (one_way?)")};
  }
  return {};
}

}  // namespace

double stated_range_m(const Site& site, const MeasurementLog& run, const Arrival& a) {
  Medium medium = site.medium;
  if (run.relative_humidity) medium.relative_humidity = *run.relative_humidity;
  if (run.pressure_pa) medium.pressure_pa = *run.pressure_pa;
  return std::max(0.0, a.tof_s - stated_lateness_s(site, a)) *
         speed_mps(medium, temperature_degC(a, run, site)) / site.timing.legs();
}

std::vector<Finding> check_units(const Site& site, const MeasurementLog& run) {
  std::vector<Finding> findings;
  const double extent = stated_extent_m(site, run.poses);
  if (run.arrivals.empty() || !(extent > 0)) return findings;
  if (auto f = wrong_unit(site, run, extent)) {
    findings.push_back(*f);
  } else if (auto g = factor_two(site, run, extent)) {
    findings.push_back(*g);
  }
  return findings;
}

}  // namespace octant::calib
