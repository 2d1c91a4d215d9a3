// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "models/localizers/kleeman/kleeman_schedule.h"
#include "models/run.h"

namespace octant {

/// A pulse as logged by the threshold detector of a channel, from an unknown beacon.
struct PulseArrival {
  double time_s = 0.0;      ///< onset, on the receiver's clock
  int channel = 0;          ///< channel of the receiver array, from 0
  double duration_s = 0.0;  ///< time above threshold
  double amplitude_v = 0.0;
};

struct PulseSyncOptions {
  FiringSchedule schedule{};
  VehicleId vehicle{0};
  ReceiverId first_receiver{0};        ///< receiver of channel 0; the others follow
  double double_tolerance_s = 0.2e-3;  ///< tolerance of the time between beacon 0's two pulses
  double pulse_tolerance = 0.4;        ///< tolerance of the length of each, relative to t_pulse
  /// Smallest ratio of the weaker to the stronger pulse. An echo that arrives t_double after a single pulse
  /// has travelled 1.9 m farther and was partly absorbed: within 10 m of the beacon it has at most 0.81 of
  /// the amplitude.
  double amplitude_ratio = 0.85;
  double min_pulse = 0.5;  ///< pulses shorter than this share of t_pulse are noise
  double max_flight_s =
      0.045;  ///< time of flight from the farthest beacon; t_fire must be more than twice as long
  /// Largest change of the firing times that beacon 0's double pulse may cause in a cycle: 1 m/s during a
  /// cycle, plus clock drift. A larger change is an echo, or beacon 0 after an interruption, which is
  /// accepted after a few cycles.
  double max_shift_s = 4e-3;
  int max_missed_cycles = 20;  ///< cycles without beacon 0's double pulse after which synchronisation is lost
};

/// Identifies the beacons in a stream of pulses by beacon 0's double pulse (L. Kleeman, sections 1.2
/// and 5.1).
///
/// The first double pulse that is not an echo defines the firing time of beacon 0 on the receiver's clock
/// (its arrival, because its time of flight is unknown: a cycle offset). Synchronisation therefore takes at
/// most one cycle plus the time of flight. From then on the first pulse on each channel in each beacon's slot
/// is the arrival of that beacon; later pulses are echoes and are ignored. Each received double pulse updates
/// the firing times of the next cycle, which allows for clock drift and motion. If beacon 0 is blocked, the
/// schedule continues unchanged. A double pulse that recurs in another beacon's slot, while there is none in
/// beacon 0's, replaces the synchronisation. Echoes in a slot must have decayed before the next one: eq. 1.
/// Does not allocate.
class PulseSync {
 public:
  static constexpr int kChannels = 16;

  explicit PulseSync(const PulseSyncOptions& options = {}) : options_(options) {}

  /// Processes the next pulse, in order of time (onsets may be out of order by t_pulse).
  /// @return arrivals identified by this pulse: none, one, or at the moment of synchronisation those of
  /// beacon 0 on all channels. tof_s is the time of arrival minus the nominal firing time of the beacon;
  /// epoch counts cycles. Valid until the next call.
  std::span<const Arrival> push(const PulseArrival& pulse) noexcept;

  [[nodiscard]] bool synchronised() const { return synchronised_; }
  /// Nominal firing time of beacon 0 in the current cycle, on the receiver's clock [s].
  [[nodiscard]] double cycle_start_s() const { return start_s_; }
  [[nodiscard]] std::int64_t epoch() const { return epoch_; }
  void reset() noexcept { *this = PulseSync(options_); }

 private:
  /// A double pulse and the number of channels that received it.
  struct Signature {
    double time_s = -1e300;
    int channels = 0;
    int repeats = 0;  ///< number of consecutive cycles
  };
  static constexpr int kRemembered = 8;

  /// Last pulses of a channel, unordered.
  [[nodiscard]] std::span<const PulseArrival> past(std::size_t channel) const noexcept {
    return std::span(past_[channel])
        .first(static_cast<std::size_t>(std::min(remembered_[channel], kRemembered)));
  }
  [[nodiscard]] bool completes_double(const PulseArrival& pulse, double& first_s) const noexcept;
  [[nodiscard]] bool credible(const Signature& signature) const noexcept;
  static void count(double first_s, Signature& signature) noexcept;
  void remember(const PulseArrival& pulse) noexcept;
  void advance(double time_s) noexcept;
  void consider(double first_s) noexcept;
  void synchronise(double first_s) noexcept;
  void emit(const PulseArrival& pulse, int beacon) noexcept;

  PulseSyncOptions options_;
  std::array<std::array<PulseArrival, kRemembered>, kChannels> past_{};
  std::array<int, kChannels> remembered_{};
  std::array<int, kChannels>
      heard_slot_{};  ///< last slot of the cycle in which a channel had its arrival, plus one
  std::array<Arrival, kChannels> out_;
  std::size_t out_count_ = 0;
  bool synchronised_ = false, confirmed_ = false;
  double start_s_ = 0.0, next_shift_s_ = 0.0;
  std::int64_t epoch_ = -1;
  int missed_ = 0;
  bool double_heard_ = false;  ///< in beacon 0's slot of the current cycle
  Signature own_, foreign_;    ///< own_: candidate before synchronisation
};

}  // namespace octant
