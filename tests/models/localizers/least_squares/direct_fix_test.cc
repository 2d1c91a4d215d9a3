// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/epoch_fix.h"

#include <random>

#include <gtest/gtest.h>

#include "models/localizers/common/trajectory_model.h"
#include "tests/models/localizers/hall.h"

namespace octant {
namespace direct_fix_test {

using test::hall;
using test::hear;
using test::random_pose;
using test::with_octagon;

/// Fixes of one epoch by the search of all proposals from pairs of arrivals, and by a method under test.
struct Both {
  Fix searched, direct;
  Both(const Deployment& d, const std::vector<Arrival>& arrivals, bool closed_form_first = true) {
    const EpochFixModel model = epoch_fix_model(d);
    for (Fix* fix : {&searched, &direct}) {
      Trajectory t;
      set_epoch(t, arrivals, {}, trajectory_model(d));
      EpochFixOptions options;
      options.bounded_search = fix == &direct;
      options.closed_form_first = fix == &direct && closed_form_first;
      fix_epoch(t, t.segments[0], model, options, *fix);
    }
  }
  void expect_alike(int k) const {
    ASSERT_EQ(searched.status, direct.status) << k;
    EXPECT_EQ(searched.rejections, direct.rejections) << k;
    if (!searched.ok()) return;
    // Both end where plain squares have their minimum, to a part in 1e10 of the cost.
    const Pose &a = searched.T_map_vehicle, &b = direct.T_map_vehicle;
    EXPECT_LT((a.translation_m - b.translation_m).norm(), 1e-5) << k;
    EXPECT_LT(std::abs(wrap_angle(a.heading_rad() - b.heading_rad())), 1e-4) << k;
    EXPECT_LT((searched.covariance - direct.covariance).norm(), 1e-3 * searched.covariance.norm()) << k;
  }
};

TEST(DirectFix, IsThatOfTheSearch) {
  std::mt19937_64 random(3);
  const Deployment d = with_octagon(hall());
  for (int k = 0; k < 300; ++k)
    Both(d, hear(d, random_pose(random), {.noise_s = 1e-5}, random)).expect_alike(k);
}

// Up to three in ten are echoes. An arrival at its gate may remain used or rejected (in one epoch of a
// thousand): then there are two minima, millimetres apart. In one of ten thousand (9 of 86,000, not here)
// they are centimetres apart or the states of the two fixes differ: in five of those only the search is
// wrong, and never only the closed form.
TEST(DirectFix, IsThatOfTheSearchAmongEchoes) {
  constexpr int kEpochs = 3000;
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> uniform;
  const Deployment d = with_octagon(hall());
  int at_a_gate = 0;
  for (int k = 0; k < kEpochs; ++k) {
    const Pose truth = random_pose(random);
    std::vector<Arrival> arrivals = hear(d, truth, {.noise_s = 1e-5}, random);
    const double share = 0.3 * uniform(random), latest_s = k % 2 == 0 ? 5e-3 : 5e-4;
    for (Arrival& a : arrivals)
      if (uniform(random) < share) a.tof_s += 8e-5 + latest_s * uniform(random);
    const Both both(d, arrivals);
    if (both.searched.rejections == both.direct.rejections) {
      both.expect_alike(k);
    } else {
      ++at_a_gate;
      EXPECT_EQ(both.searched.status, both.direct.status) << k;
      EXPECT_LE(std::abs(both.searched.arrivals_used - both.direct.arrivals_used), 1) << k;
      const Pose &a = both.searched.T_map_vehicle, &b = both.direct.T_map_vehicle;
      EXPECT_LT(std::min((a.translation_m - b.translation_m).norm(),
                         (b.translation_m - truth.translation_m).norm()),
                0.01)
          << k;
    }
  }
  EXPECT_LE(at_a_gate, kEpochs / 300);
}

/// Without an initial value, within bounds: also with few beacons, for which poses have mirror images.
TEST(DirectFix, ABoundedSearchEndsWhereAFullOneDoes) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> uniform;
  int differing = 0, ambiguous = 0;
  for (const int beacons : {3, 4, 5, 8, 12}) {
    const Deployment d = with_octagon(hall(beacons));
    for (int k = 0; k < 300; ++k) {
      std::vector<Arrival> arrivals = hear(d, random_pose(random), {.noise_s = 1e-5}, random);
      if (arrivals.empty()) continue;
      const auto shadowed = static_cast<std::size_t>(12 * uniform(random));
      for (Arrival& a : arrivals)
        if (a.beacon.index() == shadowed || uniform(random) < 0.1) a.tof_s += 3e-4 + 5e-3 * uniform(random);
      const Both both(d, arrivals, /*closed_form_first=*/false);
      ambiguous += both.searched.status == FixStatus::kAmbiguous;
      differing += both.searched.status != both.direct.status ||
                   (both.searched.ok() && both.searched.rejections != both.direct.rejections);
    }
  }
  EXPECT_GT(ambiguous, 10);
  // Two in a thousand occurred over ten seeds: with two received beacons, where neither is right.
  EXPECT_LE(differing, 6);
}

TEST(DirectFix, LeavesShadowsToTheSearch) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> uniform;
  const Deployment d = with_octagon(hall());
  for (int k = 0; k < 300; ++k) {
    std::vector<Arrival> arrivals = hear(d, random_pose(random), {.noise_s = 1e-5}, random);
    const auto shadowed = static_cast<std::size_t>(8 * uniform(random));
    for (Arrival& a : arrivals)
      if (a.beacon.index() == shadowed || uniform(random) < 0.1) a.tof_s += 3e-4 + 5e-3 * uniform(random);
    Both(d, arrivals).expect_alike(k);
  }
}

/// Each beacon over one path: however often it is received, four equations may have two poses, three have. No
/// search finds every second pose of these; the one from a start finds no fewer, and is wrong no more often.
TEST(DirectFix, PingsOverFourPathsAreLeftToTheSearch) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 1e-5);
  const Deployment d = with_octagon(hall());
  int missed = 0, wrong = 0, wrong_searched = 0, ambiguous = 0, ambiguous_searched = 0;
  for (int k = 0; k < 1000; ++k) {
    const Pose truth = random_pose(random);
    std::vector<Arrival> few;
    for (const Arrival& a : hear(d, truth, {.noise_s = 1e-5}, random))
      if (a.beacon.index() < 4 && a.receiver.index() == 2 * a.beacon.index())
        for (int ping = 0; ping < 4; ++ping) {
          few.push_back(a);
          few.back().tof_s += noise(random);
        }
    if (few.empty()) continue;
    const Both both(d, few);
    const auto is_wrong = [&](const Fix& f) {
      return f.ok() && (f.T_map_vehicle.translation_m - truth.translation_m).norm() > 0.1;
    };
    wrong += is_wrong(both.direct);
    wrong_searched += is_wrong(both.searched);
    ambiguous += both.direct.status == FixStatus::kAmbiguous;
    ambiguous_searched += both.searched.status == FixStatus::kAmbiguous;
    missed += both.searched.status == FixStatus::kAmbiguous && both.direct.ok();
  }
  EXPECT_GT(ambiguous, 20);
  EXPECT_GE(ambiguous, ambiguous_searched);
  EXPECT_LE(missed, 4);
  EXPECT_LE(wrong, wrong_searched);
}

TEST(DirectFix, BeaconsInLineAreNotBeyondDoubt) {
  std::mt19937_64 random(5);
  Deployment d = with_octagon(hall(4));
  for (std::size_t b = 0; b < 4; ++b)
    d.beacons[b].position_m = {2.0 + 4.0 * static_cast<double>(b), 0.0, 2.5};
  for (int k = 0; k < 50; ++k)
    Both(d, hear(d, random_pose(random), {.noise_s = 1e-5}, random)).expect_alike(k);
}

}  // namespace direct_fix_test
}  // namespace octant
