// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/problem/trilaterate.h"
#include "models/run.h"
#include "models/site.h"
#include "models/trajectory/shared_state.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Measured temperature of an arrival: its own, otherwise that of the run; may be missing.
[[nodiscard]] inline std::optional<double> measured_temperature_degC(const Arrival& arrival,
                                                                     const MeasurementLog& run) {
  return std::isfinite(arrival.temperature_degC) ? arrival.temperature_degC : run.temperature_degC;
}
/// Temperature of the medium at an arrival: as measured, else the site's.
[[nodiscard]] inline double temperature_degC(const Arrival& arrival, const MeasurementLog& run,
                                             const Site& site) {
  return measured_temperature_degC(arrival, run).value_or(site.medium.temperature_degC);
}

/// Range of an arrival with the speed and delays of a state, without the time-walk of the attenuation's prior
/// [m].
[[nodiscard]] double prior_range_m(const Trajectory& trajectory, const ArrivalObservation& arrival,
                                   const SharedState& state);

/// Calls visit(trajectory, arrival) for an even sample of all arrivals, which determines a median or a scale
/// as well as all of them.
/// @param enough  size of the sample, or up to twice as many
template <class Visit>
void for_each_spread_arrival(const std::vector<Trajectory>& trajectories, std::size_t enough, Visit&& visit) {
  std::size_t arrivals = 0;
  for (const Trajectory& t : trajectories) arrivals += t.arrivals.size();
  const std::size_t stride = arrivals / enough + 1;
  for (const Trajectory& t : trajectories)
    for (std::size_t i = 0; i < t.arrivals.size(); i += stride) visit(t, t.arrivals[i]);
}

/// Even sample of observations, at most the given number.
template <class Observation>
std::vector<Observation> some_of(std::vector<Observation> all, std::size_t enough) {
  if (all.size() <= enough) return all;
  std::vector<Observation> spread;
  for (std::size_t i = 0; i < enough; ++i) spread.push_back(all[i * all.size() / enough]);
  return spread;
}

/// Ranges of a beacon from the vehicle states placed so far, rejected arrivals included.
[[nodiscard]] std::vector<RangeFrom> ranges_to(const std::vector<Trajectory>& trajectories,
                                               const SharedState& state, BeaconId beacon);

/// Rays to a beacon from its bearings, at placed planar states whose heading has another source: a measured
/// pose, odometry, a bearing of another known beacon, or two receivers. Rejected bearings are included.
/// @param known  beacons with known positions, which determine headings
[[nodiscard]] std::vector<RayFrom> rays_to(const std::vector<Trajectory>& trajectories, BeaconId beacon,
                                           const std::vector<bool>& known);

/// Median of the prior ranges of all arrivals, at least a millimetre; 1 m without arrivals.
[[nodiscard]] double typical_range_m(const Site& site, const std::vector<Trajectory>& trajectories);

/// Cauchy's scale at which the loss costs 5 % of efficiency on clean data.
inline constexpr double kCauchyScale = 2.385;

/// Median; 0 for no values.
[[nodiscard]] double median(std::vector<double> values);
/// The value that `n` others are not above. @param n  below the number of values
[[nodiscard]] double nth_smallest(std::vector<double> values, std::size_t n);
/// @param values  one at least  @param share  0: the smallest, 1: the largest
[[nodiscard]] double quantile(std::vector<double> values, double share);

/// A place of the vehicle, within which errors are one and the same (reflections, cameras, bodies in the
/// way): arrivals that were recorded there are one piece of evidence, however many they are.
using Place = std::array<double, 3>;

/// Place of the vehicle: a cell of 5 % of the typical range.
/// @param p_map_m  position of the vehicle
/// @param typical_range_m  see Problem::typical_range_m
[[nodiscard]] inline Place place_at(const Eigen::Vector3d& p_map_m, double typical_range_m) {
  constexpr double kShareOfRange = 0.05;
  const Eigen::Vector3d cell = (p_map_m / (kShareOfRange * typical_range_m)).array().floor();
  return {cell.x(), cell.y(), cell.z()};
}

}  // namespace octant::calib
