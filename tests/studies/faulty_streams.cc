// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Integrity of fixes among faults: errors beyond the protection level of fixes whose integrity is ok, for
// single epochs (least squares) and for live drives (Follower), with availability.
//   octant_faulty_streams [FIXES of each row = 100000] [SEED = 1] [NAME]
// The stated risk of a fix is kProtectionRisk / 2 without a fault of a beacon, and exp(-kFaultySigmas^2 / 2)
// with one (separation.h). Consecutive fixes beyond their levels are one event, because they share their
// error. Exit 1 if a row has more events than chance allows at 1 in 1000 (Poisson).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "models/live/follower.h"
#include "models/localizers/common/separation.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/trajectory.h"
#include "tests/models/localizers/drive_world.h"
#include "tests/models/localizers/hall.h"

namespace octant::study {
namespace {

enum class Fault { kNone, kEchoes, kDeadBeacon, kMovedBeacon, kBentReceiver, kGap, kKidnapping };
struct Row {
  const char* name;
  Fault fault;
  bool live, faulty_beacon;
};
constexpr Row kRows[] = {{"epochs", Fault::kNone, false, false},
                         {"epochs_echoes", Fault::kEchoes, false, true},
                         {"epochs_dead", Fault::kDeadBeacon, false, false},
                         {"epochs_moved", Fault::kMovedBeacon, false, true},
                         {"epochs_bent", Fault::kBentReceiver, false, true},
                         {"live", Fault::kNone, true, false},
                         {"live_echoes", Fault::kEchoes, true, true},
                         {"live_dead", Fault::kDeadBeacon, true, false},
                         {"live_moved", Fault::kMovedBeacon, true, true},
                         {"live_bent", Fault::kBentReceiver, true, true},
                         {"live_gaps", Fault::kGap, true, false},
                         {"live_kidnapped", Fault::kKidnapping, true, false}};
constexpr double kNoise_s = 1e-5, kDrive_s = 300.0, kFaultAt_s = 60.0;

struct Tally {
  std::size_t instants = 0, fixes = 0, ok = 0, beyond = 0, events = 0;
  double largest_ratio = 0.0;  ///< of an error to its level
  bool was_beyond = false;

  void add(const Fix& fix, const Pose& truth) {
    ++instants;
    fixes += fix.ok();
    if (integrity(fix) != Integrity::kOk) {
      was_beyond = false;
      return;
    }
    ++ok;
    const double ratio =
        (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>().norm() / fix.protection_level_m;
    largest_ratio = std::max(largest_ratio, ratio);
    beyond += ratio > 1.0;
    events += ratio > 1.0 && !was_beyond;
    was_beyond = ratio > 1.0;
  }
};

double log_uniform(double low, double high, std::mt19937_64& random) {
  return low * std::pow(high / low, std::uniform_real_distribution<double>(0, 1)(random));
}

/// The site as it is, while the localizer has that of the calibration.
Deployment changed(Deployment d, Fault fault, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  if (fault == Fault::kMovedBeacon) {
    const double turn = std::uniform_real_distribution<double>(0, 2 * M_PI)(random);
    d.beacons[random() % d.beacons.size()].position_m +=
        log_uniform(0.02, 3.0, random) * Eigen::Vector3d(std::cos(turn), std::sin(turn), 0.0);
  } else if (fault == Fault::kBentReceiver) {
    const Eigen::Vector3d to(normal(random), normal(random), normal(random));
    d.receivers[random() % d.receivers.size()].position_m += log_uniform(0.01, 0.1, random) * to.normalized();
  }
  return d;
}

/// Makes a share of up to 30 % of the arrivals late by 2 cm to 4 m, or silences one beacon, from a time on.
void disturb(std::vector<Arrival>& arrivals, Fault fault, double from_s, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform;
  const double share = 0.3 * uniform(random);
  const BeaconId dead(random() % 8);
  if (fault == Fault::kEchoes) {
    for (Arrival& a : arrivals)
      if (uniform(random) < share) a.tof_s += log_uniform(0.02, 4.0, random) / 343.7;
  } else if (fault == Fault::kDeadBeacon) {
    std::erase_if(arrivals, [&](const Arrival& a) { return a.beacon == dead && a.time_s >= from_s; });
  }
}

Tally epochs(const Row& row, std::size_t count, std::mt19937_64& random) {
  const Deployment d = test::with_octagon(test::hall());
  LeastSquaresLocalizer localizer(d);
  Tally tally;
  Fix fix;
  while (tally.instants < count) {
    const Pose truth = test::random_pose(random);
    std::vector<Arrival> arrivals =
        test::hear(changed(d, row.fault, random), truth, {.noise_s = kNoise_s}, random);
    disturb(arrivals, row.fault, -INFINITY, random);
    localizer.locate({arrivals, {}}, fix);
    tally.add(fix, truth);
    tally.was_beyond = false;  // epochs are independent
  }
  return tally;
}

/// A drive on which the fault begins after a minute.
test::Drive faulty_drive(const Deployment& d, Fault fault, std::mt19937_64& random) {
  const std::uint64_t seed = random();
  test::Drive w = test::drive(d, kDrive_s, kNoise_s, 1.0, seed);
  if (fault == Fault::kMovedBeacon || fault == Fault::kBentReceiver) {
    const test::Drive after = test::drive(changed(d, fault, random), kDrive_s, kNoise_s, 1.0, seed);
    std::erase_if(w.log.arrivals, [](const Arrival& a) { return a.time_s >= kFaultAt_s; });
    std::ranges::copy_if(after.log.arrivals, std::back_inserter(w.log.arrivals),
                         [](const Arrival& a) { return a.time_s >= kFaultAt_s; });
  } else if (fault == Fault::kGap) {
    const double length_s = log_uniform(0.2, 10.0, random);
    for (double at_s = kFaultAt_s; at_s < kDrive_s; at_s += 30.0)
      std::erase_if(w.log.odometry, [&](const OdometryStep& step) {
        return step.time_s > at_s && step.time_s <= at_s + length_s;
      });
  } else if (fault == Fault::kKidnapping) {
    // The vehicle is carried along its path for some seconds without a row, and its clock shows nothing of
    // it.
    const double carried_s = log_uniform(1.0, 60.0, random), end_s = kFaultAt_s + carried_s;
    const auto cut = [&](auto& rows) {
      std::erase_if(rows, [&](const auto& r) { return r.time_s > kFaultAt_s && r.time_s <= end_s; });
      for (auto& r : rows)
        if (r.time_s > end_s) r.time_s -= carried_s;
    };
    cut(w.log.odometry);
    cut(w.log.arrivals);
    cut(w.truth);
  }
  disturb(w.log.arrivals, fault, kFaultAt_s, random);
  return w;
}

Tally live(const Row& row, std::size_t count, std::mt19937_64& random) {
  const Deployment d = test::with_octagon(test::hall());
  Tally tally;
  while (tally.instants < count) {
    const test::Drive w = faulty_drive(d, row.fault, random);
    FollowOptions options;
    options.odometry = w.log.odometry_accuracy;
    Follower follower(d, options);
    follower.on_fix = [&](const Fix& fix) {
      Pose truth;
      if (interpolate_poses(w.truth, fix.time_s, 1.0, truth)) tally.add(fix, truth);
    };
    std::size_t next = 0;
    for (const OdometryStep& step : w.log.odometry) {
      while (next < w.log.arrivals.size() && w.log.arrivals[next].time_s <= step.time_s)
        follower.hear(w.log.arrivals[next++]);
      follower.move(step);
    }
    follower.flush();
    tally.was_beyond = false;
  }
  return tally;
}

/// Probability of so many events or more, with this mean.
double poisson_beyond(std::size_t events, double mean) {
  double below = 0.0, term = std::exp(-mean);
  for (std::size_t k = 0; k < events; ++k) {
    below += term;
    term *= mean / static_cast<double>(k + 1);
  }
  return 1.0 - below;
}

bool report(const Row& row, const Tally& t) {
  const double risk =
      row.faulty_beacon ? std::exp(-0.5 * kFaultySigmas * kFaultySigmas) : 0.5 * kProtectionRisk;
  const double allowed = risk * static_cast<double>(t.ok), all = static_cast<double>(t.instants);
  const bool holds = poisson_beyond(t.events, allowed) > 1e-3;
  std::fprintf(stderr,
               "%-15s instants %8zu  fixes %5.1f %%  integrity ok %5.1f %%  beyond %6zu in %4zu events  "
               "allowed %8.2f  largest error / level %7.2f  %s\n",
               row.name, t.instants, 100.0 * static_cast<double>(t.fixes) / all,
               100.0 * static_cast<double>(t.ok) / all, t.beyond, t.events, allowed, t.largest_ratio,
               holds ? "holds" : "FAILS");
  return holds;
}

int run(std::size_t count, std::uint64_t seed, const std::string& only) {
  bool all_hold = true;
  for (const Row& row : kRows) {
    if (!only.empty() && only != row.name) continue;
    std::mt19937_64 random(seed);
    all_hold = report(row, row.live ? live(row, count, random) : epochs(row, count, random)) && all_hold;
  }
  return all_hold ? 0 : 1;
}

}  // namespace
}  // namespace octant::study

int main(int argc, char** argv) {
  const std::size_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 100000;
  return octant::study::run(count, argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1,
                            argc > 3 ? argv[3] : "");
}
