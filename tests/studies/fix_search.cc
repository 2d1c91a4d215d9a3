// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Whether the fix of the localizer, which starts in closed form and looks for nothing but rivals of what it
// finds, is that of the search from nothing: simulated epochs by both, with echoes and shadows.
//   octant_fix_search [EPOCHS of each world = 100000] [SEED = 1] [WORLD]
// OCTANT_STUDY_VERBOSE=1 in the environment: each epoch that differs.
// Exit 1 where by more than chance more than one epoch in ten thousand of a world is worse than by the search
// from nothing (another status, or more than a centimetre apart, and not within 5 cm of the truth), or more
// fixes are wrong (ok, and off the truth by more than ten sigmas). An arrival right at its gate may be in
// here and out there, then both are minima, millimetres apart: `marks`.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/least_squares/direct_fix.h"
#include "tests/models/localizers/hall.h"

namespace octant::study {
namespace {

constexpr double kSame_m = 0.01, kDiffering = 1e-4;

struct EchoWorld {
  const char* name;
  int beacons;
  double share, least_s, most_s;  ///< of arrivals that are late, by how much
  double shadows;                 ///< of beacons all of whose arrivals are late alike
  double calibrated_m = 0.0;      ///< sigma of the beacons
};

constexpr EchoWorld kWorlds[] = {
    {"clean", 8, 0.0, 0, 0, 0.0},
    {"echoes_5", 8, 0.05, 3e-4, 12e-3, 0.0},
    {"echoes_5_calibrated", 8, 0.05, 3e-4, 12e-3, 0.0, 2e-3},
    {"echoes_10_early", 8, 0.10, -1e-3, 5e-3, 0.0},
    {"echoes_10_small", 8, 0.10, 4e-5, 5e-4, 0.0},
    {"echoes_20", 8, 0.20, 3e-4, 12e-3, 0.0},
    {"shadows", 8, 0.05, 3e-4, 12e-3, 0.1},
    {"shadows_small", 8, 0.03, 5e-5, 5e-4, 0.1, 2e-3},
    {"five_beacons", 5, 0.05, 3e-4, 12e-3, 0.03},
};

double processor_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// One of both ways, its times and its fix.
struct Way {
  void (*fix_node)(Trajectory&, const Segment&, const EpochFixModel&, const EpochFixOptions&, Fix&);
  Fix fix{};
  Trajectory trajectory{};
  std::vector<float> us{};
  long wrong = 0;

  void take(const EpochFixModel& model, const TrajectoryModel& motion, const std::vector<Arrival>& arrivals,
            const Pose& truth) {
    set_epoch(trajectory, arrivals, {}, motion);
    const double began = processor_us();
    fix_node(trajectory, trajectory.segments[0], model, {}, fix);
    us.push_back(static_cast<float>(processor_us() - began));
    if (!fix.ok()) return;
    const Eigen::Vector2d off = (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>();
    const Eigen::Matrix2d P = fix.covariance.topLeftCorner<2, 2>() + 1e-5 * Eigen::Matrix2d::Identity();
    wrong += off.dot(P.inverse() * off) > 100.0;
  }
  float quantile(double at) {
    std::sort(us.begin(), us.end());
    return us[static_cast<std::size_t>(at * static_cast<double>(us.size() - 1))];
  }
};

Deployment deployment_of(const EchoWorld& world, std::mt19937_64& random) {
  Deployment d = test::with_octagon(test::hall(world.beacons));
  std::normal_distribution<double> normal;
  for (DeploymentBeacon& b : d.beacons) {
    b.covariance_m2 = world.calibrated_m * world.calibrated_m * Eigen::Matrix3d::Identity();
    for (int k = 0; k < 3; ++k) b.position_m[k] += world.calibrated_m * normal(random);
  }
  return d;
}

std::vector<Arrival> epoch_of(const EchoWorld& world, const Deployment& truth, const Pose& T,
                              std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform, late(world.least_s, world.most_s);
  std::vector<double> shadow_s(truth.beacons.size(), 0.0);
  for (double& s : shadow_s)
    if (uniform(random) < world.shadows) s = late(random);
  std::vector<Arrival> arrivals = test::hear(truth, T, {.noise_s = 1e-5}, random);
  for (Arrival& a : arrivals) {
    a.tof_s += shadow_s[a.beacon.index()];
    if (uniform(random) < world.share) a.tof_s += late(random);
  }
  return arrivals;
}

/// Whether the fix from the start is that of the search often enough.
bool compare(const EchoWorld& world, long epochs, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const Deployment truth = deployment_of({"", world.beacons, 0, 0, 0, 0}, random);
  Way search{fix_epoch}, start{fix_directly};
  long status = 0, place = 0, marks = 0, better = 0, ok = 0;
  Scratch memory(1u << 20);
  Deployment d;
  EpochFixModel model;
  TrajectoryModel motion;
  for (long k = 0; k < epochs; ++k) {
    if (k % 1000 == 0) {
      d = deployment_of(world, random);
      model = epoch_fix_model(d);
      motion = trajectory_model(d);
    }
    const Pose T = test::random_pose(random);
    const std::vector<Arrival> arrivals = epoch_of(world, truth, T, random);
    if (arrivals.empty()) continue;
    const ScratchScope scope(memory);
    search.take(model, motion, arrivals, T);
    start.take(model, motion, arrivals, T);
    ok += start.fix.ok();
    const auto off_m = [&T](const Fix& f) {
      return f.ok() ? (f.T_map_vehicle.translation_m - T.translation_m).norm() : 0.0;
    };
    const bool other_status = search.fix.status != start.fix.status;
    const bool other_place =
        !other_status && search.fix.ok() &&
        (search.fix.T_map_vehicle.translation_m - start.fix.T_map_vehicle.translation_m).norm() > kSame_m;
    status += other_status;
    place += other_place;
    marks += !other_status && !other_place && search.fix.rejections != start.fix.rejections;
    better += (other_status || other_place) && off_m(start.fix) < 0.05 &&
              (start.fix.ok() || off_m(search.fix) > 0.05);
    if ((other_status || other_place) && std::getenv("OCTANT_STUDY_VERBOSE") != nullptr)
      std::printf("  epoch %ld: search %d %.3f m, %d of %zu; start %d %.3f m, %d\n", k,
                  static_cast<int>(search.fix.status), off_m(search.fix), search.fix.arrivals_used,
                  arrivals.size(), static_cast<int>(start.fix.status), off_m(start.fix),
                  start.fix.arrivals_used);
  }
  const double expected = kDiffering * static_cast<double>(epochs);
  const double wrong = static_cast<double>(search.wrong);
  const bool alike = static_cast<double>(status + place - better) <= expected + 2.33 * std::sqrt(expected) &&
                     static_cast<double>(start.wrong) <= wrong + 2.33 * std::sqrt(wrong + 1.0);
  std::printf(
      "%-20s %7ld epochs, ok %.3f %%: other status %ld, other place %ld (%ld of them no worse), other marks "
      "%ld; wrong %ld, "
      "from nothing %ld\n",
      world.name, epochs, 100.0 * static_cast<double>(ok) / static_cast<double>(epochs), status, place,
      better, marks, start.wrong, search.wrong);
  for (Way* way : {&start, &search})
    std::printf("    %-13s us of the processor: 50 %% %.1f, 90 %% %.1f, 99 %% %.1f, 99.9 %% %.1f\n",
                way == &start ? "from a start" : "from nothing", way->quantile(0.5), way->quantile(0.9),
                way->quantile(0.99), way->quantile(0.999));
  return alike;
}

}  // namespace
}  // namespace octant::study

int main(int argc, char** argv) {
  const long epochs = argc > 1 ? std::atol(argv[1]) : 100'000;
  const std::uint64_t seed = argc > 2 ? static_cast<std::uint64_t>(std::atoll(argv[2])) : 1;
  bool alike = true;
  for (const octant::study::EchoWorld& world : octant::study::kWorlds)
    if (argc <= 3 || std::strcmp(argv[3], world.name) == 0)
      alike = octant::study::compare(world, epochs, seed) && alike;
  return alike ? 0 : 1;
}
