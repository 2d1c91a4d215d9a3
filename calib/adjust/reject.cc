// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/reject.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "calib/problem/gates.h"
#include "models/support/parallel.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// Variance of a standard normal variable given that it lies within +-2.5: 1 - 2 * 2.5 phi(2.5) / (2 Phi(2.5)
/// - 1).
constexpr double kTruncation = 2.5;
constexpr double kTruncatedVariance = 0.91125;
constexpr double kReadmit = 0.9;

/// Returns true if half of the arrivals at stops, or more, determine their poses. Their residuals then
/// contain little information on the noise, and none where two arrivals determine a position.
bool are_stops_saturated(const std::vector<Trajectory>& trajectories) {
  std::size_t arrivals = 0, unknowns = 0;
  for (const Trajectory& t : trajectories) {
    if (t.moving) return false;  // odometry and motion tell the states too
    for (const ArrivalObservation& a : t.arrivals)
      arrivals += is_by_residual(a.rejection) && t.nodes[a.node].placed;
    const auto placed = static_cast<std::size_t>(std::ranges::count_if(t.nodes, &Node::placed));
    unknowns += placed * static_cast<std::size_t>(t.block_size());
  }
  return arrivals < 2 * unknowns;
}

}  // namespace

double agreeing_sigma(const std::vector<Trajectory>& trajectories, const SharedState& state) {
  constexpr std::size_t kEnough = 200000;
  std::vector<double> magnitude;
  for_each_spread_arrival(trajectories, kEnough, [&](const Trajectory& t, const ArrivalObservation& a) {
    if (is_by_residual(a.rejection) && t.nodes[a.node].placed)
      magnitude.push_back(std::abs(arrival_residual(t, a, state)));
  });
  const double sigma = agreeing_sigma(std::move(magnitude));
  return sigma < 1.0 && are_stops_saturated(trajectories) ? 1.0 : sigma;
}

double agreeing_sigma(std::vector<double> magnitude) {
  if (magnitude.size() < 30) return 1.0;
  std::ranges::sort(magnitude);
  double sigma = 1.4826 * magnitude[magnitude.size() / 2];
  for (int round = 0; round < 50; ++round) {
    double sum = 0.0;
    std::size_t count = 0;
    for (; count < magnitude.size() && magnitude[count] < kTruncation * sigma; ++count)
      sum += magnitude[count] * magnitude[count];
    if (count == 0) return 1.0;
    const double next = std::sqrt(sum / static_cast<double>(count) / kTruncatedVariance);
    const bool still = std::abs(next - sigma) < 1e-3 * sigma;
    sigma = next;
    if (still) break;
  }
  return sigma;
}

std::size_t reject_outliers(std::vector<Trajectory>& trajectories, const SharedState& state, double limit,
                            int threads) {
  std::atomic<std::size_t> changes{0};
  const auto decide = [&](double residual, Rejection now, std::size_t& changed) {
    const bool out = std::abs(residual) > (now == Rejection::kUsed ? limit : kReadmit * limit);
    const Rejection next = !out            ? Rejection::kUsed
                           : is_gated(now) ? now
                           : residual > 0  ? Rejection::kLate
                                           : Rejection::kEarly;
    changed += (next == Rejection::kUsed) != (now == Rejection::kUsed);
    return next;
  };
  for (Trajectory& t : trajectories) {
    for_each_chunk(t.arrivals.size(), kArrivalsAtOnce, threads,
                   [&](std::size_t, std::size_t first, std::size_t last) {
                     std::size_t changed = 0;
                     ArrivalResiduals residual_of(t, state);
                     for (std::size_t i = first; i < last; ++i) {
                       ArrivalObservation& a = t.arrivals[i];
                       if (is_by_residual(a.rejection) || is_gated(a.rejection))
                         a.rejection = decide(residual_of(a), a.rejection, changed);
                     }
                     changes += changed;
                   });
    std::size_t changed = 0;
    for (std::size_t i = 0; i < t.bearings.size(); ++i) {
      BearingObservation& b = t.bearings[i];
      ObservationRow row;
      if (b.rejection == Rejection::kNoPose || b.rejection == Rejection::kBeaconUnusable ||
          bearing_rows(t, i, state, &row) == 0)
        continue;
      b.rejection = decide(row.residual, b.rejection, changed);
    }
    changes += changed;
  }
  return changes;
}

void rescale_noise(std::vector<Trajectory>& trajectories, double before_s, double now_s) {
  for (Trajectory& t : trajectories)
    for (ArrivalObservation& a : t.arrivals)
      a.sigma_s = std::hypot(now_s, std::sqrt(std::max(0.0, a.sigma_s * a.sigma_s - before_s * before_s)));
}

void rescale_poses(std::vector<Trajectory>& trajectories, double factor) {
  if (factor == 1.0) return;
  for (Trajectory& t : trajectories)
    for (PoseObservation& p : t.poses) {
      p.position_sigma_m *= factor;
      p.heading_sigma_rad *= factor;
      p.attitude_sigma_rad *= factor;
    }
}

void readmit_all(std::vector<Trajectory>& trajectories, const std::vector<bool>& beacon_usable) {
  for (Trajectory& t : trajectories) {
    for (ArrivalObservation& a : t.arrivals)
      a.rejection = !beacon_usable[a.beacon.index()] ? Rejection::kBeaconUnusable
                    : !t.nodes[a.node].placed        ? Rejection::kNoPose
                    : is_gated(a.rejection)          ? a.rejection
                                                     : Rejection::kUsed;
    for (BearingObservation& b : t.bearings)
      b.rejection = !b.reflector.valid() || !beacon_usable[b.reflector.index()] ? Rejection::kBeaconUnusable
                    : !t.nodes[b.node].placed                                   ? Rejection::kNoPose
                                                                                : Rejection::kUsed;
  }
}

}  // namespace octant::calib
