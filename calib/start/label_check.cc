// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/label_check.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calib/problem/log_totals.h"
#include "calib/problem/ranges.h"
#include "calib/problem/site_units.h"
#include "calib/problem/trilaterate.h"

namespace octant::calib {
namespace {

constexpr double kFarSigmas = 6.0;
constexpr double kNearSigmas = 4.0;
constexpr double kMostlyRejected = 0.5;

/// Distance of a beacon's estimate from a stated position in sigmas of its own prior, worst coordinate; 0
/// without priors.
double off_in_sigmas(const ParameterLayout& layout, const Eigen::VectorXd& x, std::size_t b,
                     const SiteBeacon& stated) {
  double worst = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const int column = layout.beacon[b][i];
    if (column < 0 || !stated.position_m[i]) continue;
    const double sigma = layout.parameter(column).prior_sigma;
    if (std::isfinite(sigma)) worst = std::max(worst, std::abs(x[column] - *stated.position_m[i]) / sigma);
  }
  return worst;
}

/// "; it seems to be in feet" where the place is the stated one in another unit.
std::string unit_in_words(const SiteBeacon& b, const Eigen::Vector3d& found_m, double typical_range_m) {
  constexpr double kOff = 0.01;  // of the range, as far as a place may be off that its ranges alone gave
  if (!b.place_m()) return "";
  const auto unit = unit_of_place(*b.place_m(), found_m, kOff * typical_range_m);
  return unit ? fmt::format("; its unit seems to be {}, not metres", unit->name) : "";
}

void set_prior_mean(ParameterLayout& layout, std::size_t b, const SiteBeacon& stated) {
  for (std::size_t i = 0; i < 3; ++i)
    if (layout.beacon[b][i] >= 0 && stated.position_m[i])
      layout.parameter(layout.beacon[b][i]).prior_mean = *stated.position_m[i];
}

}  // namespace

LabelCheck check_labels(const Problem& problem, ParameterLayout& layout, const Eigen::VectorXd& x,
                        const std::vector<std::size_t>& trusted) {
  LabelCheck result;
  const auto& beacons = problem.site.beacons;
  std::vector<std::size_t> far;
  for (std::size_t b = 0; b < beacons.size(); ++b)
    if (off_in_sigmas(layout, x, b, beacons[b]) > kFarSigmas) far.push_back(b);
  std::vector<bool> explained(beacons.size(), false);
  for (const std::size_t a : far)
    for (const std::size_t b : far) {
      if (b <= a || explained[a] || explained[b] || !beacons[a].place_m() || !beacons[b].place_m()) continue;
      if (off_in_sigmas(layout, x, a, beacons[b]) > kNearSigmas ||
          off_in_sigmas(layout, x, b, beacons[a]) > kNearSigmas)
        continue;
      explained[a] = explained[b] = true;
      set_prior_mean(layout, a, beacons[b]);
      set_prior_mean(layout, b, beacons[a]);
      result.warnings.push_back(fmt::format(
          "beacons {} and {} stand at each other's places: their positions (or labels) are exchanged in the "
          "site file; calibrated where the arrivals put them, check the labels on the wall",
          beacons[a].name, beacons[b].name));
    }
  for (const std::size_t b : far) {
    if (explained[b] || std::ranges::find(trusted, b) != trusted.end()) continue;
    double distance2 = 0.0;
    Eigen::Vector3d found_m = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const int column = layout.beacon[b][static_cast<std::size_t>(i)];
      found_m[i] = column >= 0 ? x[column] : beacons[b].position_m[static_cast<std::size_t>(i)].value_or(0.0);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const int column = layout.beacon[b][i];
      if (column < 0 || !beacons[b].position_m[i]) continue;
      distance2 += std::pow(x[column] - *beacons[b].position_m[i], 2);
      layout.parameter(column).prior_sigma = INFINITY;
    }
    result.disregarded.push_back(b);
    result.warnings.push_back(fmt::format(
        "beacon {} is, by a first estimate, {:.3g} m from where the site file has it, beyond what its sigma "
        "allows; its stated position "
        "is disregarded, check its label and the site file{}",
        beacons[b].name, std::sqrt(distance2), unit_in_words(beacons[b], found_m, typical_range_m(problem))));
  }
  result.mended = !far.empty();
  return result;
}

std::vector<std::string> suspect_control_points(const Problem& problem, const SharedState& state,
                                                const std::vector<Trajectory>& trajectories) {
  std::vector<std::string> warnings;
  const auto& beacons = problem.site.beacons;
  const std::vector<RejectionCounts> counts = rejections_by_beacon(trajectories, beacons.size());
  for (std::size_t b = 0; b < beacons.size(); ++b) {
    const std::size_t placed = counts[b].all() - counts[b].of(Rejection::kNoPose),
                      rejected = placed - counts[b].of(Rejection::kUsed);
    if (!beacons[b].is_control_point() || placed < 10 ||
        static_cast<double>(rejected) < kMostlyRejected * static_cast<double>(placed))
      continue;
    const std::vector<RangeFrom> ranges = ranges_to(trajectories, state, BeaconId(b));
    TrilaterationOptions options;
    options.scale_m = 0.01 * typical_range_m(problem);
    const Trilateration place = trilaterate(ranges, options);
    std::string where = "somewhere else";
    for (std::size_t other = 0; other < beacons.size(); ++other) {
      if (other == b || !beacons[other].place_m()) continue;
      if (place.ok &&
          (*beacons[other].place_m() - place.p_map_m).head<2>().norm() < 0.1 * typical_range_m(problem))
        where = "where the site file has " + beacons[other].name;
    }
    warnings.push_back(
        fmt::format("control point {}: {} of {} arrivals do not fit its stated position, it seems to stand "
                    "{}; check its label and the "
                    "site file{}",
                    beacons[b].name, rejected, ranges.size(), where,
                    place.ok ? unit_in_words(beacons[b], place.p_map_m, typical_range_m(problem)) : ""));
  }
  return warnings;
}

}  // namespace octant::calib
