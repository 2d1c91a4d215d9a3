// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/whiteness.h"

#include <cmath>
#include <vector>

#include "calib/statistics.h"
#include "models/parallel.h"

namespace octant::calib {
namespace {

constexpr std::size_t kEnough = 8;          ///< arrivals of a pair
constexpr double kSignificance = 1e-6;
constexpr double kPairMatters = 2.0;        ///< twice the variance of white noise
constexpr double kCorrelationMatters = 0.2;

struct Series {
  double sum = 0.0, squares = 0.0, products = 0.0, last = 0.0;
  std::size_t count = 0, neighbours = 0;
  void add(double r, bool next_to_last) {
    if (next_to_last) {
      products += r * last;
      ++neighbours;
    }
    sum += r;
    squares += r * r;
    last = r;
    ++count;
  }
};

}  // namespace

Whiteness whiteness_of(const std::vector<Trajectory>& trajectories, const SharedState& state, int threads) {
  Whiteness w;
  double pair_sum = 0.0, squares = 0.0, products = 0.0;
  std::size_t count = 0;
  for (const Trajectory& t : trajectories) {
    const std::size_t receivers = state.receiver_p_vehicle_m.size();
    std::vector<Series> series(state.beacon_p_map_m.size() * receivers);
    const auto counts = [&t](const ArrivalObservation& a) { return a.rejection == Rejection::kUsed && t.nodes[a.node].placed; };
    std::vector<double> residual(t.arrivals.size());
    for_each_chunk(t.arrivals.size(), kArrivalsAtOnce, threads, [&](std::size_t, std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i)
        if (counts(t.arrivals[i])) residual[i] = arrival_residual(t, t.arrivals[i], state);
    });
    for (std::size_t i = 0; i < residual.size(); ++i) {
      const ArrivalObservation& a = t.arrivals[i];
      if (!counts(a)) continue;
      Series& s = series[a.beacon.index() * receivers + a.receiver.index()];
      s.add(residual[i], s.count > 0);
    }
    for (const Series& s : series) {
      squares += s.squares;
      products += s.products;
      count += s.count;
      w.neighbours += s.neighbours;
      if (s.count < kEnough) continue;
      const auto n = static_cast<double>(s.count);
      ++w.pairs;
      pair_sum += s.sum * s.sum / n;
    }
  }
  if (count == 0 || !(squares > 0)) return w;
  const double variance = squares / static_cast<double>(count);
  if (w.pairs > 0) w.pair_ratio = pair_sum / variance / static_cast<double>(w.pairs);
  if (w.neighbours > 0) w.autocorrelation = products / variance / static_cast<double>(w.neighbours);
  const bool by_pair = w.pair_ratio > kPairMatters && chi_square_p(w.pair_ratio * static_cast<double>(w.pairs), static_cast<double>(w.pairs)) < kSignificance;
  // The sample autocorrelation of white noise has the variance 1 / n.
  const bool in_time = w.autocorrelation > kCorrelationMatters && w.autocorrelation * std::sqrt(static_cast<double>(w.neighbours)) > 5.0;
  if (in_time) {
    const double rho = std::min(w.autocorrelation, 0.99);
    w.sigma_factor = std::sqrt((1 + rho) / (1 - rho));
  }
  w.white = !by_pair && !in_time;
  return w;
}

}  // namespace octant::calib
