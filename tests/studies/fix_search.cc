// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Compares the fixes of three methods on simulated epochs with echoes and shadows: the localizer, which
// starts in closed form and searches only for rivals of that pose; this search without a start; and the full
// search, which tries all proposals from pairs of arrivals.
//   octant_fix_search [EPOCHS of each world = 100000] [SEED = 1] [WORLD]
// OCTANT_STUDY_VERBOSE=1 in the environment prints each epoch that differs.
// Exit 1 if significantly more than one epoch in ten thousand of a world is worse than by the full search, or
// if more fixes are wrong (ok, and more than ten sigmas from the truth). Worse is another status, or a
// distance of more than a centimetre, unless the fix is within 5 cm of the truth or two poses explain the
// epoch equally well. An arrival at its gate may be used by one method and rejected by the other; then there
// are two minima, millimetres apart: `marks`.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/least_squares/candidates.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/models/localizers/hall.h"

namespace octant::study {
namespace {

constexpr double kSame_m = 0.01, kDiffering = 1e-4;

struct EchoWorld {
  const char* name;
  int beacons;
  double share, least_s, most_s;  ///< share of late arrivals, and their lateness
  double shadows;                 ///< share of beacons whose arrivals are all late by the same amount
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

/// One of the ways, its times and its fix.
struct Way {
  const char* name;
  EpochFixOptions options{};
  Fix fix{};
  Trajectory trajectory{};
  std::vector<float> us{};
  long wrong = 0;

  void take(const EpochFixModel& model, const TrajectoryModel& motion, const std::vector<Arrival>& arrivals,
            const Pose& truth) {
    set_epoch(trajectory, arrivals, {}, motion);
    const double began = processor_us();
    fix_epoch(trajectory, trajectory.segments[0], model, options, fix);
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

double off_m(const Fix& f, const Pose& truth) {
  return f.ok() ? (f.T_map_vehicle.translation_m - truth.translation_m).norm() : 0.0;
}

/// Returns true if two poses at different positions explain an epoch equally well. It is then ambiguous, and
/// a search that finds only one of them has missed the other. The full search does not examine a few
/// centimetres around a candidate.
bool has_rival(const Trajectory& epoch, const EpochFixModel& model, const EpochFixOptions& options) {
  const SearchProblem problem =
      make_search_problem(epoch, epoch.segments[0], model, options.range_uncertainty_m);
  SearchOptions search;
  search.bounded = true;
  for (int k = 0; k < 2; ++k) {
    const SearchResult found = search_pose(problem, search);
    if (found.poses.empty()) return false;
    const PlanarState& best = found.poses.front().state;
    for (std::size_t i = 1; i < found.poses.size(); ++i) {
      const PlanarState& other = found.poses[i].state;
      if (found.poses[i].score < found.poses.front().score + options.ambiguity_margin &&
          std::hypot(other.x_m - best.x_m, other.y_m - best.y_m) > kSame_m)
        return true;
    }
    search.start = best;
  }
  return false;
}

/// Differences between the fixes of a method and those of the full search.
struct Difference {
  long status = 0, place = 0, marks = 0, better = 0;

  template <class HasRival>
  void add(const Fix& full, const Fix& fix, const Pose& truth, std::size_t arrivals, long epoch,
           HasRival&& has_rival) {
    const bool other_status = full.status != fix.status;
    const bool other_place =
        !other_status && full.ok() &&
        (full.T_map_vehicle.translation_m - fix.T_map_vehicle.translation_m).norm() > kSame_m;
    status += other_status;
    place += other_place;
    marks += !other_status && !other_place && full.rejections != fix.rejections;
    if (!other_status && !other_place) return;
    const bool is_near = off_m(fix, truth) < 0.05 && (fix.ok() || off_m(full, truth) > 0.05);
    better += is_near || (fix.status == FixStatus::kAmbiguous && has_rival());
    if (std::getenv("OCTANT_STUDY_VERBOSE") != nullptr)
      std::printf("  epoch %ld: full %d %.3f m, %d of %zu; here %d %.3f m, %d\n", epoch,
                  static_cast<int>(full.status), off_m(full, truth), full.arrivals_used, arrivals,
                  static_cast<int>(fix.status), off_m(fix, truth), fix.arrivals_used);
  }
  /// @param epochs  of the world
  [[nodiscard]] bool is_chance(long epochs) const {
    const double expected = kDiffering * static_cast<double>(epochs);
    return static_cast<double>(status + place - better) <= expected + 2.33 * std::sqrt(expected);
  }
};

void print_times(Way& way) {
  std::printf("    %-13s us of the processor: 50 %% %.1f, 90 %% %.1f, 99 %% %.1f, 99.9 %% %.1f; wrong %ld\n",
              way.name, way.quantile(0.5), way.quantile(0.9), way.quantile(0.99), way.quantile(0.999),
              way.wrong);
}

/// Checks that the fixes with and without a start agree with those of the full search often enough.
bool compare(const EchoWorld& world, long epochs, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const Deployment truth = deployment_of({"", world.beacons, 0, 0, 0, 0}, random);
  Way full{"full"}, nothing{"from nothing"}, start{"from a start"};
  full.options.bounded_search = false;
  start.options.closed_form_first = true;
  Difference of_nothing, of_start;
  long ok = 0;
  Scratch memory(1u << 20);
  Deployment d;
  EpochFixModel model;
  TrajectoryModel motion;
  Trajectory judged;
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
    for (Way* way : {&full, &nothing, &start}) way->take(model, motion, arrivals, T);
    ok += start.fix.ok();
    const auto rival = [&] {
      set_epoch(judged, arrivals, {}, motion);
      return has_rival(judged, model, full.options);
    };
    of_nothing.add(full.fix, nothing.fix, T, arrivals.size(), k, rival);
    of_start.add(full.fix, start.fix, T, arrivals.size(), k, rival);
  }
  std::printf("%-20s %7ld epochs, ok %.3f %%\n", world.name, epochs,
              100.0 * static_cast<double>(ok) / static_cast<double>(epochs));
  bool alike = true;
  for (const auto& [way, difference] : {std::pair(&nothing, &of_nothing), std::pair(&start, &of_start)}) {
    std::printf("    %-13s other status %ld, other place %ld (%ld of them no worse), other marks %ld\n",
                way->name, difference->status, difference->place, difference->better, difference->marks);
    const double wrong = static_cast<double>(full.wrong);
    alike = alike && difference->is_chance(epochs) &&
            static_cast<double>(way->wrong) <= wrong + 2.33 * std::sqrt(wrong + 1.0);
  }
  for (Way* way : {&start, &nothing, &full}) print_times(*way);
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
