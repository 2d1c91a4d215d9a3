// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/correlated_arrivals.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace octant {

CorrelatedNoise correlated_noise(const Deployment& deployment) {
  CorrelatedNoise noise = deployment.correlated_noise;
  noise.pair_sigma_s = std::max(noise.pair_sigma_s, deployment.noise.pair_sigma_s.value_or(0.0));
  return noise;
}

double single_arrival_sigma_s(const Deployment& deployment) {
  const CorrelatedNoise noise = correlated_noise(deployment);
  return std::hypot(deployment.noise.tof_sigma_s, noise.sigma_s, noise.pair_sigma_s);
}

CorrelatedArrivals::CorrelatedArrivals(Trajectory& t, const Segment& segment, const CorrelatedNoise& noise,
                                       Side side)
    : trajectory_(t), segment_(segment), noise_(noise), side_(side) {
  if (!noise.any()) return;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    single_s_.push_back(t.arrivals[i].sigma_s);
    tail_s_.push_back(0.0);
    by_pair_.push_back(i);
  }
  const auto key = [&t](std::size_t i) {
    const ArrivalObservation& a = t.arrivals[i];
    return std::make_tuple(a.beacon.index(), a.receiver.index(), a.time_s, i);
  };
  std::ranges::sort(by_pair_, [&key](std::size_t a, std::size_t b) { return key(a) < key(b); });
}

bool CorrelatedArrivals::widen_tails(const SharedState& state) {
  bool changed = false;
  for (std::size_t i = 0; i < single_s_.size(); ++i) {
    const ArrivalObservation& a = trajectory_.arrivals[segment_.first_arrival + i];
    if (a.rejection != Rejection::kUsed) continue;
    const double before_s = std::max(single_s_[i], tail_s_[i]);
    tail_s_[i] = single_s_[i] * std::abs(arrival_residual(trajectory_, a, state)) / kTailSigmas;
    const double now_s = std::max(single_s_[i], tail_s_[i]);
    changed = changed || std::abs(now_s - before_s) > kTailChanged * before_s;
  }
  return changed;
}

void CorrelatedArrivals::narrow_tails() { std::ranges::fill(tail_s_, 0.0); }

void CorrelatedArrivals::weigh() {
  restore();
  std::vector<ArrivalObservation>& arrivals = trajectory_.arrivals;
  for (std::size_t i = 0; i < tail_s_.size(); ++i) {
    double& sigma_s = arrivals[segment_.first_arrival + i].sigma_s;
    sigma_s = std::max(sigma_s, tail_s_[i]);
  }
  const auto same_pair = [&arrivals](std::size_t a, std::size_t b) {
    return arrivals[a].beacon == arrivals[b].beacon && arrivals[a].receiver == arrivals[b].receiver;
  };
  std::pmr::vector<double> shared(scratch());
  for (std::size_t first = 0, last = 0; first < by_pair_.size(); first = last) {
    while (last < by_pair_.size() && same_pair(by_pair_[first], by_pair_[last])) ++last;
    // Sum of exp(-|dt| / time_s) over the other arrivals, by one recursion forwards and one backwards.
    shared.assign(last - first, 0.0);
    double used = 0.0;
    const auto sweep = [&](auto begin, auto end) {
      double sum = 0.0, before_s = 0.0;
      for (auto i = begin; i != end; ++i) {
        const ArrivalObservation& a = arrivals[*i];
        if (a.rejection != Rejection::kUsed) continue;
        sum *= noise_.time_s > 0      ? std::exp(-std::abs(a.time_s - before_s) / noise_.time_s)
               : a.time_s == before_s ? 1.0
                                      : 0.0;
        shared[static_cast<std::size_t>(&*i - &by_pair_[first])] += sum;
        sum += 1.0;
        used += 0.5;
        before_s = a.time_s;
      }
    };
    const auto begin = by_pair_.begin() + static_cast<std::ptrdiff_t>(first),
               end = by_pair_.begin() + static_cast<std::ptrdiff_t>(last);
    sweep(begin, end);
    sweep(std::make_reverse_iterator(end), std::make_reverse_iterator(begin));
    // At one place the mean of a pair's arrivals counts and all have the same geometry, so they share one
    // weight.
    double mean = 0.0;
    for (const double s : shared) mean += s / std::max(used, 1.0);
    for (std::size_t i = first; i < last; ++i) {
      ArrivalObservation& a = arrivals[by_pair_[i]];
      if (a.rejection != Rejection::kUsed) continue;
      const double correlated =
          noise_.sigma_s * noise_.sigma_s * (side_ == Side::kSame ? mean : shared[i - first]);
      const double lasting =
          side_ == Side::kSame ? noise_.pair_sigma_s * noise_.pair_sigma_s * (used - 1.0) : 0.0;
      a.sigma_s = std::sqrt(a.sigma_s * a.sigma_s + correlated + lasting);
    }
  }
}

void CorrelatedArrivals::restore() {
  for (std::size_t i = 0; i < single_s_.size(); ++i)
    trajectory_.arrivals[segment_.first_arrival + i].sigma_s = single_s_[i];
}

}  // namespace octant
