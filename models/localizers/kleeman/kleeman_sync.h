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

/// A pulse as a channel's threshold detector logs it; whose it is is not known yet.
struct PulseArrival {
  double time_s = 0.0;      ///< onset, on the receiver's clock
  int channel = 0;          ///< of the receiver array, from 0
  double duration_s = 0.0;  ///< above threshold
  double amplitude_v = 0.0;
};

struct PulseSyncOptions {
  FiringSchedule schedule{};
  VehicleId vehicle{0};
  ReceiverId first_receiver{0};        ///< of channel 0; the others follow
  double double_tolerance_s = 0.2e-3;  ///< of the time between beacon 0's two pulses
  double pulse_tolerance = 0.4;        ///< of the length of either, relative to t_pulse
  /// The weaker of the two over the stronger: at least so much. An echo that comes t_double after a single
  /// pulse has travelled 1.9 m more and been absorbed: within 10 m of the beacon it has no more than 0.81 of
  /// the amplitude.
  double amplitude_ratio = 0.85;
  double min_pulse = 0.5;       ///< anything shorter than this part of t_pulse is noise
  double max_flight_s = 0.045;  ///< from the farthest beacon; t_fire has to be more than twice as much
  /// Most by which beacon 0's double pulse moves the firing times in a cycle: 1 m/s for a cycle, and the
  /// drift of clocks. More than that is an echo of it, or its return after it was blocked, which takes a few
  /// cycles.
  double max_shift_s = 4e-3;
  int max_missed_cycles = 20;  ///< without beacon 0's double pulse, until synchronisation counts as lost
};

/// Whose turn it is, from beacon 0's double pulse in a stream of pulses (L. Kleeman, sections 1.2 and 5.1).
///
/// The first double pulse that is no echo sets the receiver's notion of when beacon 0 fires
/// (its arrival, for its flight is not known: a cycle offset), so from any start it takes one cycle at most,
/// and the flight. From then on the first pulse on each channel in each beacon's slot is that beacon's
/// arrival; later ones are echoes and are dropped. Every cycle in which the double pulse is heard sets the
/// next one's firing times, so that clocks may drift and the vehicle move; without it (beacon 0 blocked) the
/// schedule runs on. A double pulse that keeps coming in another beacon's slot, while there is none in beacon
/// 0's, takes over. Echoes in a slot must have died before the next: eq. 1. Allocates nothing.
class PulseSync {
 public:
  static constexpr int kChannels = 16;

  explicit PulseSync(const PulseSyncOptions& options = {}) : options_(options) {}

  /// The next pulse, in order of time (onsets may change places within t_pulse).
  /// @return arrivals known by it: none, one, or at the moment of synchronisation those of beacon 0 on all
  /// channels. tof_s is the arrival's time less the beacon's nominal firing time; epoch counts cycles. Valid
  /// until the next call.
  std::span<const Arrival> push(const PulseArrival& pulse) noexcept;

  [[nodiscard]] bool synchronised() const { return synchronised_; }
  /// Nominal firing time of beacon 0 in the present cycle, on the receiver's clock [s].
  [[nodiscard]] double cycle_start_s() const { return start_s_; }
  [[nodiscard]] std::int64_t epoch() const { return epoch_; }
  void reset() noexcept { *this = PulseSync(options_); }

 private:
  /// A double pulse, and on how many channels it was heard.
  struct Signature {
    double time_s = -1e300;
    int channels = 0;
    int repeats = 0;  ///< cycles in a row
  };
  static constexpr int kRemembered = 8;

  /// The last pulses of a channel, in no order.
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
      heard_slot_{};  ///< last slot in which a channel had its arrival, plus one; within the cycle
  std::array<Arrival, kChannels> out_;
  std::size_t out_count_ = 0;
  bool synchronised_ = false, confirmed_ = false;
  double start_s_ = 0.0, next_shift_s_ = 0.0;
  std::int64_t epoch_ = -1;
  int missed_ = 0;
  bool double_heard_ = false;  ///< in the present cycle, in beacon 0's slot
  Signature own_, foreign_;    ///< own_: before synchronisation, the candidate
};

}  // namespace octant
