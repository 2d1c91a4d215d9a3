// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/network/beacon_ranges.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "models/physics/medium.h"
#include "models/support/normal_noise.h"

namespace octant {
namespace {

/// Deviation from the median, in sigmas, from which a range counts as an echo or a fault.
constexpr double kEchoSigmas = 4.0;

/// Median; the lower of the two middle values of an even number, because echoes are late.
double middle_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Mean of the times near the median, with its sigma from their scatter.
void combine_times(const std::vector<double>& times_s, double noise_s, BeaconRange& range) {
  std::vector<double> sorted = times_s;
  const double middle_s = middle_of(sorted);
  for (double& t : sorted) t = std::abs(t - middle_s);
  const double scatter_s = std::max(noise_s, middle_of(sorted) / kMedianOfNormal);
  double sum_s = 0.0;
  for (const double t : times_s)
    if (std::abs(t - middle_s) <= kEchoSigmas * scatter_s) {
      sum_s += t;
      ++range.used;
    }
  range.left_out = times_s.size() - range.used;
  range.tof_s = sum_s / static_cast<double>(range.used);
  range.sigma_s = scatter_s / std::sqrt(static_cast<double>(range.used));
}

}  // namespace

Eigen::MatrixXd BeaconRanges::covariance(double sigma_s) const {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const BeaconRange& a = pairs[static_cast<std::size_t>(i)];
    c(i, i) = a.sigma_s * a.sigma_s;
    for (Eigen::Index k = 0; k <= i; ++k) {
      const BeaconRange& b = pairs[static_cast<std::size_t>(k)];
      const int common = (a.from == b.from) + (a.from == b.to) + (a.to == b.from) + (a.to == b.to);
      c(i, k) += sigma_s * sigma_s * common;
      c(k, i) = c(i, k);
    }
  }
  return c;
}

void BeaconRanges::set_delay_sigma(double sigma_s) {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  delay_sigma_s = sigma_s;
  root = covariance(sigma_s).llt().matrixL().solve(Eigen::MatrixXd::Identity(n, n));
}

/// Declared in unweighted_ranges.h.
BeaconRanges unweighted_ranges(const Site& site, const std::vector<BeaconFlight>& flights,
                               const std::vector<MeasurementLog>& runs) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<double>> times_s;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> first_run;
  const double known_s = site.timing.delay_s + site.timing.turnaround_s;
  const auto speed_in = [&](std::size_t run) {
    const auto temperature_degC = run < runs.size() ? runs[run].temperature_degC : std::optional<double>{};
    return speed_mps(site.medium, temperature_degC.value_or(site.medium.temperature_degC));
  };
  for (const BeaconFlight& flight : flights) {
    const std::pair<std::size_t, std::size_t> ends = std::minmax({flight.from.index(), flight.to.index()});
    const std::size_t first = first_run.emplace(ends, flight.run).first->second;
    // Times in other recordings count at the speed of the first one.
    const double ratio = first == flight.run ? 1.0 : speed_in(flight.run) / speed_in(first);
    times_s[ends].push_back(ratio * (flight.tof_s - known_s));
  }
  BeaconRanges ranges;
  const double bias_s = std::hypot(site.noise.tof_sigma_s, site.noise.pair_sigma_s.value_or(0.0));
  for (const auto& [ends, times] : times_s) {
    BeaconRange& range = ranges.pairs.emplace_back();
    range.from = BeaconId(ends.first);
    range.to = BeaconId(ends.second);
    range.run = first_run.at(ends);
    range.model_speed_mps = speed_in(range.run);
    combine_times(times, site.noise.tof_sigma_s, range);
    range.sigma_s = std::hypot(range.sigma_s, bias_s);
  }
  ranges.delay_sigma_s = bias_s;
  return ranges;
}

BeaconRanges beacon_ranges(const Site& site, const std::vector<BeaconFlight>& flights,
                           const std::vector<MeasurementLog>& runs) {
  BeaconRanges ranges = unweighted_ranges(site, flights, runs);
  ranges.set_delay_sigma(ranges.delay_sigma_s);
  return ranges;
}

}  // namespace octant
