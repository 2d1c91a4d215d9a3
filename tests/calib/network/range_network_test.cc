// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Beacons of a warehouse from ranges to their neighbours alone.
#include "calib/network/range_network.h"

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "calib/network/place_by_ranges.h"
#include "calib/network/survey_row.h"
#include "models/simulator/random.h"

namespace octant::test {
namespace range_network_test {

constexpr double kSpeed_mps = 299792458.0, kNoise_m = 0.05, kReach_m = 26.0;

struct Warehouse {
  Site site;
  std::vector<Eigen::Vector3d> truth;
  BeaconRanges ranges;
};

/// Ten rows of ten beacons in a hall of 90 m x 45 m, heights known to 1 cm, four control points, 5 % echoes.
Warehouse warehouse(std::uint64_t seed, double echoes, double delay_m) {
  Random draws(seed);
  Warehouse w;
  w.site.medium.speed_mps = kSpeed_mps;
  w.site.noise.tof_sigma_s = kNoise_m / kSpeed_mps;
  w.site.timing.delay_per = {};
  std::vector<double> delays;
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) {
      w.truth.emplace_back(10.0 * i + draws.normal(), 5.0 * j + draws.normal(), 6.0 + draws.normal());
      SiteBeacon beacon;
      beacon.name = std::to_string(10 * i + j);
      const bool control = (i == 0 || i == 9) && (j == 0 || j == 9);
      for (int k = 0; k < 3; ++k)
        if (control || k == 2) {
          beacon.position_m[static_cast<std::size_t>(k)] = w.truth.back()[k] + 0.01 * draws.normal();
          beacon.sigma_m[static_cast<std::size_t>(k)] = 0.01;
        }
      w.site.beacons.push_back(beacon);
      delays.push_back(delay_m * draws.normal());
    }
  std::vector<BeaconFlight> flights;
  for (std::size_t a = 0; a < w.truth.size(); ++a)
    for (std::size_t b = a + 1; b < w.truth.size(); ++b) {
      const double length_m = (w.truth[a] - w.truth[b]).norm();
      if (length_m > kReach_m) continue;
      const double echo_m = draws.uniform(0.0, 1.0) < echoes ? draws.uniform(1.0, 10.0) : 0.0;
      flights.push_back(
          {0.0, BeaconId(a), BeaconId(b),
           (length_m + delays[a] + delays[b] + echo_m + kNoise_m * draws.normal()) / kSpeed_mps});
    }
  w.ranges = beacon_ranges(w.site, flights);
  return w;
}

/// Mean over the free coordinates of the squared error in sigmas (by the joint covariance).
double nees(const Warehouse& w, const calib::SolvedNetwork& solved) {
  const calib::NetworkColumns columns = calib::network_columns(solved.network);
  Eigen::VectorXd error = Eigen::VectorXd::Zero(columns.first_set);
  for (std::size_t p = 0; p < w.truth.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i)
      if (const int c = columns.point[p][i]; c >= 0)
        error[c] = (solved.solution.points_m[p] - w.truth[p])[static_cast<int>(i)];
  const Eigen::MatrixXd covariance =
      solved.solution.covariance.topLeftCorner(columns.first_set, columns.first_set);
  return error.dot(covariance.ldlt().solve(error)) / static_cast<double>(error.size());
}

TEST(RangeNetwork, FindsAWarehouseAmongEchoes) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const Warehouse w = warehouse(seed, 0.05, 0.0);
    const auto result = calib::solve_range_network(w.site, w.ranges);
    ASSERT_TRUE(result);
    ASSERT_EQ(result->solved.solution.status, calib::NetworkStatus::kConverged);
    EXPECT_FALSE(result->mirror_is_equal);
    EXPECT_GT(result->solved.outlying.size(), w.ranges.pairs.size() / 40);
    EXPECT_GT(nees(w, result->solved), 0.7);
    EXPECT_LT(nees(w, result->solved), 1.4);
  }
}

TEST(RangeNetwork, EstimatesTheDelaysOfTheBeacons) {
  Warehouse w = warehouse(4, 0.05, 0.5);
  w.site.timing.delay_per.beacon = true;
  w.site.timing.delay_sigma_s = 0.5 / kSpeed_mps;
  const auto result = calib::solve_range_network(w.site, w.ranges);
  ASSERT_TRUE(result);
  ASSERT_EQ(result->solved.solution.status, calib::NetworkStatus::kConverged);
  EXPECT_GT(nees(w, result->solved), 0.7);
  EXPECT_LT(nees(w, result->solved), 1.4);
}

TEST(RangeNetwork, SaysThatAMirrorImageIsEqual) {
  Warehouse w = warehouse(5, 0.0, 0.0);
  for (SiteBeacon& beacon : w.site.beacons)
    for (std::size_t i = 0; i < 2; ++i) beacon.position_m[i] = beacon.sigma_m[i] = std::nullopt;
  const auto result = calib::solve_range_network(w.site, w.ranges);
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->mirror_is_equal);
  ASSERT_EQ(result->solved.solution.status, calib::NetworkStatus::kConverged);
  EXPECT_EQ(result->solved.solution.defect, 3);
  Eigen::MatrixXd found(2, 100), truth(2, 100);
  for (Eigen::Index p = 0; p < 100; ++p) {
    found.col(p) = result->solved.solution.points_m[static_cast<std::size_t>(p)].head<2>();
    truth.col(p) = w.truth[static_cast<std::size_t>(p)].head<2>();
  }
  const double rms_m =
      std::min(calib::fit_rigidly(found, truth, false).rms_m, calib::fit_rigidly(found, truth, true).rms_m);
  EXPECT_LT(rms_m, 0.05);
}

/// Thirty beacons in space of which the site knows nothing, with delays and echoes.
TEST(RangeNetwork, FindsTheShapeInSpaceWithoutAnyPosition) {
  Random draws(6);
  Warehouse w;
  w.site.medium.speed_mps = kSpeed_mps;
  w.site.noise.tof_sigma_s = kNoise_m / kSpeed_mps;
  w.site.timing.delay_per.beacon = true;
  w.site.timing.delay_sigma_s = 0.3 / kSpeed_mps;
  std::vector<double> delays;
  for (int b = 0; b < 30; ++b) {
    w.truth.emplace_back(draws.uniform(0.0, 30.0), draws.uniform(0.0, 20.0), draws.uniform(0.0, 8.0));
    w.site.beacons.emplace_back().name = std::to_string(b);
    delays.push_back(0.3 * draws.normal());
  }
  std::vector<BeaconFlight> flights;
  for (std::size_t a = 0; a < w.truth.size(); ++a)
    for (std::size_t b = a + 1; b < w.truth.size(); ++b) {
      const double length_m = (w.truth[a] - w.truth[b]).norm();
      if (length_m > 18.0) continue;
      const double echo_m = draws.uniform(0.0, 1.0) < 0.05 ? draws.uniform(1.0, 10.0) : 0.0;
      flights.push_back(
          {0.0, BeaconId(a), BeaconId(b),
           (length_m + delays[a] + delays[b] + echo_m + kNoise_m * draws.normal()) / kSpeed_mps});
    }
  const auto result = calib::solve_range_network(w.site, beacon_ranges(w.site, flights));
  ASSERT_TRUE(result);
  ASSERT_EQ(result->solved.solution.status, calib::NetworkStatus::kConverged);
  EXPECT_TRUE(result->mirror_is_equal);
  EXPECT_EQ(result->solved.solution.defect, 6);
  for (std::size_t a = 0; a < w.truth.size(); ++a)
    for (std::size_t b = a + 1; b < w.truth.size(); ++b)
      EXPECT_NEAR((result->solved.solution.points_m[a] - result->solved.solution.points_m[b]).norm(),
                  (w.truth[a] - w.truth[b]).norm(), 0.6);
}

/// All ranges between beacons at random places, with heights that are given exactly or (in space) not.
Warehouse cloud(std::uint64_t seed, int beacons, bool plane, double noise_m) {
  Random draws(seed);
  Warehouse w;
  w.site.medium.speed_mps = kSpeed_mps;
  w.site.noise.tof_sigma_s = noise_m / kSpeed_mps;
  w.site.timing.delay_per = {};
  for (int b = 0; b < beacons; ++b) {
    w.truth.emplace_back(draws.uniform(0.0, 20.0), draws.uniform(0.0, 12.0), draws.uniform(0.0, 6.0));
    SiteBeacon& beacon = w.site.beacons.emplace_back();
    beacon.name = std::to_string(b);
    for (int k = 0; k < 3; ++k)
      if (plane && (b < 3 || k == 2)) {
        beacon.position_m[static_cast<std::size_t>(k)] = w.truth.back()[k];
        beacon.sigma_m[static_cast<std::size_t>(k)] = 0.0;
      }
  }
  return w;
}

BeaconRanges all_ranges(const Warehouse& w, std::uint64_t seed, double noise_m,
                        const std::function<double(int, int)>& longer_m) {
  Random draws(seed);
  std::vector<BeaconFlight> flights;
  for (std::size_t a = 0; a < w.truth.size(); ++a)
    for (std::size_t b = a + 1; b < w.truth.size(); ++b) {
      const double off_m = longer_m(static_cast<int>(a), static_cast<int>(b)) + noise_m * draws.normal();
      if (std::isfinite(off_m))
        flights.push_back(
            {0.0, BeaconId(a), BeaconId(b), ((w.truth[a] - w.truth[b]).norm() + off_m) / kSpeed_mps});
    }
  return beacon_ranges(w.site, flights);
}

TEST(RangeNetwork, RejectsNoGoodRangeOfASmallNetwork) {
  int unsolved = 0;
  for (const bool plane : {true, false})
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      const Warehouse w = cloud(seed, 5 + static_cast<int>(seed % 5), plane, 0.03);
      const auto result =
          calib::solve_range_network(w.site, all_ranges(w, 100 + seed, 0.03, [](int, int) { return 0.0; }));
      ASSERT_TRUE(result);
      const bool converged = result->solved.solution.status == calib::NetworkStatus::kConverged;
      unsolved += !converged;
      EXPECT_TRUE(converged || !plane) << seed;
      EXPECT_TRUE(result->solved.outlying.empty()) << plane << ' ' << seed;
      EXPECT_TRUE(result->solved.undetermined.empty()) << plane << ' ' << seed;
    }
  EXPECT_LE(unsolved, 1);  // five beacons in space with a single redundant range
}

TEST(RangeNetwork, LeavesOutABeaconWhoseSideIsUnknown) {
  for (const double echo_m : {std::nan(""), 3.0}) {  // two ranges, or a third one that is an echo
    Warehouse w = cloud(3, 8, true, 0.02);
    w.truth = {{0, 0, 3},  {20, 0, 3},  {20, 12, 4}, {0, 12, 3},
               {10, 5, 4}, {10, -1, 3}, {5, 13, 4},  {21, 6, 3}};
    for (std::size_t b = 0; b < 8; ++b)
      for (std::size_t i = 0; i < 3; ++i)
        if (w.site.beacons[b].position_m[i])
          w.site.beacons[b].position_m[i] = w.truth[b][static_cast<int>(i)];
    const auto result = calib::solve_range_network(w.site, all_ranges(w, 5, 0.02, [&](int a, int b) {
                                                     if (b != 7 || a < 2) return 0.0;
                                                     return a == 4 ? echo_m : std::nan("");
                                                   }));
    ASSERT_TRUE(result);
    EXPECT_EQ(result->ambiguous, std::vector<std::string>{"7"}) << echo_m;
    ASSERT_EQ(result->solved.solution.status, calib::NetworkStatus::kConverged);
    for (std::size_t p = 0; p < 7; ++p)
      EXPECT_LT((result->solved.solution.points_m[p] - w.truth[p]).norm(), 0.1) << p;
  }
}

/// Four beacons, three of them fixed, and an echo among the three ranges of the fourth.
TEST(RangeNetwork, KeepsABeaconThatARejectionWouldLeaveUndetermined) {
  const Warehouse w = cloud(8, 4, true, 0.01);
  const auto result = calib::solve_range_network(
      w.site, all_ranges(w, 9, 0.01, [](int a, int b) { return a == 0 && b == 3 ? 2.0 : 0.0; }));
  ASSERT_TRUE(result);
  EXPECT_LE(result->solved.outlying.size(), 1U);
  const bool found = (result->solved.solution.points_m[3] - w.truth[3]).norm() < 0.1;
  EXPECT_TRUE(found || result->ambiguous == std::vector<std::string>{"3"} ||
              !result->solved.undetermined.empty());
}

/// Any of three ranges that contradict each other may be the echo.
TEST(RangeNetwork, LeavesOutABeaconIfItIsUnknownWhichRangeIsWrong) {
  for (const int neighbour : {0, 1, 2}) {
    const Warehouse w = cloud(11, 8, true, 0.02);
    const auto result = calib::solve_range_network(w.site, all_ranges(w, 12, 0.02, [neighbour](int a, int b) {
                                                     if (b != 7) return 0.0;
                                                     return a > 2 ? std::nan("") : a == neighbour ? 2.0 : 0.0;
                                                   }));
    ASSERT_TRUE(result);
    EXPECT_EQ(result->ambiguous, std::vector<std::string>{"7"}) << neighbour;
    ASSERT_EQ(result->solved.solution.status, calib::NetworkStatus::kConverged);
    for (std::size_t p = 0; p < 7; ++p)
      EXPECT_LT((result->solved.solution.points_m[p] - w.truth[p]).norm(), 0.1) << p;
  }
}

}  // namespace range_network_test
}  // namespace octant::test
