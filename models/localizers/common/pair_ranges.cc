// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/pair_ranges.h"

#include <algorithm>
#include <cmath>

#include "models/localizers/common/arrival_range.h"
#include "models/localizers/common/counter_times.h"
#include "models/localizers/common/localizer.h"

namespace octant {

PairRanges::PairRanges(const Deployment& deployment, PairRangesOptions options)
    : options_(options),
      receivers_(deployment.receivers.size()),
      slots_(deployment.beacons.size() * receivers_) {
  const std::size_t room = slots_.size() * kRoom;
  gated_.reserve(room);
  single_.reserve(room);
  next_.reserve(room);
  values_.reserve(room);
  pairs_.reserve(slots_.size());
}

void PairRanges::reduce(std::span<const Arrival> arrivals, const Deployment& deployment,
                        std::vector<Rejection>& rejections) {
  double speed_mps = 0.0;
  gated_.clear();
  single_.clear();
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    const Arrival& arrival = arrivals[i];
    gated_.push_back(
        {arrival.beacon, arrival.receiver, arrival.time_s, std::numeric_limits<double>::quiet_NaN()});
    single_.push_back({.beacon = arrival.beacon, .receiver = arrival.receiver});
    if (!arrival.beacon.valid() || arrival.beacon.index() >= deployment.beacons.size() ||
        deployment.beacons[arrival.beacon.index()].status == BeaconStatus::kUndetermined) {
      rejections[i] = Rejection::kBeaconUnusable;
      continue;
    }
    if (!arrival.receiver.valid() || arrival.receiver.index() >= receivers_ ||
        arrival.vehicle != arrivals.front().vehicle) {
      rejections[i] = Rejection::kNoPose;
      continue;
    }
    const ArrivalRange range = arrival_range(arrival, deployment);
    gated_.back().range_m = range.range_m;
    single_.back().range_m = range.range_m;
    single_.back().sigma_m = range.sigma_m;
    single_.back().gain_mps = range.gain_mps;
    single_.back().by_speed_s = range.by_speed_s();
    speed_mps = range.speed_mps;
  }
  apply_range_gates(gated_, options_.gates, speed_mps, rejections);
}

void PairRanges::average(std::span<const Arrival> arrivals, std::vector<Rejection>& rejections,
                         double pair_sigma_s, std::size_t slot) {
  values_.clear();
  double spread_m = 0.0;
  for (int i = slots_[slot].first; i >= 0; i = next_[static_cast<std::size_t>(i)]) {
    values_.push_back(single_[static_cast<std::size_t>(i)].range_m);
    spread_m = std::max(spread_m, options_.spread_sigmas * single_[static_cast<std::size_t>(i)].sigma_m);
  }
  const AgreeingMean mean = mean_of_agreeing(values_, spread_m);
  PairRange pair{.beacon = arrivals[static_cast<std::size_t>(slots_[slot].first)].beacon,
                 .receiver = arrivals[static_cast<std::size_t>(slots_[slot].first)].receiver,
                 .range_m = mean.mean};
  double variance_m2 = 0.0;
  for (int i = slots_[slot].first; i >= 0; i = next_[static_cast<std::size_t>(i)]) {
    const PairRange& one = single_[static_cast<std::size_t>(i)];
    if (one.range_m < mean.low || one.range_m > mean.high) {
      rejections[static_cast<std::size_t>(i)] = Rejection::kOutvoted;
      continue;
    }
    ++pair.arrivals;
    variance_m2 += one.sigma_m * one.sigma_m;
    pair.gain_mps += one.gain_mps;
    pair.by_speed_s += one.by_speed_s;
  }
  pair.gain_mps /= pair.arrivals;
  pair.by_speed_s /= pair.arrivals;
  pair.sigma_m = std::hypot(std::sqrt(variance_m2) / pair.arrivals, pair.gain_mps * pair_sigma_s);
  pairs_.push_back(pair);
}

std::span<PairRange> PairRanges::collect(std::span<const Arrival> arrivals, const Deployment& deployment,
                                         std::vector<Rejection>& rejections) noexcept {
  rejections.assign(arrivals.size(), Rejection::kUsed);
  pairs_.clear();
  reduce(arrivals, deployment, rejections);
  next_.assign(arrivals.size(), -1);
  std::ranges::fill(slots_, Slot{});
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    if (rejections[i] != Rejection::kUsed) continue;
    Slot& slot = slots_[arrivals[i].beacon.index() * receivers_ + arrivals[i].receiver.index()];
    const int at = static_cast<int>(i);
    if (slot.last >= 0) {
      next_[static_cast<std::size_t>(slot.last)] = at;
    } else {
      slot.first = at;
    }
    slot.last = at;
  }
  for (std::size_t slot = 0; slot < slots_.size(); ++slot)
    if (slots_[slot].first >= 0)
      average(arrivals, rejections, deployment.noise.pair_sigma_s.value_or(0.0), slot);
  return pairs_;
}

void reject_pair(std::span<const Arrival> arrivals, const PairRange& pair, Rejection reason,
                 std::span<Rejection> rejections) {
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    if (rejections[i] == Rejection::kUsed && arrivals[i].beacon == pair.beacon &&
        arrivals[i].receiver == pair.receiver)
      rejections[i] = reason;
  }
}

void end_fix(FixStatus status, Fix& fix) {
  fix.status = status;
  if (!fix.ok()) {
    fix.rejections.clear();
    return;
  }
  count_rejections(fix);
}

}  // namespace octant
