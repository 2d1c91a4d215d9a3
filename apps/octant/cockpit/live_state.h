// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/octant/session.h"
#include "io/live/live_rows.h"
#include "models/deployment.h"
#include "models/live/follower.h"

namespace octant::app {

/// Present state of a stream: rates of the beacons, position of the vehicle, its track, alarms. Memory is
/// bounded. Not for several threads.
class LiveState {
 public:
  LiveState(NameTable names, double lateness_s, bool watch);

  /// Replaces the names by longer lists that begin with the same ones.
  void set_names(const NameTable& names);
  void add(const io::LiveRow& row);
  /// Completes the poses that wait for further rows, because the stream is quiet.
  void flush();
  /// Updates the rates. Call it about once a second.
  void tick();
  /// Localizes with this deployment from now on. Its beacons may be in another order than the names.
  void use(const Deployment& deployment);
  /// Keys `beacons`, `vehicle`, `track`, `history` and `alarms` of the state.
  void add_to(Json& state) const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Reception {
    std::size_t arrivals = 0, at_last_tick = 0;
    double per_s = 0.0;
    Clock::time_point last{};
  };
  struct Sample {
    double time_s = 0.0, per_s = 0.0;
    std::optional<double> rms_sigmas, protection_m;
  };
  void take(const Fix& fix);

  NameTable names_;
  FollowOptions options_;
  std::vector<Reception> receptions_;
  std::unique_ptr<Follower> follower_;
  std::vector<BeaconId> beacon_of_;      ///< beacon of the deployment by beacon of the names
  std::vector<ReceiverId> receiver_of_;  ///< likewise for receivers
  std::vector<VehicleId> vehicle_of_;
  std::optional<Fix> fix_;
  Clock::time_point fixed_at_{}, last_tick_ = Clock::now();
  std::deque<std::array<double, 2>> track_;
  std::deque<Sample> history_;
  std::deque<Json> alarms_;
  double newest_s_ = 0.0, temperature_degC_ = std::numeric_limits<double>::quiet_NaN();
  std::size_t ok_ = 0, no_fix_ = 0;
};

}  // namespace octant::app
