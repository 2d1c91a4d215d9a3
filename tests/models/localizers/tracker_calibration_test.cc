// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Errors that do not average out along a drive: the calibration's, constant ones of a pair, and lasting ones.
#include <cmath>
#include <iostream>
#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/localizers/common/correlated_arrivals.h"
#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/tracker.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/methods.h"
#include "tests/models/localizers/hall.h"
#include "tests/support/statistics.h"

namespace octant {
namespace tracker_calibration_test {

using test::hall;
using test::with_receiver;

constexpr double kStep_s = 0.1, kBeacon_m = 0.03, kSpeed_mps = 0.5;

/// Errors of beacons and speed are in the joint covariance.
Deployment uncertain_hall() {
  Deployment d = with_receiver(hall(), {0.2, 0.0, 0.3});
  JointCovariance& joint = d.covariance;
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    for (std::size_t i = 0; i < 2; ++i) joint.parameters.push_back(parameters::beacon_position(b, i));
  joint.parameters.push_back(parameters::speed());
  joint.matrix = Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(joint.parameters.size()),
                                           static_cast<Eigen::Index>(joint.parameters.size())) *
                 kBeacon_m * kBeacon_m;
  joint.matrix.bottomRightCorner<1, 1>()(0, 0) = kSpeed_mps * kSpeed_mps;
  return d;
}

/// One of the halls that the covariance allows.
Deployment drawn(Deployment d, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  for (DeploymentBeacon& b : d.beacons)
    b.position_m += kBeacon_m * Eigen::Vector3d(normal(random), normal(random), 0.0);
  d.speed_offset_mps += kSpeed_mps * normal(random);
  return d;
}

struct Noise3 {
  double white_s = 1e-5, correlated_s = 0.0, time_s = 0.0, pair_s = 0.0;
};

/// A winding drive, a beacon every 0.1 s; or stops every 0.1 s of it, each hearing one beacon.
MeasurementLog drive(const Deployment& world, double seconds, const Noise3& noise, bool stops,
                     std::mt19937_64& random, std::vector<Pose>& truth) {
  std::normal_distribution<double> normal;
  MeasurementLog log;
  log.vehicle = VehicleId(0);
  log.has_epochs = stops;
  log.odometry_accuracy = {.distance_sigma_m_per_sqrt_m = 0.02,
                           .heading_sigma_rad_per_sqrt_m = 0.01,
                           .heading_sigma_per_rad = 0.0,
                           .floor_m = 1e-4,
                           .floor_rad = 1e-4};
  std::map<std::size_t, std::pair<double, double>> lasting;  // of a pair: Gauss-Markov part, bias
  for (int k = 0; k * kStep_s <= seconds; ++k) {
    const double t = k * kStep_s;
    const Pose T =
        Pose::planar(10 + 6.5 * std::sin(0.09 * t + 0.3), 6 + 3.5 * std::sin(0.131 * t),
                     std::atan2(3.5 * 0.131 * std::cos(0.131 * t), 6.5 * 0.09 * std::cos(0.09 * t + 0.3)));
    OdometryStep step{t, 0, 0, 0, VehicleId(0)};
    if (k > 0) {
      const Pose rel = truth.back().inverse() * T;
      const double s = std::sqrt(rel.translation_m.norm());
      step = {t, rel.translation_m.x() + 0.02 * s * normal(random),
              rel.translation_m.y() + 0.02 * s * normal(random),
              rel.heading_rad() + 0.01 * s * normal(random), VehicleId(0)};
    }
    log.odometry.push_back(step);
    truth.push_back(T);
    Deployment one = world;
    const std::size_t b = static_cast<std::size_t>(k) % world.beacons.size();
    one.beacons = {world.beacons[b]};
    for (Arrival a : test::hear(one, T, {.noise_s = noise.white_s}, random, stops ? k : kNoEpoch, t)) {
      const auto [at, added] =
          lasting.try_emplace(b, noise.correlated_s * normal(random), noise.pair_s * normal(random));
      if (!added && noise.time_s > 0) {
        const double rho = std::exp(-static_cast<double>(world.beacons.size()) * kStep_s / noise.time_s);
        at->second.first =
            rho * at->second.first + std::sqrt(1 - rho * rho) * noise.correlated_s * normal(random);
      }
      a.beacon = BeaconId(b);
      a.tof_s += at->second.first + at->second.second;
      log.arrivals.push_back(a);
    }
  }
  return log;
}

struct Nees {
  double mean = 0.0, rmse_m = 0.0;
  std::size_t fixes = 0, ok = 0;
};

/// Over fixes in the middle and at the end of drives through halls that differ.
Nees nees(const Deployment& d, const Noise3& noise, const TrackerOptions& options, bool stops, int drives,
          std::uint64_t seed) {
  std::cout << "seed " << seed << "\n";
  std::mt19937_64 random(seed);
  Nees out;
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (int i = 0; i < drives; ++i) {
    std::vector<Pose> truth;
    const MeasurementLog log =
        drive(d.covariance.matrix.rows() > 0 ? drawn(d, random) : d, 30.0, noise, stops, random, truth);
    const std::vector<Fix> fixes = track(log, d, options);
    out.fixes += fixes.size();
    for (const Fix& fix : fixes) out.ok += fix.ok();
    for (const std::size_t at : {fixes.size() / 2, fixes.size() - 20}) {
      const Fix& fix = fixes[at];
      if (!fix.ok()) continue;
      const Pose& T = truth[static_cast<std::size_t>(std::lround(fix.time_s / kStep_s))];
      const Eigen::Vector2d e = (fix.T_map_vehicle.translation_m - T.translation_m).head<2>();
      sum += e.dot(Eigen::Matrix2d(fix.covariance.topLeftCorner<2, 2>()).llt().solve(e));
      squares += e.squaredNorm();
      ++count;
    }
  }
  out.mean = sum / (2.0 * count);
  out.rmse_m = std::sqrt(squares / count);
  std::cout << "NEES " << out.mean << ", RMSE " << out.rmse_m << " m\n";
  return out;
}

/// Fixes of one drive share its hall, so that two fixes of each of n drives count as n to 2 n independent
/// ones: bounds of n.
void expect_honest(const Nees& found, int drives, double uncertainty) {
  EXPECT_LT(found.mean, uncertainty * test::chi2_quantile(0.9995, 2.0 * drives) / (2.0 * drives));
  EXPECT_GT(found.mean, test::chi2_quantile(0.0005, 2.0 * drives) / (2.0 * drives) / uncertainty);
}

TEST(TrackerCalibration, SmoothedFixesStateTheCalibrationsShare) {
  constexpr int kDrives = 30;
  expect_honest(nees(uncertain_hall(), {}, {}, false, kDrives, 71), kDrives, 1.0);
}

TEST(TrackerCalibration, TheFilterConsidersTheCalibration) {
  constexpr int kDrives = 30;
  // A filter linearises where it is: a tenth.
  expect_honest(nees(uncertain_hall(), {}, {.smooth = false}, false, kDrives, 72), kDrives, 1.1);
}

TEST(TrackerCalibration, ErrorsThatLastAreNotAveragedAway) {
  constexpr int kDrives = 30;
  Deployment d = with_receiver(hall(), {0.2, 0.0, 0.3});
  const Noise3 noise{.white_s = 1e-5, .correlated_s = 5e-5, .time_s = 3.0, .pair_s = 5e-5};
  d.correlated_noise = {noise.correlated_s, noise.time_s, noise.pair_s};
  // Where the correlation lasts about as long as the odometry is remembered, weights by number are an
  // approximation: by half.
  expect_honest(nees(d, noise, {}, false, kDrives, 73), kDrives, 1.5);
  expect_honest(nees(d, noise, {.smooth = false}, false, kDrives, 74), kDrives, 1.5);
  Deployment white = d;
  white.correlated_noise = {};
  white.noise.tof_sigma_s = std::hypot(noise.white_s, noise.correlated_s, noise.pair_s);
  EXPECT_GT(nees(white, noise, {}, false, kDrives, 73).mean, 2.0) << "else the test tells nothing";
}

TEST(TrackerCalibration, StopsWithOdometryBetweenThemAreTracked) {
  const Deployment d = with_receiver(hall(), {0.2, 0.0, 0.3});
  std::mt19937_64 random(75);
  std::vector<Pose> truth;
  const MeasurementLog log = drive(d, 30.0, {}, true, random, truth);
  EXPECT_EQ(choose_method(d, log).method, Method::kTracker);
  const auto fixes = locate_run(Method::kAuto, d, log);
  ASSERT_TRUE(fixes.has_value());
  ASSERT_FALSE(fixes->empty());
  for (const Fix& fix : *fixes) {
    ASSERT_TRUE(fix.ok());
    EXPECT_NE(fix.epoch, kNoEpoch);
    const Pose& T = truth[static_cast<std::size_t>(fix.epoch)];
    EXPECT_LT((fix.T_map_vehicle.translation_m - T.translation_m).norm(), 0.05);
  }
  // One beacon in each epoch: a single epoch is not sufficient for a fix.
  const auto alone = locate_run(Method::kLeastSquares, d, log);
  ASSERT_TRUE(alone.has_value());
  for (const Fix& fix : *alone) EXPECT_FALSE(fix.ok());
}

TEST(CorrelatedArrivals, TheMeanOfAPairIsNoBetterThanWhatItShares) {
  Trajectory t;
  t.nodes.resize(1);
  const CorrelatedNoise noise{.sigma_s = 3e-5, .time_s = 2.0, .pair_sigma_s = 2e-5};
  const double single_s = std::hypot(1e-5, noise.sigma_s, noise.pair_sigma_s);
  constexpr int kArrivals = 5;
  for (int i = 0; i < kArrivals; ++i) {
    ArrivalObservation a;
    a.beacon = BeaconId(0);
    a.receiver = ReceiverId(0);
    a.time_s = 0.5 * i;
    a.sigma_s = single_s;
    t.arrivals.push_back(a);
  }
  t.arrivals.push_back(t.arrivals.front());
  t.arrivals.back().beacon = BeaconId(1);
  Segment all;
  all.last_node = 1;
  all.last_arrival = t.arrivals.size();
  CorrelatedArrivals sigmas(t, all, noise, CorrelatedArrivals::Side::kSame);
  sigmas.weigh();
  double sum = 0.0;  // of the covariance of the five errors
  for (int i = 0; i < kArrivals; ++i)
    for (int j = 0; j < kArrivals; ++j)
      sum += (i == j ? 1e-10 : 0.0) + 9e-10 * std::exp(-0.5 * std::abs(i - j) / noise.time_s) + 4e-10;
  double information = 0.0;
  for (int i = 0; i < kArrivals; ++i)
    information += std::pow(t.arrivals[static_cast<std::size_t>(i)].sigma_s, -2);
  EXPECT_NEAR(1 / information, sum / (kArrivals * kArrivals), 1e-9 * sum);
  EXPECT_DOUBLE_EQ(t.arrivals.back().sigma_s, single_s) << "another pair has another error";
  sigmas.restore();
  EXPECT_EQ(t.arrivals.front().sigma_s, single_s);
}

/// Three ranges agree, and the heading matches one of three bearings: a mirror image, no fix.
TEST(LeastSquares, MostBearingsAgainstAPoseAreNoFix) {
  Deployment d = with_receiver(hall(4), {0.0, 0.0, 0.3});
  std::mt19937_64 random(76);
  const Pose T = Pose::planar(8, 5, 0.4);
  std::vector<Arrival> arrivals = test::hear(d, T, {.range_m = 50.0}, random);
  std::vector<Bearing> bearings;
  for (const Arrival& a : arrivals) {
    const Eigen::Vector3d to = T.inverse() * d.beacons[a.beacon.index()].position_m;
    const double wrong = 0.7 * static_cast<double>(bearings.size());
    bearings.push_back(
        {a.time_s, wrap_angle(std::atan2(to.y(), to.x()) + wrong), a.beacon, VehicleId(0), 0, 0});
  }
  LeastSquaresLocalizer localizer(d);
  EXPECT_EQ(localizer.locate(Observations{arrivals, bearings}).status, FixStatus::kNoConsensus);
  for (std::size_t i = 0; i < bearings.size(); ++i)
    bearings[i].bearing_rad = wrap_angle(bearings[i].bearing_rad - 0.7 * static_cast<double>(i));
  EXPECT_TRUE(localizer.locate(Observations{arrivals, bearings}).ok());
}

}  // namespace tracker_calibration_test
}  // namespace octant
