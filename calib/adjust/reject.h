// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/problem/ranges.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Standard deviation of the arrivals' whitened residuals by those that agree: the truncated variance of what
/// lies within 2.5 of it, iterated from the median. Echoes, however many, lie outside and do not widen it. 1
/// where there are too few.
[[nodiscard]] double agreeing_sigma(const std::vector<Trajectory>& trajectories, const SharedState& state);

/// The estimate from magnitudes of whitened residuals.
[[nodiscard]] double agreeing_sigma(std::vector<double> magnitudes);

/// Marks arrivals and bearings beyond `limit` sigmas as rejected, late or early, and readmits those within
/// 0.9 of it. Returns how many rejections changed.
std::size_t reject_outliers(std::vector<Trajectory>& trajectories, const SharedState& state, double limit,
                            int threads = 1);

/// Changes the noise of arrivals. The part due to measured amplitudes (walk) is not noise of the times and
/// remains.
/// @param before_s, now_s  noise of the times of flight
void rescale_noise(std::vector<Trajectory>& trajectories, double before_s, double now_s);
/// Scales the sigmas of measured poses by a factor.
void rescale_poses(std::vector<Trajectory>& trajectories, double factor);

/// All arrivals and bearings in use again, but those of unusable beacons and of states without a place.
void readmit_all(std::vector<Trajectory>& trajectories, const std::vector<bool>& beacon_usable);

/// Returns true if the residuals of arrivals that agree (reject.h) show another noise than assumed. Before
/// the rejection, only a gross deviation counts; NoiseSearch (statistics.h) determines the rest.
[[nodiscard]] inline bool is_far_off(double agreeing_sigma) {
  return agreeing_sigma < 0.5 || agreeing_sigma > 1.5;
}

/// Rounds of rejection.
inline constexpr int kRejectionRounds = 12;

}  // namespace octant::calib
