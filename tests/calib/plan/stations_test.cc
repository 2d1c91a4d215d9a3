// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Stops suggested for a calibration: their information against the adjustment's own, their gain against
// random stops.
#include "calib/plan/stations.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "calib/adjust/information.h"
#include "calib/verdict/observability.h"
#include "models/simulator/random.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace stations_test {

using calib::BeaconKnowledge;
using calib::Knowledge;
using calib::StationCriterion;
using calib::StationOptions;
using calib::StationPlan;

constexpr double kWallMargin_m = 0.7;

/// A grid over the hall, and anywhere between its points.
StationOptions options_for(const Scenario& s, double spacing_m, int headings) {
  StationOptions o;
  o.headings = headings;
  o.spacing_m = spacing_m;
  o.stop.hearing = {.range_m = s.range_m, .half_angle_rad = s.hearing_half_angle_rad};
  for (double x = kWallMargin_m; x < s.hall_m[0] - kWallMargin_m; x += spacing_m)
    for (double y = kWallMargin_m; y < s.hall_m[1] - kWallMargin_m; y += spacing_m)
      o.places_m.emplace_back(x, y);
  o.may_stop = [hall = s.hall_m](const Eigen::Vector2d& p) {
    return p.x() > kWallMargin_m && p.y() > kWallMargin_m && p.x() < hall[0] - kWallMargin_m &&
           p.y() < hall[1] - kWallMargin_m;
  };
  return o;
}

std::vector<Eigen::Vector3d> poses_of(const StationPlan& plan) {
  std::vector<Eigen::Vector3d> poses;
  for (const auto& s : plan.stations) poses.emplace_back(s.position_m.x(), s.position_m.y(), s.heading_rad);
  return poses;
}

std::vector<Eigen::Vector3d> random_stops(const Scenario& s, int count, Random& draws) {
  std::vector<Eigen::Vector3d> stops;
  for (int i = 0; i < count; ++i) {
    const double x = draws.uniform(kWallMargin_m, s.hall_m[0] - kWallMargin_m),
                 y = draws.uniform(kWallMargin_m, s.hall_m[1] - kWallMargin_m);
    stops.emplace_back(x, y, draws.uniform(-M_PI, M_PI));
  }
  return stops;
}

World world_at(Scenario s, const std::vector<Eigen::Vector3d>& stops, std::uint64_t seed) {
  s.path.kind = PathKind::kStations;
  s.path.stations = stops;
  s.path.epochs = static_cast<int>(stops.size());
  return must(simulate(s, seed));
}

/// Mean of the sigmas that a calibration states for the beacons it was asked for.
double stated_mean_m(const calib::Solution& solution, const Site& site) {
  double sum = 0.0;
  std::size_t asked = 0;
  for (std::size_t b = 0; b < site.beacons.size(); ++b) {
    if (site.beacons[b].is_control_point()) continue;
    double variance = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (const int i = solution.covariance.index_of(parameters::beacon_position(b, axis)); i >= 0)
        variance += solution.covariance.matrix(i, i);
    sum += std::sqrt(variance);
    ++asked;
  }
  return sum / static_cast<double>(asked);
}

/// Halls of 12 to 28 m with 6 to 11 beacons scattered along the walls, three of them surveyed, the others
/// known to 0.1 to 0.5 m.
Scenario scattered_hall(std::uint64_t seed) {
  Random draws(seed, 7);
  Scenario s = hall_scenario();
  s.hall_m = {draws.uniform(12, 28), draws.uniform(9, 18)};
  s.site.beacons.clear();
  const int beacons = 6 + static_cast<int>(draws.uniform(0, 6));
  const double sigma_m = draws.uniform(0.1, 0.5), round_m = 2 * (s.hall_m[0] + s.hall_m[1]);
  for (int i = 0; i < beacons; ++i) {
    double along = round_m * (i + draws.uniform(0.0, 0.9)) / beacons;
    const double z = draws.uniform(2.0, 3.5);
    Eigen::Vector3d p(0.05, 0.05, z);
    if (along < s.hall_m[0])
      p.x() = along;
    else if ((along -= s.hall_m[0]) < s.hall_m[1])
      p.head<2>() = Eigen::Vector2d(s.hall_m[0] - 0.05, along);
    else if ((along -= s.hall_m[1]) < s.hall_m[0])
      p.head<2>() = Eigen::Vector2d(s.hall_m[0] - along, s.hall_m[1] - 0.05);
    else
      p.y() = s.hall_m[1] - (along - s.hall_m[0]);
    std::string name = "B";
    name += std::to_string(i);
    s.site.beacons.push_back(
        beacon(name, p, i % (beacons / 3) == 0 && i / (beacons / 3) < 3 ? 0.0 : sigma_m));
  }
  s.range_m = draws.uniform(11, 16);
  return s;
}

/// Sum of the beacons' variances, the measure of StationCriterion::kA.
double variance_m2(const BeaconKnowledge& known) {
  double sum = 0.0;
  for (const double s : known.sigma_m) sum += s * s;
  return sum;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

/// The predicted information of a stop is that which the adjustment finds in its arrivals.
void expect_as_adjusted(Scenario s) {
  s.site.noise.tof_sigma_s =
      1e-10;  // states then settle within 1e-7 of where they are; the rows scale with it on both sides
  for (SiteBeacon& b : s.site.beacons)
    for (auto& sigma : b.sigma_m)
      if (*sigma > 0) sigma = 1e-9;  // and the plan's beacons stand where the world's do
  for (SiteReceiver& r : s.site.receivers) r.sigma_m.setConstant(1e-9);
  s.true_speed_offset_mps = 0.0;
  s.true_delay_s = {s.site.timing.delay_s, s.site.timing.delay_s};
  const Eigen::Vector3d stop(7.3, 4.1, 0.4);
  const World world = world_at(s, {stop}, 3);
  calib::Problem problem = problem_of(world);
  const Knowledge k = must(calib::knowledge_of(world.site));
  std::vector<Trajectory> trajectories = problem.trajectories;
  for (Trajectory& t : trajectories)
    for (Node& n : t.nodes) {
      n.T_map_vehicle = Pose::planar(stop.x(), stop.y(), stop.z());
      n.cycle_offset_s = 0.02;
      n.placed = true;
    }
  const Eigen::MatrixXd adjusted =
      calib::information_at(problem, k.layout, trajectories, k.layout.vector_of(k.state)).data;
  const calib::StopRows rows = calib::stop_rows(k, stop.head<2>(), stop.z(), options_for(s, 2.0, 4).stop);
  ASSERT_EQ(rows.arrival_count, world.run.arrivals.size());
  Eigen::MatrixXd told = Eigen::MatrixXd::Zero(adjusted.rows(), adjusted.cols());
  calib::add_information(rows, told);
  EXPECT_GT(told.norm(), 0.0);
  // The only differences: a microsecond of the time within a cycle, and 1e-7 of the pose.
  EXPECT_LT((told - adjusted).norm(), 1e-5 * adjusted.norm());
}

TEST(Stations, AStopsInformationIsTheAdjustments) { expect_as_adjusted(hall_scenario()); }

TEST(Stations, AStopsInformationIsTheAdjustmentsWithACycleOffset) {
  Scenario s = hall_scenario();
  s.site.timing.clock = Clock::kCycleOffset;
  expect_as_adjusted(s);
}

TEST(Stations, TheFirstStopIsTheBestOfAllByBruteForce) {
  const Scenario s = hall_scenario();
  const Knowledge k = must(calib::knowledge_of(must(simulate(s, 1)).site));
  std::vector<Eigen::Index> columns;
  for (const auto& b : k.layout.beacon)
    for (const int c : b)
      if (c >= 0) columns.push_back(c);
  for (const StationCriterion criterion : {StationCriterion::kA, StationCriterion::kD}) {
    StationOptions o = options_for(s, 3.0, 2);
    o.may_stop = nullptr;
    o.stations = 1;
    o.sweeps = 0;
    o.criterion = criterion;
    const auto value = [&](const calib::StopRows& rows) {
      Eigen::MatrixXd N = k.information;
      calib::add_information(rows, N);
      const Eigen::MatrixXd C = N.inverse()(columns, columns);
      return criterion == StationCriterion::kA ? C.trace() : std::log(C.determinant());
    };
    double best = INFINITY;
    for (const Eigen::Vector2d& p : o.places_m)
      for (int h = 0; h < o.headings; ++h)
        best = std::min(best, value(calib::stop_rows(k, p, M_PI * h, o.stop)));
    const StationPlan plan = must(calib::plan_stations(k, o));
    ASSERT_EQ(plan.stations.size(), 1U);
    const auto& chosen = plan.stations[0];
    const double reached = value(calib::stop_rows(k, chosen.position_m, chosen.heading_rad, o.stop));
    EXPECT_NEAR(reached, best, 1e-9 * std::abs(best))
        << "Woodbury's formula against inverses: rounding alone";
  }
}

TEST(Stations, ExchangesNeverLoseAndThePlanIsTheSameEachTime) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Scenario s = scattered_hall(seed);
    const Knowledge k = must(calib::knowledge_of(must(simulate(s, seed)).site));
    StationOptions o = options_for(s, 2.0, 4);
    const StationPlan plan = must(calib::plan_stations(k, o));
    EXPECT_LE(variance_m2(plan.after), variance_m2(plan.greedy) * (1 + 1e-9));
    double before = variance_m2(plan.before);
    for (const auto& station : plan.stations) {
      EXPECT_LT(variance_m2(station.after), before);
      before = variance_m2(station.after);
      EXPECT_LE(station.improved_to_m, station.improved_from_m);
    }
    for (std::size_t i = 0; i < plan.stations.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GE((plan.stations[i].position_m - plan.stations[j].position_m).norm(), 1.0);
    o.threads = 2;
    const StationPlan again = must(calib::plan_stations(k, o));
    EXPECT_EQ(poses_of(again), poses_of(plan));
    EXPECT_EQ(calib::assess_stations(k, poses_of(plan), o).after.sigma_m, plan.after.sigma_m)
        << "what the plan says of itself";
  }
}

TEST(Stations, ADeploymentKnowsWhatItsCalibrationKnew) {
  Scenario s = hall_scenario();
  s.path.epochs = 20;
  const World world = must(simulate(s, 5));
  const calib::Problem problem = problem_of(world);
  const calib::Solution solution = calib::solve(problem);
  ASSERT_EQ(solution.status, calib::SolveStatus::kConverged) << solution.message;
  const Deployment deployment = calib::make_deployment(problem, solution, {});
  const Knowledge from_run = must(calib::knowledge_of(problem, solution)),
                  from_deployment = must(calib::knowledge_of(deployment));
  const auto a = calib::beacon_knowledge(from_run, from_run.information),
             b = calib::beacon_knowledge(from_deployment, from_deployment.information);
  EXPECT_NEAR(a.mean_m, stated_mean_m(solution, world.site), 1e-9);
  ASSERT_EQ(a.sigma_m.size(), b.sigma_m.size());
  for (std::size_t i = 0; i < a.sigma_m.size(); ++i)
    EXPECT_NEAR(a.sigma_m[i], b.sigma_m[i], 1e-6 * a.mean_m) << i;
  // And the next stops are equal for both.
  const StationOptions o = options_for(s, 3.0, 2);
  const std::vector<Eigen::Vector3d> stops = {{4, 4, 0.1}, {15, 8, 2.0}};
  EXPECT_NEAR(calib::assess_stations(from_run, stops, o).after.mean_m,
              calib::assess_stations(from_deployment, stops, o).after.mean_m, 1e-3 * a.mean_m)
      << "the noise that the calibration found stands in the deployment";
}

TEST(Stations, NextStopsAfterARunBeatRandomOnes) {
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Scenario s = scattered_hall(seed);
    s.path.epochs = 8;
    const World first = must(simulate(s, seed));
    const calib::Problem problem = problem_of(first);
    const auto knowledge = calib::knowledge_of(problem, calib::solve(problem));
    ASSERT_TRUE(knowledge);
    const StationOptions o = options_for(s, 2.0, 4);
    Random draws(seed, 13);
    const StationPlan plan = must(calib::plan_stations(*knowledge, o));
    const StationPlan random = calib::assess_stations(*knowledge, random_stops(s, 5, draws), o);
    EXPECT_LT(variance_m2(plan.after), variance_m2(random.after));
    ratios.push_back(plan.after.mean_m / random.after.mean_m);
  }
  EXPECT_LT(median(ratios), 0.9);
}

TEST(Stations, AFreeNetworkIsPlannedByItsInnerGeometry) {
  Scenario s = hall_scenario();
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {std::nullopt, std::nullopt, std::nullopt};
  const World world = must(simulate(s, 1));
  Site site = world.site;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i)
      site.beacons[b].position_m[i] = world.truth.beacons[b].position_m[static_cast<Eigen::Index>(i)];
  const StationPlan plan =
      must(calib::plan_stations(must(calib::knowledge_of(site)), options_for(s, 3.0, 2)));
  ASSERT_EQ(plan.stations.size(), 5U);
  // The position of the hall is unknown, but the beacons are known relative to each other: to a small part of
  // the extent that represents "unknown".
  EXPECT_LT(plan.after.mean_m, plan.before.mean_m / 20);
}

TEST(Stations, WhatCannotBePlannedIsSaid) {
  const Scenario s = hall_scenario();
  Site site = must(simulate(s, 1)).site;
  StationOptions o = options_for(s, 3.0, 2);
  o.stop.hearing.range_m = 0.5;
  const auto deaf = calib::plan_stations(must(calib::knowledge_of(site)), o);
  ASSERT_FALSE(deaf);
  EXPECT_NE(deaf.error().message().find("receive enough beacons"), std::string::npos);
  site.beacons[4].position_m = {};
  site.beacons[4].sigma_m = {};
  const Knowledge k = must(calib::knowledge_of(site));
  ASSERT_EQ(k.warnings.size(), 1U);
  EXPECT_NE(k.warnings[0].find("B4 has no position"), std::string::npos);
  EXPECT_LT(must(calib::plan_stations(k, options_for(s, 3.0, 2))).after.sigma_m[4], 0.0);
  for (SiteBeacon& b : site.beacons) b.position_m = {};
  EXPECT_FALSE(calib::knowledge_of(site));
  site.receivers.clear();
  EXPECT_FALSE(calib::knowledge_of(site));
  EXPECT_FALSE(calib::knowledge_of(Deployment{}));
}

TEST(Stations, StopsWhenAsked) {
  const Scenario s = hall_scenario();
  StationOptions o = options_for(s, 3.0, 2);
  o.on_progress = [](double fraction) { return fraction < 0.1; };
  const StationPlan plan =
      must(calib::plan_stations(must(calib::knowledge_of(must(simulate(s, 1)).site)), o));
  EXPECT_TRUE(plan.interrupted);
  EXPECT_LT(plan.stations.size(), 5U);
}

/// Five suggested stops compared with five random ones, both simulated and calibrated with realistic priors.
struct Comparison {
  double suggested_m = 0.0, random_m = 0.0, predicted_m = 0.0;
};

Comparison compare(const Scenario& s, std::uint64_t seed) {
  const Site site = must(simulate(s, seed)).site;
  const StationPlan plan =
      must(calib::plan_stations(must(calib::knowledge_of(site)), options_for(s, 2.0, 4)));
  Random draws(seed, 11);
  const World suggested = world_at(s, poses_of(plan), seed),
              random = world_at(s, random_stops(s, 5, draws), seed);
  return {stated_mean_m(solution_of(suggested), site), stated_mean_m(solution_of(random), site),
          plan.after.mean_m};
}

TEST(Stations, FiveSuggestedStopsAgainstFiveRandomOnesInFiftyWorlds) {
  std::vector<double> ratios, faith;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Comparison c = compare(seed % 5 == 0 ? hall_scenario() : scattered_hall(seed), seed);
    ratios.push_back(c.suggested_m / c.random_m);
    faith.push_back(c.suggested_m / c.predicted_m);
  }
  RecordProperty("median_ratio", std::to_string(median(ratios)));
  EXPECT_LE(median(ratios), 0.7);
  // The forecast is made where the priors have the beacons, up to half a metre off: half of them are within a
  // tenth.
  EXPECT_NEAR(median(faith), 1.0, 0.1);
}

}  // namespace stations_test
}  // namespace octant::test
