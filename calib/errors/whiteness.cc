// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/whiteness.h"

#include <cmath>
#include <vector>

#include "calib/errors/statistics.h"
#include "models/support/parallel.h"

namespace octant::calib {
namespace {

constexpr std::size_t kEnoughOfPair = 8;  ///< arrivals of a pair
constexpr double kSignificance = 1e-6;
constexpr double kPairMatters = 2.0;  ///< twice the variance of white noise
constexpr double kCorrelationMatters = 0.2;

/// Sums over the residuals of one pair of a trajectory, in order of time.
struct PairSeries {
  double sum = 0.0, squares = 0.0, products = 0.0;  ///< products: sum over neighbours
  double last = 0.0;
  std::size_t count = 0;
  void add(double residual) {
    if (count++ > 0) products += last * residual;
    sum += residual;
    squares += residual * residual;
    last = residual;
  }
};

/// Series of the arrivals in use of each pair, beacon-major.
std::vector<PairSeries> pair_series(const Trajectory& t, const SharedState& state, int threads) {
  const std::size_t receivers = state.receiver_p_vehicle_m.size();
  std::vector<PairSeries> series(state.beacon_p_map_m.size() * receivers);
  const auto counts = [&t](const ArrivalObservation& a) {
    return a.rejection == Rejection::kUsed && t.nodes[a.node].placed;
  };
  std::vector<double> residual(t.arrivals.size());
  for_each_in_chunks(t.arrivals.size(), kArrivalsAtOnce, threads, [&](std::size_t i) {
    if (counts(t.arrivals[i])) residual[i] = arrival_residual(t, t.arrivals[i], state);
  });
  for (std::size_t i = 0; i < residual.size(); ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (counts(a)) series[a.beacon.index() * receivers + a.receiver.index()].add(residual[i]);
  }
  return series;
}

}  // namespace

Whiteness whiteness_of(const std::vector<Trajectory>& trajectories, const SharedState& state, int threads) {
  Whiteness w;
  double pair_sum = 0.0, squares = 0.0, products = 0.0;
  std::size_t count = 0;
  for (const Trajectory& t : trajectories)
    for (const PairSeries& s : pair_series(t, state, threads)) {
      if (s.count == 0) continue;
      squares += s.squares;
      products += s.products;
      count += s.count;
      w.neighbours += s.count - 1;
      if (s.count < kEnoughOfPair) continue;
      ++w.pairs;
      pair_sum += s.sum * s.sum / static_cast<double>(s.count);
    }
  if (count == 0 || !(squares > 0)) return w;
  const double variance = squares / static_cast<double>(count);
  if (w.pairs > 0) w.pair_ratio = pair_sum / variance / static_cast<double>(w.pairs);
  if (w.neighbours > 0) w.autocorrelation = products / variance / static_cast<double>(w.neighbours);
  const bool by_pair =
      w.pair_ratio > kPairMatters &&
      chi_square_p(w.pair_ratio * static_cast<double>(w.pairs), static_cast<double>(w.pairs)) < kSignificance;
  // The sample autocorrelation of white noise has the variance 1 / n.
  const bool in_time = w.autocorrelation > kCorrelationMatters &&
                       w.autocorrelation * std::sqrt(static_cast<double>(w.neighbours)) > 5.0;
  if (in_time) {
    const double rho = std::min(w.autocorrelation, 0.99);
    w.sigma_factor = std::sqrt((1 + rho) / (1 - rho));
  }
  w.white = !by_pair && !in_time;
  return w;
}

}  // namespace octant::calib
