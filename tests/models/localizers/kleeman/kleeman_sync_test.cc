// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_sync.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>

#include <gtest/gtest.h>

#include "models/localizers/kleeman/kleeman.h"
#include "models/simulator/random.h"
#include "tests/models/localizers/kleeman_room.h"
#include "tests/support/allocation_count.h"

namespace octant {
namespace kleeman_sync_test {

constexpr double kSpeed_mps = 345.0;

/// A pulse, with its source, which the receiver does not know.
struct TruePulse {
  PulseArrival pulse;
  int beacon = 0;
  std::int64_t cycle = 0;
  bool direct = false;
};

struct StreamOptions {
  int cycles = 12;
  double echoes = 1.5;        ///< mean number of echoes of each pulse on each channel
  double spikes_per_s = 5.0;  ///< short noise
  double drift = 0.0;         ///< time of the receiver's clock
  std::function<bool(int beacon, std::int64_t cycle)> blocked = [](int, std::int64_t) { return false; };
};

/// Pulses on the eight channels of a stationary vehicle. An echo has travelled up to 25 m more and lost 4 %
/// or more of its amplitude in addition; pulses below 200 mV are not received.
std::vector<TruePulse> stream(const Deployment& room, const Pose& pose, const FiringSchedule& schedule,
                              const StreamOptions& o, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  Random random(seed);
  std::vector<TruePulse> out;
  const auto heard = test::hear(room, pose, {.range_m = 15.0}, engine);
  for (std::int64_t cycle = 0; cycle < o.cycles; ++cycle) {
    for (const Arrival& a : heard) {
      const int beacon = a.beacon.value;
      if (o.blocked(beacon, cycle)) continue;
      const double fired_s = firing_s(schedule, a.beacon, cycle), distance_m = a.tof_s * kSpeed_mps;
      const auto log = [&](double start_s, double path_m, double gain, bool direct) {
        const double amplitude_v = 12.5 / path_m * gain;
        if (amplitude_v < 0.2) return;
        const double time_s = fired_s + start_s + path_m / kSpeed_mps + 1e-5 * random.normal();
        const double noisy_v = amplitude_v * (1 + 0.03 * random.normal());
        out.push_back({{time_s * (1 + o.drift), a.receiver.value,
                        2.5e-3 * (1 + 0.1 * random.clipped_normal()), noisy_v},
                       beacon,
                       cycle,
                       direct});
      };
      const auto fire = [&](double start_s) {
        log(start_s, distance_m, 1.0, true);
        for (int i = 0; i < 3; ++i)
          if (random.uniform() < o.echoes / 3)
            log(start_s, distance_m + random.uniform(1.0, 25.0), std::pow(0.96, 1 + 3 * random.uniform()),
                false);
      };
      fire(0.0);
      if (beacon == 0) fire(schedule.double_s);
    }
  }
  const double end_s = o.cycles * cycle_s(schedule);
  for (double t = 0; t < end_s; t += random.log_uniform(0.3, 3.0) / o.spikes_per_s)
    out.push_back({{t, static_cast<int>(random.uniform(0, 8)), 0.3e-3, 0.3}, -1, 0, false});
  std::stable_sort(out.begin(), out.end(),
                   [](const TruePulse& a, const TruePulse& b) { return a.pulse.time_s < b.pulse.time_s; });
  return out;
}

struct Labels {
  int right = 0, wrong = 0;
  double synchronised_s = std::nan("");  ///< first, on the receiver's clock
};

/// Pushes what comes after start_s; direct pulses that got a label are compared with the truth.
Labels run(PulseSync& sync, const std::vector<TruePulse>& pulses, double start_s = 0.0,
           double end_s = 1e300) {
  Labels labels;
  std::map<std::pair<double, int>, const TruePulse*> by_time;
  for (const TruePulse& p : pulses) by_time[{p.pulse.time_s, p.pulse.channel}] = &p;
  for (const TruePulse& p : pulses) {
    if (p.pulse.time_s < start_s || p.pulse.time_s > end_s) continue;
    for (const Arrival& a : sync.push(p.pulse)) {
      const TruePulse* from = by_time.at({a.time_s, a.receiver.value});
      ++(from->beacon == a.beacon.value ? labels.right : labels.wrong);
    }
    if (std::isnan(labels.synchronised_s) && sync.synchronised()) labels.synchronised_s = p.pulse.time_s;
  }
  return labels;
}

TEST(FiringSchedule, BeaconsFireInTurn) {
  const FiringSchedule schedule;
  EXPECT_DOUBLE_EQ(cycle_s(schedule), 0.9);
  EXPECT_DOUBLE_EQ(firing_s(schedule, BeaconId(4), 2), 2 * 0.9 + 4 * 0.15);
}

/// Eq. 1 with the paper's figures.
TEST(FiringSchedule, DesignRuleGivesThePublishedFigures) {
  EXPECT_NEAR(shortest_fire_s({.threshold_v = 0.087}), 0.416, 0.0005);
  EXPECT_NEAR(shortest_fire_s({.threshold_v = 0.087, .speed_mps = 300.0}), 0.480,
              0.002);  // the paper's 480 ms
  const FiringDesign chosen{.absorbed_fraction = 0.04, .reflections = 5};
  EXPECT_LE(shortest_fire_s(chosen), 0.150);  // "200 mV and 150 ms"
}

/// From any start phase, anywhere in the room, within one cycle (and the flight and the double pulse itself).
TEST(PulseSync, FindsBeacon0WithinACycle) {
  const Deployment room = test::kleeman_room();
  const FiringSchedule schedule;
  std::cout << "seeds 0..119\n";
  int wrong = 0, right = 0;
  for (int k = 0; k < 120; ++k) {
    const Pose pose = Pose::planar(0.5 + k % 10, 0.5 + (k * 7) % 10, 0.3 * k);
    const double start_s = cycle_s(schedule) * (1 + k / 120.0);
    PulseSync sync;
    const Labels labels =
        run(sync, stream(room, pose, schedule, {.cycles = 6}, static_cast<std::uint64_t>(k)), start_s);
    EXPECT_LE(labels.synchronised_s, start_s + cycle_s(schedule) + 0.045 + 0.008) << k;
    // In phase: less than a flight behind a firing of beacon 0.
    const double phase = sync.cycle_start_s() / cycle_s(schedule);
    EXPECT_LT((phase - std::floor(phase)) * cycle_s(schedule), 0.045) << k;
    wrong += labels.wrong;
    right += labels.right;
  }
  EXPECT_GT(right, 120 * 3 * 15);
  // Right before beacon 0 a slot has to begin before its firing, and the last echoes of the slot before, 38 m
  // of path, may just reach into it: an early arrival at one receiver, which the localizer leaves out.
  EXPECT_LT(wrong, 0.002 * right);
}

/// Every cycle gives a fix: the labels, the times and the cycle's offset are what Kleeman takes.
TEST(PulseSync, FeedsTheLocalizer) {
  const Deployment room = test::kleeman_room();
  const FiringSchedule schedule;
  const Pose pose = Pose::planar(4.0, 4.9, 0.7);
  PulseSync sync;
  Kleeman kleeman(room);
  std::map<std::int64_t, std::vector<Arrival>> epochs;
  for (const TruePulse& p : stream(room, pose, schedule, {.cycles = 8}, 3))
    if (p.pulse.time_s > 0.4)
      for (const Arrival& a : sync.push(p.pulse)) epochs[a.epoch].push_back(a);
  EXPECT_EQ(epochs.size(), 7u);
  for (const auto& [epoch, arrivals] : epochs) {
    const Fix fix = kleeman.locate(Observations{arrivals, {}});
    ASSERT_TRUE(fix.ok()) << epoch << " " << to_string(fix.status);
    EXPECT_EQ(fix.epoch, epoch);
    // Five sigma at 10 us: the flight of the first beacon, some 20 ms, is in the offset alone.
    EXPECT_LT((fix.T_map_vehicle.translation_m - pose.translation_m).norm(), 0.01);
  }
}

/// Beacon 0 in a shadow for a while: the schedule runs on; for long: lost, and found again within a cycle of
/// its return.
TEST(PulseSync, OutlastsABlockedBeaconAndComesBack) {
  const Deployment room = test::kleeman_room();
  const FiringSchedule schedule;
  const Pose pose = Pose::planar(6.0, 3.0, 0.2);
  StreamOptions o{.cycles = 20, .blocked = [](int beacon, std::int64_t cycle) {
                    return beacon == 0 && cycle >= 3 && cycle < 15;
                  }};
  const auto pulses = stream(room, pose, schedule, o, 5);
  PulseSync patient;
  const Labels through = run(patient, pulses);
  EXPECT_TRUE(patient.synchronised());
  EXPECT_EQ(through.wrong, 0);
  EXPECT_EQ(patient.epoch(), 19);

  PulseSyncOptions options;
  options.max_missed_cycles = 3;
  PulseSync strict(options);
  EXPECT_EQ(run(strict, pulses, 0.0, 14 * 0.9).wrong, 0);
  EXPECT_FALSE(strict.synchronised());
  const Labels after = run(strict, pulses, 14 * 0.9);
  EXPECT_EQ(after.wrong, 0);
  EXPECT_LE(after.synchronised_s, 15 * 0.9 + 0.053);
  EXPECT_EQ(strict.epoch(), 19) << "cycles are counted on through the gap";
}

/// A crystal error of 100 ppm is 90 us in each cycle: 54 ms in nine minutes, more than the margin of a slot.
TEST(PulseSync, FollowsADriftingClock) {
  const Deployment room = test::kleeman_room();
  for (const double drift : {-1e-4, 1e-4}) {
    PulseSync sync;
    const auto pulses = stream(room, Pose::planar(3, 7, 1.0), FiringSchedule{},
                               {.cycles = 600, .echoes = 0.5, .drift = drift}, 9);
    const Labels labels = run(sync, pulses);
    EXPECT_EQ(labels.wrong, 0);
    EXPECT_TRUE(sync.synchronised());
    EXPECT_NEAR(sync.cycle_start_s(), pulses.back().pulse.time_s - 0.8, 0.2);
  }
}

/// The control module is reset: the sequence continues with another phase.
TEST(PulseSync, FollowsARestartOfTheBeacons) {
  const Deployment room = test::kleeman_room();
  const FiringSchedule schedule;
  PulseSync sync;
  run(sync, stream(room, Pose::planar(3, 7, 1.0), schedule, {.cycles = 5}, 11));
  const std::int64_t before = sync.epoch();
  auto later = stream(room, Pose::planar(3, 7, 1.0), schedule, {.cycles = 10}, 12);
  for (TruePulse& p : later) p.pulse.time_s += 5 * 0.9 + 0.47;
  run(sync, later, 0.0, 5 * 0.9 + 0.47 + 4 * 0.9);
  const Labels labels = run(sync, later, 5 * 0.9 + 0.47 + 4 * 0.9);
  EXPECT_EQ(labels.wrong, 0);
  EXPECT_GT(labels.right, 80);
  EXPECT_GT(sync.epoch(), before);
}

/// An echo t_double behind a single pulse is no signature: it is weaker.
TEST(PulseSync, AnEchoIsNoDoublePulse) {
  PulseSync sync;
  for (int slot = 0; slot < 20; ++slot) {
    sync.push({0.15 * slot, 2, 2.5e-3, 2.0});
    sync.push({0.15 * slot + 5.5e-3, 2, 2.5e-3, 1.5});
    sync.push({0.15 * slot + 11.0e-3, 3, 2.5e-3, 1.5});  // alike, but on another channel
    sync.push({0.15 * slot + 20.0e-3, 2, 0.5e-3, 1.5});
    sync.push({0.15 * slot + 25.5e-3, 2, 0.5e-3, 1.5});  // alike, but too short
  }
  EXPECT_FALSE(sync.synchronised());
}

TEST(PulseSync, PushAllocatesNothing) {
  const auto pulses =
      stream(test::kleeman_room(), Pose::planar(3, 7, 1.0), FiringSchedule{}, {.cycles = 6}, 13);
  PulseSync sync;
  const std::size_t before = test::allocations();
  std::size_t arrivals = 0;
  for (const TruePulse& p : pulses) arrivals += sync.push(p.pulse).size();
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GT(arrivals, 60u);
}

}  // namespace kleeman_sync_test
}  // namespace octant
