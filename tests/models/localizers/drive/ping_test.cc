// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Arrivals of a ping that are judged jointly, and the curvature of ranges.
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/models/localizers/hall.h"

namespace octant::test {
namespace ping_test {

const Pose kTruth = Pose::planar(7.0, 5.0, 0.6);
constexpr double kSpeed_mps = 343.7, kEchoShare = 0.1;

/// A hall in which one beacon is received by receivers on all sides of a vehicle.
struct PingHall {
  Deployment d;
  EpochFixModel model;
  Trajectory t;

  explicit PingHall(double noise_s = 0.0) : d(hall(1)) {
    for (int r = 0; r < 5; ++r)
      d = with_receiver(d, {0.1 * std::cos(1.2566 * r), 0.1 * std::sin(1.2566 * r), 0.3});
    model = epoch_fix_model(d);
    model.correlated = {};
    std::mt19937_64 random(5);
    set_epoch(t, hear(d, kTruth, {.range_m = 30.0, .noise_s = noise_s}, random), {}, trajectory_model(d));
  }
  /// Arrivals of a ping, late by these lengths.
  [[nodiscard]] std::vector<ArrivalObservation> ping(std::span<const double> late_m) const {
    std::vector<ArrivalObservation> arrivals(t.arrivals.begin(), t.arrivals.end());
    arrivals.resize(late_m.size());
    for (std::size_t i = 0; i < late_m.size(); ++i) arrivals[i].tof_s += late_m[i] / kSpeed_mps;
    return arrivals;
  }
};

/// A filter at the truth that knows its position to 5 cm, as without odometry.
DriveFilter uncertain_filter(const PingHall& hall) {
  DriveFilter filter(hall.model, 4.0, 0.0);
  filter.set_echo_share(kEchoShare);
  filter.start(kTruth, Eigen::Vector3d(2.5e-3, 2.5e-3, 1e-4).asDiagonal());
  return filter;
}

double off_m(const DriveFilter& filter) {
  return (filter.pose().translation_m - kTruth.translation_m).norm();
}

// The first of these echoes alone is within three sigmas of the prediction.
TEST(Ping, OfEchoesAloneMovesNothing) {
  const PingHall hall;
  DriveFilter filter = uncertain_filter(hall);
  constexpr std::array kLate_m = {0.12, 0.31, 0.52, 0.87};
  Rejection last = Rejection::kUsed;
  for (const ArrivalObservation& a : hall.ping(kLate_m)) last = filter.update(hall.t, a);
  EXPECT_EQ(last, Rejection::kLate);
  filter.pass_time(1.0);
  EXPECT_LT(off_m(filter), 0.02);
  EXPECT_GT(filter.covariance()(0, 0), 1.5e-3) << "nothing was learned";
}

TEST(Ping, WithDirectArrivalsAfterAnEchoIsUsed) {
  const PingHall hall;
  DriveFilter filter = uncertain_filter(hall);
  constexpr std::array kLate_m = {0.12, 0.0, 0.0, 0.0};
  std::vector<Rejection> rejections;
  for (const ArrivalObservation& a : hall.ping(kLate_m)) rejections.push_back(filter.update(hall.t, a));
  EXPECT_EQ(rejections.back(), Rejection::kUsed);
  EXPECT_LT(off_m(filter), 0.003) << "one sigma of an arrival's noise";
}

// An echo that is nearer to the prediction than the direct arrivals before and after it.
TEST(Ping, KeepsADirectArrivalThatLooksLessProbableAtFirst) {
  const PingHall hall;
  DriveFilter filter = uncertain_filter(hall);
  const Eigen::Vector3d to = (hall.d.beacons[0].position_m - kTruth.translation_m).normalized();
  Pose off = kTruth;
  off.translation_m -= Eigen::Vector3d(0.06 * to.x(), 0.06 * to.y(), 0.0);  // arrivals are early by 6 cm
  filter.start(off, Eigen::Vector3d(2.5e-3, 2.5e-3, 1e-4).asDiagonal());
  constexpr std::array kLate_m = {0.0, 0.06, 0.0, 0.0};
  for (const ArrivalObservation& a : hall.ping(kLate_m)) static_cast<void>(filter.update(hall.t, a));
  const double along_m = to.head<2>().dot((filter.pose().translation_m - kTruth.translation_m).head<2>());
  EXPECT_LT(std::abs(along_m), 0.006);
}

// A wide state that is corrected by one beacon's ranges alone, which are curved: errors remain within the
// covariance. Without the second-order term the mean is above 100.
TEST(Ping, OfAnUncertainPoseLeavesAnHonestCovariance) {
  const PingHall hall(1e-5);
  const Eigen::Vector3d sigmas(0.35, 0.35, 0.16);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  double nees = 0.0;
  constexpr int kTrials = 200;
  for (int i = 0; i < kTrials; ++i) {
    DriveFilter filter(hall.model, 10.0, 0.0);
    const Eigen::Vector3d off(sigmas[0] * normal(random), sigmas[1] * normal(random),
                              sigmas[2] * normal(random));
    filter.start(retract(kTruth, off, Motion::kPlanar), sigmas.cwiseAbs2().asDiagonal());
    for (const ArrivalObservation& a : hall.t.arrivals) static_cast<void>(filter.update(hall.t, a));
    const Eigen::Vector3d error = tangent_between(kTruth, filter.pose(), Motion::kPlanar);
    nees += error.dot(Eigen::Matrix3d(filter.covariance()).llt().solve(error)) / 3.0 / kTrials;
  }
  EXPECT_LT(nees, 1.5);
}

}  // namespace ping_test
}  // namespace octant::test
