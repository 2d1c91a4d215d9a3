// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman_heading.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "models/localizers/kleeman/kleeman.h"
#include "models/physics/measurement.h"
#include "models/physics/receiver_array.h"
#include "tests/models/localizers/kleeman_room.h"

namespace octant {
namespace kleeman_heading_test {

using test::add_echoes;
using test::anywhere;
using test::hear;
using test::kleeman_room;
using test::kPrototypeSigma_s;

constexpr std::uint64_t kSeed = 1990;
constexpr double kDegree = M_PI / 180;

/// An octagon at a position and its arrivals, without times.
struct Listening {
  std::vector<Eigen::Vector3d> beacons;
  std::vector<ArrayReceiver> receivers;
  std::vector<HeardDistance> heard;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  AttenuationModel attenuation;  // of a directional array; else not looked at

  Listening() {
    for (const ArrayElement& e : octagon(0.05, 0.3)) {
      ArrayReceiver r;
      r.position_m = e.position_m;
      r.axis = e.axis.head<2>();
      r.direction = e.axis;
      receivers.push_back(r);
    }
  }
  Listening& hear(std::size_t beacon, std::initializer_list<std::size_t> by, bool kept = true) {
    for (const std::size_t r : by) {
      HeardDistance h;
      h.beacon = beacon;
      h.receiver = r;
      h.kept = kept;
      heard.push_back(h);
    }
    return *this;
  }
  /// Amplitudes at the receivers of a directional array.
  Listening& hear_loud(std::size_t beacon, std::initializer_list<std::pair<std::size_t, double>> by) {
    attenuation.half_power_angle_rad = 0.3927;
    for (const auto& [receiver, amplitude] : by) {
      hear(beacon, {receiver});
      heard.back().walk_known = true;
      heard.back().log_amplitude = std::log(amplitude);
    }
    return *this;
  }
  [[nodiscard]] HeadingInput input() const {
    return {heard, beacons, receivers, p_map_m, attenuation.directional() ? &attenuation : nullptr, 0.05};
  }
  [[nodiscard]] Heading hearing() const { return heading_from_hearing(input()); }
  [[nodiscard]] double axis_deg(std::size_t receiver) const {
    return std::atan2(receivers[receiver].axis->y(), receivers[receiver].axis->x()) / kDegree;
  }
};

/// A beacon to the east: a heading is minus the bearing in the vehicle's frame, its sector 45 degrees wide.
TEST(KleemanHeading, OneBeaconLeavesASector) {
  Listening l;
  l.beacons = {{5, 0, 0.3}};
  const double flat = 45 / std::sqrt(12.0);
  const auto expect = [&](const char* what, double bearing_deg, double sigma_deg) {
    const Heading h = l.hearing();
    ASSERT_TRUE(h.known) << what;
    EXPECT_NEAR(wrap_angle(h.rad + bearing_deg * kDegree) / kDegree, 0.0, 1e-9) << what;
    EXPECT_NEAR(h.sigma_rad / kDegree, sigma_deg, 1e-9) << what;
    EXPECT_NEAR(h.by_position.y(), -1 / 5.0, 1e-9) << what;
  };
  const double axis = l.axis_deg(2);
  l.hear(0, {2});
  expect("one hears", axis, flat);
  l.hear(0, {1, 3});
  expect("three hear", axis, flat);
  l.hear(0, {4});
  expect("four hear", axis + 22.5, flat);
  l.heard.clear();
  l.hear(0, {1, 3});
  expect("the middle one has missed the pulse", axis, flat);
  l.hear(0, {6}, /*kept=*/false);
  expect("an echo from behind", axis, flat);
  // The leftmost of three was late: the bearing can be half a spacing further left, no further right.
  l.heard.clear();
  l.hear(0, {1, 2}).hear(0, {3}, /*kept=*/false);
  expect("one is late", axis - 22.5 + 11.25, 67.5 / std::sqrt(12.0));
}

/// If two receivers receive a beacon, the louder one is nearer: the heading is in its half of the sector. A
/// difference within noise is not informative.
TEST(KleemanHeading, TheLouderReceiverIsTheNearer) {
  Listening l;
  l.beacons = {{5, 0, 0.3}};
  const double left = l.axis_deg(3), right = l.axis_deg(2), middle = (left + right) / 2;
  const auto expect = [&](const char* what, double bearing_deg, double width_deg) {
    const Heading h = l.hearing();
    ASSERT_TRUE(h.known) << what;
    EXPECT_NEAR(wrap_angle(h.rad + bearing_deg * kDegree) / kDegree, 0.0, 1e-9) << what;
    EXPECT_NEAR(h.sigma_rad / kDegree, width_deg / std::sqrt(12.0), 1e-9) << what;
    l.heard.clear();
  };
  l.hear_loud(0, {{2, 1.0}, {3, 1.0}});
  expect("alike", middle, 45.0);
  l.hear_loud(0, {{2, 1.0}, {3, 1.2}});
  expect("2.6 sigma", middle, 45.0);
  l.hear_loud(0, {{2, 1.0}, {3, 1.3}});
  expect("the left one", middle + 11.25, 22.5);
  l.hear_loud(0, {{2, 1.3}, {3, 1.0}});
  expect("the right one", middle - 11.25, 22.5);
  l.hear_loud(0, {{1, 0.5}, {2, 2.0}, {3, 1.0}});
  expect("three", l.axis_deg(2) + 11.25, 22.5);
  // Loudest at both ends: no order that a direction has. One of them is deaf in part.
  l.hear_loud(0, {{1, 2.0}, {2, 0.5}, {3, 1.0}});
  expect("contradictory", l.axis_deg(2), 45.0);
  l.hear_loud(0, {{2, 1.0}, {3, 2.0}});
  l.attenuation.half_power_angle_rad = 0.0;
  expect("receivers that hear all round alike", middle, 45.0);
}

TEST(KleemanHeading, TheGainsDerivativesAreTheNumericOnes) {
  std::mt19937_64 random(kSeed + 6);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const AttenuationModel model{
      .amplitude_1m_v = 12.5, .absorption_np_per_m = 0.1, .half_power_angle_rad = 0.5};
  for (int k = 0; k < 200; ++k) {
    ArrayReceiver r;
    r.position_m = {0.3 * uniform(random), 0.3 * uniform(random), 0.3};
    r.direction = Eigen::Vector3d(uniform(random), uniform(random), 0.3 * uniform(random)).normalized();
    const Eigen::Vector3d beacon(5 * uniform(random), 5 * uniform(random), 2.0);
    const Eigen::Vector2d p(5 * uniform(random), 5 * uniform(random));
    const double heading = M_PI * uniform(random);
    const ReceiverGain gain = receiver_gain(beacon, r, p, heading, model);
    // As in the measurement equation.
    const Pose T = Pose::planar(p.x(), p.y(), heading);
    const PathInput in{.T_map_vehicle = &T,
                       .p_beacon_map_m = beacon,
                       .p_receiver_vehicle_m = r.position_m,
                       .attenuation = &model,
                       .axis_vehicle = &r.direction};
    EXPECT_NEAR(gain.log + std::log(12.5), predict_arrival_value(in).log_amplitude, 1e-12) << k;
    constexpr double kStep = 1e-6;
    const auto log_at = [&](double x, double y, double turn) {
      return receiver_gain(beacon, r, p + Eigen::Vector2d(x, y), heading + turn, model).log;
    };
    const double scale = 1e-6 * (1 + std::abs(gain.by_heading) + gain.by_position.norm());
    EXPECT_NEAR(gain.by_heading, (log_at(0, 0, kStep) - log_at(0, 0, -kStep)) / (2 * kStep), scale) << k;
    EXPECT_NEAR(gain.by_position.x(), (log_at(kStep, 0, 0) - log_at(-kStep, 0, 0)) / (2 * kStep), scale) << k;
    EXPECT_NEAR(gain.by_position.y(), (log_at(0, kStep, 0) - log_at(0, -kStep, 0)) / (2 * kStep), scale) << k;
  }
}

/// Six beacons that agree but for one: where the others overlap, and some more sigma.
TEST(KleemanHeading, SectorsOfMostBeaconsCount) {
  Listening l;
  for (int b = 0; b < 6; ++b) {
    // Bearing 10 b degrees at heading 0, received by the nearest receiver.
    const double bearing = 10.0 * b * kDegree;
    l.beacons.emplace_back(5 * std::cos(bearing), 5 * std::sin(bearing), 0.3);
    std::size_t nearest = 0;
    for (std::size_t r = 1; r < 8; ++r)
      if (std::abs(wrap_angle(bearing - l.axis_deg(r) * kDegree)) <
          std::abs(wrap_angle(bearing - l.axis_deg(nearest) * kDegree)))
        nearest = r;
    l.hear(static_cast<std::size_t>(b), {nearest});
  }
  const Heading agreed = l.hearing();
  ASSERT_TRUE(agreed.known);
  EXPECT_LT(std::abs(agreed.rad), 5.0 * kDegree);
  EXPECT_LT(agreed.sigma_rad, 5.0 * kDegree);
  l.heard[5].receiver = (l.heard[5].receiver + 2) % 8;  // from somewhere else
  const Heading outvoted = l.hearing();
  ASSERT_TRUE(outvoted.known);
  EXPECT_LT(std::abs(outvoted.rad), 7.5 * kDegree);
  EXPECT_LT(outvoted.sigma_rad, 10.0 * kDegree);
}

/// Receivers differ by more than a tenth of a degree, so no overlap is that accurate.
TEST(KleemanHeading, ASliverOfOverlapPromisesNoMoreThanADegree) {
  Listening l;
  for (const double middle_deg :
       {22.5, 22.7, 67.2, 67.4}) {  // the first two end at 45 degrees, the others begin there
    const double bearing = (middle_deg + l.axis_deg(2)) * kDegree;
    l.beacons.emplace_back(5 * std::cos(bearing), 5 * std::sin(bearing), 0.3);
    l.hear(l.beacons.size() - 1, {2});
  }
  const Heading h = l.hearing();
  ASSERT_TRUE(h.known);
  EXPECT_NEAR(h.rad / kDegree, 44.95, 1e-6);
  EXPECT_NEAR(h.sigma_rad, 0.02, 1e-12);
}

TEST(KleemanHeading, HearingTurnsWithTheWorld) {
  std::mt19937_64 random(kSeed + 3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int k = 0; k < 200; ++k) {
    Listening l;
    l.p_map_m = {uniform(random), uniform(random)};
    for (std::size_t b = 0; b < 5; ++b) {
      l.beacons.emplace_back(6 * uniform(random), 6 * uniform(random), 1.5);
      const auto r = static_cast<std::size_t>(random() % 8);
      b % 2 == 0 ? l.hear(b, {r, (r + 1) % 8}) : l.hear(b, {r, (r + 1) % 8, (r + 2) % 8});
    }
    const Heading before = l.hearing();
    const double turn = M_PI * uniform(random);
    const Eigen::Rotation2Dd R(turn);
    l.p_map_m = R * l.p_map_m;
    for (Eigen::Vector3d& b : l.beacons) b.head<2>() = R * b.head<2>();
    const Heading after = l.hearing();
    ASSERT_EQ(before.known, after.known) << k;
    if (!before.known) continue;
    EXPECT_NEAR(wrap_angle(after.rad - before.rad - turn), 0.0, 1e-9) << k;
    EXPECT_NEAR(after.sigma_rad, before.sigma_rad, 1e-9) << k;
  }
}

TEST(KleemanHeading, HearingsDerivativeIsTheNumericOne) {
  std::mt19937_64 random(kSeed + 4);
  const Deployment d = kleeman_room();
  int compared = 0;
  for (int k = 0; k < 300; ++k) {
    const Pose truth = anywhere(random, 1.0);
    Listening l;
    for (const DeploymentBeacon& b : d.beacons) l.beacons.push_back(b.position_m);
    for (const Arrival& a : hear(d, truth, {.range_m = 15.0}, random))
      l.hear(a.beacon.index(), {a.receiver.index()});
    const auto at = [&](double x_m, double y_m) {
      l.p_map_m = truth.translation_m.head<2>() + Eigen::Vector2d(x_m, y_m);
      return l.hearing();
    };
    constexpr double kStep_m = 1e-6;
    const Heading here = at(0, 0), x = at(kStep_m, 0), x_back = at(-kStep_m, 0), y = at(0, kStep_m),
                  y_back = at(0, -kStep_m);
    ASSERT_TRUE(here.known);
    EXPECT_GE(here.sigma_rad, 0.02 - 1e-12);
    // Where two ends change places the derivative jumps; a micrometre seldom meets that.
    EXPECT_NEAR(here.by_position.x(), wrap_angle(x.rad - x_back.rad) / (2 * kStep_m), 1e-5) << k;
    EXPECT_NEAR(here.by_position.y(), wrap_angle(y.rad - y_back.rad) / (2 * kStep_m), 1e-5) << k;
    ++compared;
  }
  EXPECT_EQ(compared, 300);
}

TEST(KleemanHeading, DegenerateHearingIsUnknown) {
  const auto unknown = [](const Listening& l) {
    for (const Heading& h : {heading_from_hearing(l.input()), heading_from_mean_axes(l.input())}) {
      EXPECT_TRUE(std::isfinite(h.rad) && std::isfinite(h.sigma_rad) && h.by_position.allFinite());
      if (h.known) return false;
    }
    return true;
  };
  Listening l;
  EXPECT_TRUE(unknown(l)) << "no beacon";
  l.beacons = {{5, 0, 2.0}};
  EXPECT_TRUE(unknown(l)) << "nothing heard";
  EXPECT_TRUE(unknown(Listening(l).hear(0, {1, 5}))) << "from opposite sides";
  EXPECT_TRUE(unknown(Listening(l).hear(0, {0, 1, 2, 3, 4, 5, 6, 7}))) << "all round";
  EXPECT_TRUE(unknown(Listening(l).hear(0, {1, 2, 3}, /*kept=*/false))) << "late";
  Listening overhead = l, coincident = l, blind = l;
  overhead.p_map_m = {5, 0.01};
  EXPECT_TRUE(unknown(overhead.hear(0, {1, 2}))) << "overhead";
  coincident.beacons = {{5, 0, 0.3}};
  coincident.p_map_m = {5, 0};
  EXPECT_TRUE(unknown(coincident.hear(0, {1, 2}))) << "in the very place";
  for (ArrayReceiver& r : blind.receivers) r.axis.reset();
  EXPECT_TRUE(unknown(blind.hear(0, {1, 2}))) << "no axes";
  Listening contrary = l;
  contrary.beacons = {{5, 0, 0.3}, {5, 0.1, 0.3}};
  EXPECT_FALSE(contrary.hear(0, {2}).hear(1, {6}).hearing().known) << "the same bearing from opposite sides";
}

TEST(KleemanHeading, NoneAllocates) {
  std::mt19937_64 random(kSeed + 5);
  const Deployment d = test::directional_room();
  for (const auto heading :
       {KleemanHeading::kMeanAxes, KleemanHeading::kHearing, KleemanHeading::kInterpolation}) {
    Kleeman kleeman(d, {.heading = heading});
    std::vector<std::vector<Arrival>> cycles;
    for (int k = 0; k < 50; ++k) {
      cycles.push_back(hear(
          d, anywhere(random),
          {.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02, .amplitude_sigma = 0.05},
          random));
      add_echoes(cycles.back(), 0.1, random);
    }
    test::expect_no_allocations(kleeman, cycles);
  }
}

}  // namespace kleeman_heading_test
}  // namespace octant
