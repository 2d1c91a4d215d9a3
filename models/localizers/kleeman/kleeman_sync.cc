// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_sync.h"

#include <algorithm>
#include <cmath>

namespace octant {
namespace {

constexpr double kArrayFlight_s = 1e-3;  // time across a receiver array, plus that of the detector

}  // namespace

void PulseSync::remember(const PulseArrival& pulse) noexcept {
  const auto c = static_cast<std::size_t>(pulse.channel);
  past_[c][static_cast<std::size_t>(remembered_[c] % kRemembered)] = pulse;
  ++remembered_[c];
}

/// Returns true if a pulse is the second of a double pulse: same channel, matching lengths, separation and
/// amplitude.
bool PulseSync::completes_double(const PulseArrival& second, double& first_s) const noexcept {
  const FiringSchedule& s = options_.schedule;
  const auto right_length = [&](const PulseArrival& p) {
    return std::abs(p.duration_s - s.pulse_s) <= options_.pulse_tolerance * s.pulse_s;
  };
  if (!right_length(second)) return false;
  for (const PulseArrival& first : past(static_cast<std::size_t>(second.channel))) {
    if (!right_length(first) ||
        std::abs(second.time_s - first.time_s - s.double_s) > options_.double_tolerance_s)
      continue;
    const auto [weaker, stronger] = std::minmax(first.amplitude_v, second.amplitude_v);
    if (weaker < options_.amplitude_ratio * stronger) continue;
    first_s = first.time_s;
    return true;
  }
  return false;
}

/// Counts a channel that received a double pulse, as part of the same signature or as the first of a new one.
void PulseSync::count(double first_s, Signature& signature) noexcept {
  if (std::abs(first_s - signature.time_s) <= kArrayFlight_s) {
    signature.time_s = std::min(signature.time_s, first_s);
    ++signature.channels;
  } else {
    signature = {first_s, 1, 0};
  }
}

/// Returns true if a double pulse is beacon 0's own. It must be received on most of the channels that
/// received its first pulse (an echo arrives from another side), without a stronger pulse before it (two
/// echoes of one pulse may be t_double apart, but they follow that pulse).
bool PulseSync::credible(const Signature& signature) const noexcept {
  const double since_s = signature.time_s - (options_.schedule.fire_s -
                                             options_.max_flight_s);  // no direct pulse of other beacons
  int heard = 0;
  double before_v = 0.0, amplitude_v = 0.0;
  for (std::size_t c = 0; c < kChannels; ++c) {
    bool here = false;
    for (const PulseArrival& p : past(c)) {
      if (std::abs(p.time_s - signature.time_s) <= kArrayFlight_s) {
        here = true;
        amplitude_v = std::max(amplitude_v, p.amplitude_v);
      } else if (p.time_s > since_s && p.time_s < signature.time_s) {
        before_v = std::max(before_v, p.amplitude_v);
      }
    }
    heard += here ? 1 : 0;
  }
  return 2 * signature.channels > heard && amplitude_v > before_v;
}

/// Advances by cycles until `time_s` lies in the current one, or synchronisation is lost. A slot begins
/// max_flight_s before its firing time, because that is defined by the arrival from beacon 0, and another
/// beacon may be closer.
void PulseSync::advance(double time_s) noexcept {
  while (synchronised_ && time_s >= start_s_ + cycle_s(options_.schedule) - options_.max_flight_s) {
    missed_ = double_heard_ ? 0 : missed_ + 1;
    synchronised_ = missed_ <= options_.max_missed_cycles;
    start_s_ += cycle_s(options_.schedule) + next_shift_s_;
    next_shift_s_ = 0.0;
    double_heard_ = false;
    ++epoch_;
    heard_slot_.fill(0);
  }
}

void PulseSync::synchronise(double first_s) noexcept {
  // Epochs continue to count cycles approximately and are never repeated.
  const auto cycles =
      static_cast<std::int64_t>(std::llround((first_s - start_s_) / cycle_s(options_.schedule)));
  epoch_ = epoch_ < 0 ? 0 : epoch_ + std::max<std::int64_t>(cycles, 1);
  synchronised_ = true;
  confirmed_ = false;
  start_s_ = first_s;
  next_shift_s_ = 0.0;
  missed_ = 0;
  double_heard_ = true;
  foreign_ = Signature{};
  heard_slot_.fill(0);
  for (std::size_t c = 0; c < kChannels; ++c) {  // the arrivals of beacon 0 are past, one on each channel
    const PulseArrival* earliest = nullptr;
    for (const PulseArrival& p : past(c)) {
      if (std::abs(p.time_s - first_s) <= kArrayFlight_s &&
          (earliest == nullptr || p.time_s < earliest->time_s))
        earliest = &p;
    }
    if (earliest != nullptr) emit(*earliest, 0);
  }
}

/// Handles a double pulse while synchronised: either beacon 0 as expected, or evidence for a wrong
/// synchronisation.
void PulseSync::consider(double first_s) noexcept {
  const double cycle = cycle_s(options_.schedule), since_s = first_s - start_s_;
  if (std::abs(since_s) <= options_.max_flight_s) {
    if (std::abs(first_s - own_.time_s) <= kArrayFlight_s) {
      ++own_.channels;
    } else if (!double_heard_) {  // the first of this cycle; its echoes are double pulses too
      confirmed_ = confirmed_ || std::abs(first_s - own_.time_s - cycle) <= options_.max_flight_s;
      own_ = {first_s, 1, 0};
    }
    if (!double_heard_) next_shift_s_ = std::clamp(since_s, -options_.max_shift_s, options_.max_shift_s);
    double_heard_ = true;
    return;
  }
  const Signature before = foreign_;
  count(first_s, foreign_);
  if (foreign_.channels == 1 && std::abs(first_s - before.time_s - cycle) <= options_.max_flight_s)
    foreign_.repeats = before.repeats + 1;
  if (!credible(foreign_)) return;
  const bool doubtful = !confirmed_ && (missed_ > 0 || foreign_.channels > own_.channels);
  const bool superseded = missed_ >= 2 && foreign_.repeats >= 1;
  if (!doubtful && !superseded) return;
  own_ = foreign_;
  synchronise(own_.time_s);
}

void PulseSync::emit(const PulseArrival& pulse, int beacon) noexcept {
  Arrival a;
  a.time_s = pulse.time_s;
  a.beacon = BeaconId(beacon);
  a.tof_s = pulse.time_s - (start_s_ + firing_s(options_.schedule, a.beacon, 0));
  a.receiver = ReceiverId(options_.first_receiver.value + pulse.channel);
  a.vehicle = options_.vehicle;
  a.epoch = epoch_;
  a.amplitude_v = pulse.amplitude_v;
  out_[out_count_++] = a;
  heard_slot_[static_cast<std::size_t>(pulse.channel)] = beacon + 1;
}

std::span<const Arrival> PulseSync::push(const PulseArrival& pulse) noexcept {
  out_count_ = 0;
  const FiringSchedule& s = options_.schedule;
  if (pulse.channel < 0 || pulse.channel >= kChannels || !std::isfinite(pulse.time_s)) return {};
  if (!(pulse.duration_s >= options_.min_pulse * s.pulse_s)) return {};
  advance(pulse.time_s);
  double first_s = 0.0;
  const bool is_double = completes_double(pulse, first_s);
  remember(pulse);
  if (!synchronised_) {
    if (is_double) {
      count(first_s, own_);
      if (credible(own_)) synchronise(own_.time_s);
    }
    return {out_.data(), out_count_};
  }
  if (is_double) {
    consider(first_s);
    if (out_count_ > 0) return {out_.data(), out_count_};  // synchronised again
  }
  const double into_s = pulse.time_s - start_s_ + options_.max_flight_s;
  if (into_s < 0) return {};  // belongs to a past cycle
  const int beacon = static_cast<int>(into_s / s.fire_s);
  if (beacon >= s.beacons || heard_slot_[static_cast<std::size_t>(pulse.channel)] >= beacon + 1) return {};
  emit(pulse, beacon);
  return {out_.data(), out_count_};
}

}  // namespace octant
