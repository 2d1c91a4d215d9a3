// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/ranges.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/calib/at_truth.h"

namespace octant::test {
namespace ranges_test {

Scenario quiet(Scenario s) {
  s = without_noise(std::move(s));
  s.path.epochs = 15;
  return s;
}

RC_GTEST_PROP(Median, HasAsManyBelowAsAbove, (std::vector<double> values)) {
  const double m = calib::median(values);
  if (values.empty()) {
    RC_ASSERT(m == 0.0);
    return;
  }
  const auto below = std::count_if(values.begin(), values.end(), [m](double v) { return v < m; }),
             above = std::count_if(values.begin(), values.end(), [m](double v) { return v > m; });
  RC_ASSERT(2 * below <= std::ssize(values));
  RC_ASSERT(2 * above <= std::ssize(values));
  RC_ASSERT(std::find(values.begin(), values.end(), m) != values.end());
}

void expect_true_ranges(const Scenario& scenario) {
  AtTruth at(scenario, 1);
  for (std::size_t b = 0; b < 8; ++b) {
    const auto ranges = calib::ranges_to(at.trajectories, at.state, BeaconId(b));
    std::size_t arrivals = 0;
    for (const ArrivalObservation& a : at.trajectories[0].arrivals) arrivals += a.beacon == BeaconId(b);
    EXPECT_EQ(ranges.size(), arrivals);
    // Limits without noise: only rounding to some ms, and along a drive the deviation of the chord of an
    // odometry step of 30 mm from its arc.
    for (const calib::RangeFrom& r : ranges)
      EXPECT_NEAR((r.p_map_m - at.state.beacon_p_map_m[b]).norm(), r.range_m, 1e-9) << b;
  }
}

TEST(RangesTo, ReachTheBeaconFromWhereTheReceiversWere) { expect_true_ranges(quiet(hall_scenario())); }

TEST(RangesTo, LeaveTheWalkByTheAttenuationOut) {
  Scenario s = quiet(hall_scenario());
  add_attenuation(s);
  s.log_amplitude = true;
  expect_true_ranges(s);
}

TEST(RangesTo, TakeTheOffsetOfTheirCycleOut) {
  Scenario s = quiet(hall_scenario());
  s.site.timing.clock = Clock::kCycleOffset;
  s.cycle_offset_s = {0.0, 0.0};
  AtTruth at(s, 1);
  for (ArrivalObservation& a : at.trajectories[0].arrivals) a.tof_s += 0.02;
  for (Node& node : at.trajectories[0].nodes) node.cycle_offset_s = 0.02;
  for (const calib::RangeFrom& r : calib::ranges_to(at.trajectories, at.state, BeaconId(2)))
    EXPECT_NEAR((r.p_map_m - at.state.beacon_p_map_m[2]).norm(), r.range_m, 1e-9);
}

TEST(RangesTo, AreOfPlacedStatesAloneAndOfRejectedArrivalsToo) {
  AtTruth at(quiet(hall_scenario()), 1);
  const std::size_t all = calib::ranges_to(at.trajectories, at.state, BeaconId(2)).size();
  for (ArrivalObservation& a : at.trajectories[0].arrivals) a.rejection = Rejection::kLate;
  EXPECT_EQ(calib::ranges_to(at.trajectories, at.state, BeaconId(2)).size(), all);
  std::size_t of_fourth = 0;
  for (const ArrivalObservation& a : at.trajectories[0].arrivals)
    of_fourth += a.node == 4 && a.beacon == BeaconId(2);
  at.trajectories[0].nodes[4].placed = false;
  EXPECT_EQ(calib::ranges_to(at.trajectories, at.state, BeaconId(2)).size(), all - of_fourth);
}

TEST(PriorRange, IsNotNegative) {
  AtTruth at(quiet(hall_scenario()), 1);
  ArrivalObservation a = at.trajectories[0].arrivals[0];
  a.tof_s = 0.0;
  EXPECT_EQ(calib::prior_range_m(at.trajectories[0], a, at.state), 0.0);
}

/// A hall with bearings to its beacons; only these have noise, a tenth of a milliradian.
Scenario with_bearings() {
  Scenario s = quiet(hall_scenario());
  s.bearings = Scenario::Bearings{};
  s.site.noise.bearing_sigma_rad = 1e-4;
  return s;
}

TEST(RaysTo, PointAtTheBeacon) {
  AtTruth at(with_bearings(), 1);
  const auto rays = calib::rays_to(at.trajectories, BeaconId(3), std::vector<bool>(8, true));
  ASSERT_EQ(rays.size(), 15U);
  const Eigen::Vector2d b = at.state.beacon_p_map_m[3].head<2>();
  for (const calib::RayFrom& ray : rays) {
    const Eigen::Vector2d way = b - ray.p_map_m;
    EXPECT_EQ(ray.sigma_rad, 1e-4);
    EXPECT_LT(std::abs(wrap_angle(std::atan2(way.y(), way.x()) - ray.direction_rad)), 5e-4);  // five sigmas
  }
}

/// Keeps for each stop the bearing to beacon 3 and those selected by `keep`.
template <class Keep>
std::size_t rays_with(Keep&& keep, const std::vector<bool>& known = std::vector<bool>(8, true)) {
  AtTruth at(with_bearings(), 1);
  keep(at.trajectories[0]);
  return calib::rays_to(at.trajectories, BeaconId(3), known).size();
}

void leave_bearings(Trajectory& t, BeaconId also = BeaconId()) {
  for (BearingObservation& b : t.bearings)
    if (b.reflector != BeaconId(3) && b.reflector != also) b.reflector = BeaconId();
}
void leave_arrivals(Trajectory& t, const std::function<bool(const ArrivalObservation&)>& keep) {
  for (Segment& s : t.segments) {
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
      if (!keep(t.arrivals[i])) t.arrivals[i].beacon = BeaconId(3);  // says nothing of a heading to itself
  }
}

TEST(RaysTo, NeedAHeadingThatSomethingElseTells) {
  const auto none = [](const ArrivalObservation&) { return false; };
  EXPECT_EQ(rays_with([&](Trajectory& t) {
              leave_bearings(t);
              leave_arrivals(t, none);
            }),
            0U)
      << "its own bearing alone";
  EXPECT_EQ(rays_with([&](Trajectory& t) {
              leave_bearings(t, BeaconId(6));
              leave_arrivals(t, none);
            }),
            15U)
      << "that of another beacon";
  std::vector<bool> but_six(8, true);
  but_six[6] = false;
  EXPECT_EQ(rays_with(
                [&](Trajectory& t) {
                  leave_bearings(t, BeaconId(6));
                  leave_arrivals(t, none);
                },
                but_six),
            0U)
      << "whose place is unknown";
  EXPECT_GT(rays_with([&](Trajectory& t) { leave_bearings(t); }), 10U) << "two receivers";
  EXPECT_EQ(rays_with([&](Trajectory& t) {
              leave_bearings(t);
              for (ArrivalObservation& a : t.arrivals) a.receiver = ReceiverId(0);
            }),
            0U)
      << "one receiver tells none";
}

TEST(RaysTo, TakeAMeasuredHeadingUnlessItIsVague) {
  for (const double sigma_rad : {0.01, 0.6}) {
    const std::size_t rays = rays_with([&](Trajectory& t) {
      leave_bearings(t);
      leave_arrivals(t, [](const ArrivalObservation&) { return false; });
      t.poses.clear();
      for (Segment& s : t.segments) {
        s.first_pose = t.poses.size();
        t.poses.push_back({.node = s.first_node, .heading_sigma_rad = sigma_rad});
        s.last_pose = t.poses.size();
      }
    });
    EXPECT_EQ(rays, sigma_rad < 0.5 ? 15U : 0U);
  }
}

TEST(TypicalRange, IsTheMedianAndNeverNothing) {
  AtTruth at(quiet(hall_scenario()), 1);
  std::vector<double> ranges;
  const SharedState prior = prior_state(at.problem.site);
  for (const ArrivalObservation& a : at.trajectories[0].arrivals)
    ranges.push_back((a.tof_s - prior.delay_s(a.beacon, a.receiver)) * a.model_speed_mps);
  std::sort(ranges.begin(), ranges.end());
  const double typical = calib::typical_range_m(at.problem.site, at.problem.trajectories);
  EXPECT_NEAR(typical, ranges[ranges.size() / 2], 1e-9);
  EXPECT_EQ(calib::typical_range_m(at.problem), typical);
  EXPECT_EQ(calib::typical_range_m(at.problem.site, {}), 1.0);
  for (ArrivalObservation& a : at.trajectories[0].arrivals) a.tof_s = 0.0;
  EXPECT_EQ(calib::typical_range_m(at.problem.site, at.trajectories), 1e-3);
}

// Cells are half-open, so that each place is in one of them, negative ones too.
TEST(PlaceAt, IsACellOfATwentiethOfTheRange) {
  const double range_m = 10.0;  // cells of half a metre
  const auto cell = [&](double x) { return calib::place_at({x, 0.0, 0.0}, range_m)[0]; };
  EXPECT_EQ(cell(0.0), 0.0);
  EXPECT_EQ(cell(0.499), 0.0);
  EXPECT_EQ(cell(0.5), 1.0);
  EXPECT_EQ(cell(-0.001), -1.0);
  EXPECT_EQ(calib::place_at({1.2, -0.7, 2.6}, range_m), (calib::Place{2.0, -2.0, 5.0}));
}

}  // namespace ranges_test
}  // namespace octant::test
