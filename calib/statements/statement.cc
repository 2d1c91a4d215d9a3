// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/statement.h"

#include <algorithm>
#include <cmath>

namespace octant::calib {

std::vector<int> columns_of(const Statement& s, const ParameterLayout& layout) {
  std::vector<int> columns;
  const auto add = [&](int c) {
    if (c >= 0) columns.push_back(c);
  };
  switch (s.what) {
    case What::kControlPoint:
      for (const int c : layout.beacon[s.index]) add(c);
      break;
    case What::kPlace:
      for (const int c : layout.beacon[s.index])
        if (c >= 0 && std::isfinite(layout.parameter(c).prior_sigma)) add(c);
      break;
    case What::kBeaconDelay: add(layout.column_of(parameters::beacon_delay(s.index))); break;
    case What::kReceiverDelay: add(layout.column_of(parameters::receiver_delay(s.index))); break;
    case What::kSiteDelay: add(layout.column_of(parameters::site_delay())); break;
    case What::kNoDelays:
    case What::kOneDelay:
    case What::kDelays:
      for (std::size_t b = 0; b < layout.beacon.size(); ++b)
        add(layout.column_of(parameters::beacon_delay(b)));
      break;
    case What::kSpeed: add(layout.speed[s.index]); break;
    case What::kHeldSpeed:
      for (const int c : layout.speed) add(c);
      break;
    case What::kReceiver:
      for (const int c : layout.receiver[s.index]) add(c);
      break;
    case What::kAttenuation: add(layout.column_of(parameters::attenuation(s.index))); break;
    case What::kDistance: break;
  }
  return columns;
}

std::vector<Statement> StatedSite::all() const {
  const Site& s = site();
  const auto is_free = [this](const ParameterId& id) { return layout_.column_of(id) >= 0; };
  std::vector<Statement> stated;
  for (std::size_t b = 0; b < s.beacons.size(); ++b) {
    if (s.beacons[b].is_control_point() && beacon_usable_[b]) stated.push_back({What::kControlPoint, b});
    if (!columns_of({What::kPlace, b}, layout_).empty()) stated.push_back({What::kPlace, b});
    if (is_free(parameters::beacon_delay(b))) stated.push_back({What::kBeaconDelay, b});
  }
  for (std::size_t r = 0; r < s.receivers.size(); ++r) {
    if (is_free(parameters::receiver_delay(r))) stated.push_back({What::kReceiverDelay, r});
    if (std::max({layout_.receiver[r][0], layout_.receiver[r][1], layout_.receiver[r][2]}) >= 0)
      stated.push_back({What::kReceiver, r});
  }
  if (is_free(parameters::site_delay())) stated.push_back({What::kSiteDelay, 0});
  const bool has_delay = largest_delay_sigma_s(s) > 0;
  if (!has_delay && s.timing.clock == Clock::kSynchronised && s.tof_sigma_given)
    stated.push_back({What::kNoDelays, 0});
  for (std::size_t run = 0; run < layout_.speed.size(); ++run) stated.push_back({What::kSpeed, run});
  for (std::size_t i = 0; i < kAttenuationUnknowns; ++i)
    if (is_free(parameters::attenuation(i))) stated.push_back({What::kAttenuation, i});
  for (std::size_t d = 0; d < s.distances.size(); ++d) stated.push_back({What::kDistance, d});
  return stated;
}

std::vector<Statement> StatedSite::common_causes() const {
  std::vector<Statement> causes;
  const Timing& timing = site().timing;
  const bool has_delays = timing.clock == Clock::kSynchronised && largest_delay_sigma_s(site()) > 0;
  if (has_delays && timing.delay_per.beacon) causes.push_back({What::kDelays, 0});
  if (has_delays && timing.delay_per.site && !timing.delay_per.beacon) causes.push_back({What::kOneDelay, 0});
  if (layout_.speed.empty()) causes.push_back({What::kHeldSpeed, 0});
  return causes;
}

/// Sigma of a released parameter: so wide that only the data determine it, but finite, so that parameters
/// that they do not determine keep their value.
double StatedSite::wide_sigma(const Statement& s) const {
  switch (s.what) {
    case What::kSpeed:
    case What::kHeldSpeed: return 0.3;
    case What::kReceiver: return 1.0;
    case What::kAttenuation: return 10.0;
    default: return problem_.typical_range_m;
  }
}

/// Maximum number of parameters for dense matrices in refits; the tests of assumptions form these anyway.
constexpr int kDenseRefit = 1000;
/// Any positive value, because the prior is widened afterwards.
constexpr double kReleasedSpeed_mps = 30.0;

ParameterLayout StatedSite::layout_without(const std::vector<Statement>& released, const SharedState& state,
                                           Problem& problem) const {
  problem.site = site();
  std::vector<std::size_t> distances;
  Timing& timing = problem.site.timing;
  for (const Statement& s : released) {
    if (s.what == What::kControlPoint) problem.site.beacons[s.index].sigma_m = {};
    if (s.what == What::kHeldSpeed) problem.site.speed_sigma_mps = kReleasedSpeed_mps;
    if (s.what == What::kDistance) distances.push_back(s.index);
    if (s.what == What::kOneDelay) timing.delay_per.beacon = true;
    if (s.what != What::kNoDelays) continue;
    timing.delay_per = {.beacon = true};
    timing.delay_sigma_s = 1.0;
    for (SiteBeacon& b : problem.site.beacons) b.delay_sigma_s.reset();
  }
  std::sort(distances.rbegin(), distances.rend());
  for (const std::size_t d : distances)
    problem.site.distances.erase(problem.site.distances.begin() + static_cast<std::ptrdiff_t>(d));
  ParameterLayout layout = make_layout(problem, state, beacon_usable_);
  layout.dense_limit = std::max(layout_.dense_limit, kDenseRefit);
  // Priors of the calibration's layout, in which labels were corrected.
  for (std::size_t b = 0; b < layout.beacon.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i)
      if (const int old = layout_.beacon[b][i], c = layout.beacon[b][i]; old >= 0 && c >= 0)
        layout.parameter(c) = layout_.parameter(old);
  for (const Statement& s : released)
    for (const int c : columns_of(s, layout)) {
      Parameter& p = layout.parameter(c);
      p.prior_mean = value(s, layout, c);
      p.prior_sigma = wide_sigma(s);
    }
  return layout;
}

double StatedSite::value(const Statement& s, const ParameterLayout& layout, int column) const {
  if (s.what == What::kControlPoint) {
    for (std::size_t i = 0; i < 3; ++i)
      if (layout.beacon[s.index][i] == column) return *site().beacons[s.index].position_m[i];
  }
  const Parameter& p = layout.parameter(column);
  // The delay's prior mean then applies to the beacons.
  if (s.what == What::kOneDelay) return beacon_delay_prior(site(), p.id.owner).value / p.si_per_unit;
  // If receivers or the site have the delay, the delays of the beacons are added to it.
  if (s.what == What::kNoDelays)
    return site().timing.delay_per.beacon ? beacon_delay_prior(site(), p.id.owner).value / p.si_per_unit
                                          : 0.0;
  return p.prior_mean;
}

double StatedSite::sigma(const Statement& s, const ParameterLayout& layout, int column) const {
  const ParameterId& id = layout.parameter(column).id;
  if (is_held(s)) return 0.0;
  for (const Parameter& p : layout_.parameters)
    if (p.id == id) return p.prior_sigma;
  return 0.0;
}

}  // namespace octant::calib
