// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/kleeman/kleeman.h"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/models/localizers/kleeman_room.h"
#include "tests/support/statistics.h"

namespace octant {
namespace kleeman_test {

using test::add_echoes;
using test::anywhere;
using test::error_of;
using test::hear;
using test::Hearing;
using test::kleeman_room;
using test::kPrototypeSigma_s;
using test::kPublished;
using test::locate;

constexpr std::uint64_t kSeed = 1989;

double nees(const Fix& fix, const Pose& truth) {
  const Eigen::Matrix3d C = fix.covariance;
  const Eigen::Vector3d e = error_of(fix, truth);
  return e.dot(C.inverse() * e);
}

/// Everything except noise is solved exactly: heights, lever arms, delays, time-walk, temperature, drift, the
/// cycle's offset.
TEST(Kleeman, IsExactWithoutNoise) {
  std::mt19937_64 random(kSeed);
  for (const bool walk : {false, true}) {
    Deployment d = kleeman_room();
    for (std::size_t b = 0; b < 6; ++b) d.beacons[b].delay_s = 2e-5 * static_cast<double>(b);
    for (std::size_t r = 0; r < 8; ++r) d.receivers[r].delay_s = 1e-6 * static_cast<double>(r);
    for (std::size_t b = 0; b < 6; ++b) d.beacons[b].position_m.z() += 0.1 * static_cast<double>(b);
    if (walk) d.attenuation = AttenuationModel{12.5, 0.12, 0.05, 4.5e-4};
    d.vehicles[0].clock_drift = 5e-5;
    Kleeman kleeman(d);
    for (int k = 0; k < 100; ++k) {
      const Pose truth = anywhere(random);
      std::vector<Arrival> arrivals =
          hear(d, truth, {.range_m = 15.0, .cycle_offset_s = 0.05 - 0.002 * k}, random);
      for (Arrival& a : arrivals) a.tof_s += d.vehicles[0].clock_drift * a.time_s;
      const Fix fix = locate(kleeman, arrivals);
      ASSERT_TRUE(fix.ok()) << k << " " << to_string(fix.status);
      // The passes end when a step is below 10 um and contract by more than ten.
      EXPECT_LT((fix.T_map_vehicle.translation_m - truth.translation_m).norm(), 1e-5) << k;
      EXPECT_LT(std::abs(error_of(fix, truth)[2]), 1e-5) << k;
    }
  }
}

/// The paper's table: standard deviations at three positions, with the same number of samples.
TEST(Kleeman, SpreadIsWithinThePublished) {
  std::mt19937_64 random(kSeed);
  std::cout << "seed " << kSeed << "\n";
  const int samples[3] = {532, 1684, 639};
  for (const double height_m : {0.3, 2.0}) {  // level with the array, and above it
    const Deployment d = kleeman_room(height_m);
    for (std::size_t p = 0; p < 3; ++p) {
      Kleeman kleeman(d);
      const Pose truth = Pose::planar(kPublished[p].x_m, kPublished[p].y_m, 0.4);
      Eigen::Array2d sum = Eigen::Array2d::Zero(), squares = Eigen::Array2d::Zero();
      for (int k = 0; k < samples[p]; ++k) {
        const Fix fix = locate(
            kleeman,
            hear(d, truth, {.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02}, random));
        ASSERT_TRUE(fix.ok()) << to_string(fix.status);
        const Eigen::Array2d e = error_of(fix, truth).head<2>().array();
        sum += e;
        squares += e * e;
      }
      const Eigen::Array2d sigma_m = (squares / samples[p] - (sum / samples[p]).square()).sqrt();
      std::cout << "height " << height_m << " (" << kPublished[p].x_m << ", " << kPublished[p].y_m
                << "): " << 1e3 * sigma_m.x() << ", " << 1e3 * sigma_m.y() << " mm; published "
                << 1e3 * kPublished[p].sigma_x_m << ", " << 1e3 * kPublished[p].sigma_y_m << "\n";
      EXPECT_LE(sigma_m.x(), kPublished[p].sigma_x_m);
      EXPECT_LE(sigma_m.y(), kPublished[p].sigma_y_m);
    }
  }
}

/// Errors against their covariance, from everywhere: the sum is chi-square, three degrees of freedom a fix.
TEST(Kleeman, CovarianceIsConsistent) {
  for (const double height_m : {0.3, 2.0, 3.5}) {
    std::mt19937_64 random(kSeed + 1);
    const Deployment d = kleeman_room(height_m);
    Kleeman kleeman(d);
    double sum = 0.0;
    int count = 0;
    for (int k = 0; k < 1500; ++k) {
      const Pose truth = anywhere(random, 0.5);
      const Fix fix = locate(
          kleeman,
          hear(d, truth, {.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02}, random));
      if (!fix.ok()) continue;
      sum += nees(fix, truth);
      ++count;
    }
    EXPECT_GE(count, 1485);
    // 1e-4 on either side, and 4 % for the curvature of a heading known to 1.4 degrees (the lever arms'
    // cosines) and for the arrivals of a beacon that the gate at 4 sigma leaves out.
    EXPECT_GT(sum, 0.96 * test::chi2_quantile(1e-4, 3.0 * count)) << height_m;
    EXPECT_LT(sum, 1.04 * test::chi2_quantile(1 - 1e-4, 3.0 * count)) << height_m;
  }
}

/// Errors of the calibration that the deployment states are in the covariance: beacons, delays, speed.
TEST(Kleeman, CovarianceHoldsTheCalibrations) {
  std::mt19937_64 random(kSeed + 2);
  std::normal_distribution<double> normal;
  Deployment known = kleeman_room();
  for (DeploymentBeacon& b : known.beacons) {
    b.covariance_m2 = 0.005 * 0.005 * Eigen::Matrix3d::Identity();
    b.delay_sigma_s = 1e-5;
  }
  known.speed_sigma_mps = 0.7;
  double sum = 0.0;
  int count = 0;
  for (int k = 0; k < 500; ++k) {
    Deployment truth = known;
    for (DeploymentBeacon& b : truth.beacons) {
      b.position_m += 0.005 * Eigen::Vector3d(normal(random), normal(random), normal(random));
      b.delay_s += 1e-5 * normal(random);
    }
    truth.speed_offset_mps = 0.7 * normal(random);
    Kleeman kleeman(known);
    const Pose pose = anywhere(random, 0.5);
    const Fix fix = locate(
        kleeman,
        hear(truth, pose, {.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02}, random));
    if (!fix.ok()) continue;
    sum += nees(fix, pose);
    ++count;
  }
  EXPECT_GE(count, 490);
  EXPECT_GT(sum, 0.96 * test::chi2_quantile(1e-4, 3.0 * count));
  EXPECT_LT(sum, 1.04 * test::chi2_quantile(1 - 1e-4, 3.0 * count));
}

/// "Consistently within 50 mm of the physical position over the 10 m square", here with one arrival in ten an
/// echo.
TEST(Kleeman, FixesAreWithin50MillimetresInSpiteOfEchoes) {
  std::mt19937_64 random(kSeed + 3);
  std::cout << "seed " << kSeed + 3 << "\n";
  const Deployment d = kleeman_room();
  Kleeman kleeman(d);
  int fixes = 0, late = 0, outvoted = 0;
  double worst_m = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const Pose truth = anywhere(random, 0.1);
    std::vector<Arrival> arrivals =
        hear(d, truth, {.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02}, random);
    add_echoes(arrivals, 0.1, random);
    const Fix fix = locate(kleeman, arrivals);
    if (!fix.ok()) continue;
    ++fixes;
    worst_m = std::max(worst_m, error_of(fix, truth).head<2>().norm());
    ASSERT_EQ(fix.rejections.size(), arrivals.size());
    for (const Rejection r : fix.rejections) {
      late += r == Rejection::kLate;
      outvoted += r == Rejection::kOutvoted || r == Rejection::kTriangle;
    }
  }
  std::cout << fixes << " of 2000 fixed, worst " << 1e3 * worst_m << " mm\n";
  EXPECT_LT(worst_m, 0.050);
  // One beacon in twenty is in a shadow, and two or more of six leave no majority that could be checked: 96.7
  // % have fewer, less four standard deviations of the count.
  EXPECT_GE(fixes, 1902);
  EXPECT_GT(late, 1000);
  EXPECT_GT(outvoted, 1000);
}

/// Clean data: both methods use the same arrivals, and the average of triples is little worse than least
/// squares.
TEST(Kleeman, AgreesWithLeastSquares) {
  std::mt19937_64 random(kSeed + 7);
  const Deployment d = kleeman_room();
  Kleeman kleeman(d);
  LeastSquaresLocalizer least_squares(d);
  double squares = 0.0, squares_least = 0.0;
  int count = 0;
  for (int k = 0; k < 60; ++k) {
    const Pose truth = anywhere(random, 0.5);
    const auto arrivals =
        hear(d, truth, {.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02}, random);
    const Fix fix = locate(kleeman, arrivals), other = least_squares.locate(arrivals);
    if (!fix.ok() || !other.ok()) continue;
    const Eigen::Vector3d between = error_of(fix, other.T_map_vehicle);
    for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(between[i]), 4 * std::sqrt(fix.covariance(i, i))) << k;
    for (int i = 0; i < 3; ++i)
      EXPECT_GT(fix.covariance(i, i), 0.9 * other.covariance(i, i)) << "better than the bound";
    squares += error_of(fix, truth).head<2>().squaredNorm();
    squares_least += error_of(other, truth).head<2>().squaredNorm();
    ++count;
  }
  EXPECT_GE(count, 58);
  std::cout << "rms over that of least squares: " << std::sqrt(squares / squares_least) << "\n";
  EXPECT_LT(std::sqrt(squares / squares_least), 1.5);
}

TEST(Kleeman, SynchronisedClocksWillDo) {
  std::mt19937_64 random(kSeed);
  Deployment d = kleeman_room();
  d.timing.clock = Clock::kSynchronised;
  Kleeman kleeman(d);
  const Pose truth = Pose::planar(3, 7, 1.0);
  const Fix fix = locate(kleeman, hear(d, truth, {.range_m = 15.0}, random));
  ASSERT_TRUE(fix.ok());
  EXPECT_LT((fix.T_map_vehicle.translation_m - truth.translation_m).norm(), 1e-5);
  EXPECT_EQ(fix.epoch, 0);
}

TEST(Kleeman, OneReceiverOnTheAxisGivesAPlaceWithoutHeading) {
  std::mt19937_64 random(kSeed);
  Deployment d = kleeman_room();
  d.receivers.clear();
  d = test::with_receiver(d, {0, 0, 0.3});
  Kleeman kleeman(d);
  const Pose truth = Pose::planar(3, 7, 1.0);
  const Fix fix = locate(kleeman, hear(d, truth, {.range_m = 15.0, .noise_s = kPrototypeSigma_s}, random));
  ASSERT_TRUE(fix.ok());
  EXPECT_LT((fix.T_map_vehicle.translation_m - truth.translation_m).norm(), 0.02);
  EXPECT_NEAR(std::sqrt(fix.covariance(2, 2)), M_PI, 1e-9);
}

TEST(Kleeman, DegenerateInputHasAReason) {
  std::mt19937_64 random(kSeed);
  const Deployment d = kleeman_room();
  Kleeman kleeman(d);
  const Pose truth = Pose::planar(4, 6, 0.3);
  const auto clean =
      hear(d, truth, {.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02}, random);
  const auto sound = [](const Fix& fix) {
    return fix.T_map_vehicle.translation_m.allFinite() && fix.covariance.allFinite();
  };

  EXPECT_EQ(locate(kleeman, {}).status, FixStatus::kTooFewArrivals);

  std::vector<Arrival> two, no_number = clean, echoes = clean, foreign = clean;
  for (const Arrival& a : clean)
    if (a.beacon.value < 2) two.push_back(a);
  EXPECT_EQ(locate(kleeman, two).status, FixStatus::kTooFewArrivals);

  for (Arrival& a : no_number) a.tof_s = std::nan("");
  EXPECT_EQ(locate(kleeman, no_number).status, FixStatus::kTooFewArrivals);

  const double lateness_s[6] = {9.1e-3, 1.2e-3, 5.0e-3, 15.2e-3, 2.7e-3, 6.9e-3};
  for (Arrival& a : echoes) a.tof_s += lateness_s[a.beacon.index()];
  const Fix echoed = locate(kleeman, echoes);
  EXPECT_EQ(echoed.status, FixStatus::kNoConsensus);
  EXPECT_TRUE(sound(echoed) && echoed.rejections.empty());

  for (Arrival& a : foreign) a.beacon = BeaconId(a.beacon.value + 40);
  EXPECT_EQ(locate(kleeman, foreign).status, FixStatus::kTooFewArrivals);

  Deployment line = d;
  for (std::size_t b = 0; b < 6; ++b) line.beacons[b].position_m = {2.0 * static_cast<double>(b), 0.0, 2.0};
  Kleeman on_line(line);
  const Fix mirrored =
      locate(on_line, hear(line, truth, {.range_m = 15.0, .noise_s = kPrototypeSigma_s}, random));
  EXPECT_EQ(mirrored.status, FixStatus::kAmbiguous);
  EXPECT_TRUE(sound(mirrored));

  Deployment point = d;  // no baseline at all
  for (DeploymentBeacon& b : point.beacons) b.position_m = {5, 5, 2};
  Kleeman on_point(point);
  const Fix nowhere = locate(on_point, hear(point, truth, {.range_m = 15.0}, random));
  EXPECT_EQ(nowhere.status, FixStatus::kPoorGeometry);
  EXPECT_TRUE(sound(nowhere));

  EXPECT_TRUE(locate(kleeman, clean).ok()) << "nothing of this is remembered";
}

TEST(Kleeman, UnusableBeaconsAreLeftOut) {
  std::mt19937_64 random(kSeed);
  Deployment d = kleeman_room();
  const Pose truth = Pose::planar(4, 6, 0.3);
  const auto arrivals = hear(d, truth, {.range_m = 15.0, .cycle_offset_s = 0.02}, random);
  d.beacons[1].status = BeaconStatus::kUndetermined;
  d.beacons[1].position_m.x() += 3.0;
  Kleeman kleeman(d);
  const Fix fix = locate(kleeman, arrivals);
  ASSERT_TRUE(fix.ok());
  EXPECT_LT((fix.T_map_vehicle.translation_m - truth.translation_m).norm(), 1e-5);
  for (std::size_t i = 0; i < arrivals.size(); ++i)
    EXPECT_EQ(fix.rejections[i] == Rejection::kBeaconUnusable, arrivals[i].beacon == BeaconId(1)) << i;
}

TEST(Kleeman, SaysWhatADeploymentLacks) {
  const Deployment good = kleeman_room();
  EXPECT_TRUE(kleeman_fits(good));
  const auto reason = [](Deployment d, auto change) {
    change(d);
    const auto fits = kleeman_fits(d);
    EXPECT_THROW(Kleeman{d}, std::invalid_argument);
    return fits ? std::string("fits") : fits.error().message();
  };
  EXPECT_NE(reason(good, [](Deployment& d) { d.motion = Motion::kSpatial; }).find("planar"),
            std::string::npos);
  EXPECT_NE(reason(good, [](Deployment& d) { d.timing.ranging = Ranging::kTwoWay; }).find("one_way"),
            std::string::npos);
  EXPECT_NE(reason(good, [](Deployment& d) { d.beacons.resize(2); }).find("3 or more"), std::string::npos);
  EXPECT_NE(reason(good, [](Deployment& d) { d.beacons.resize(17, d.beacons[0]); }).find("16"),
            std::string::npos);
  EXPECT_NE(reason(good, [](Deployment& d) { d.receivers.clear(); }).find("receiver"), std::string::npos);
}

TEST(Kleeman, LocateAllocatesNothing) {
  std::mt19937_64 random(kSeed + 8);
  Deployment d = kleeman_room();
  d.attenuation = AttenuationModel{12.5, 0.12, 0.05, 4.5e-4};
  Kleeman kleeman(d);
  std::vector<std::vector<Arrival>> cycles;
  for (int k = 0; k < 50; ++k) {
    cycles.push_back(hear(d, anywhere(random),
                          {.range_m = 15.0, .noise_s = kPrototypeSigma_s, .cycle_offset_s = 0.02}, random));
    add_echoes(cycles.back(), k % 2 == 0 ? 0.0 : 0.5, random);  // some without a fix
  }
  test::expect_no_allocations(kleeman, cycles);
}

/// Near a corner its beacon is steeply above, and directional receivers just receive it: accurate to
/// decimetres. The others determine the position.
TEST(Kleeman, ABeaconThatIsJustHeardDoesNotSpoilTheFix) {
  std::mt19937_64 random(kSeed + 9);
  const Deployment d = test::directional_room();
  Kleeman kleeman(d);
  std::uniform_real_distribution<double> beside(0.4, 0.9), turn(-M_PI, M_PI);
  double squares = 0.0, normalised = 0.0;
  int fixes = 0, rough = 0;
  for (int k = 0; k < 400; ++k) {
    const double x = beside(random), y = beside(random);
    const Pose truth = Pose::planar(x, y, turn(random));
    auto arrivals = hear(d, truth,
                         {.range_m = 15.0,
                          .half_angle_rad = M_PI,
                          .noise_s = kPrototypeSigma_s,
                          .cycle_offset_s = 0.02,
                          .amplitude_sigma = 0.05},
                         random);
    std::erase_if(arrivals, [&](const Arrival& a) { return a.amplitude_v < d.attenuation->threshold_v; });
    const Fix fix = locate(kleeman, arrivals);
    if (!fix.ok()) continue;
    ++fixes;
    const Eigen::Vector2d e = error_of(fix, truth).head<2>();
    squares += e.squaredNorm();
    normalised += e.dot(Eigen::Matrix2d(fix.covariance.topLeftCorner<2, 2>()).ldlt().solve(e)) / 2;
    for (std::size_t i = 0; i < arrivals.size(); ++i)
      rough += arrivals[i].beacon == BeaconId(0) && fix.rejections[i] == Rejection::kNotNeeded;
  }
  const double rms_m = std::sqrt(squares / fixes);
  std::cout << fixes << " fixes beside a corner, rms " << 1e3 * rms_m << " mm, of their variance "
            << normalised / fixes << ", " << rough << " arrivals set aside\n";
  EXPECT_GE(fixes, 390);
  EXPECT_GT(rough, 100);
  EXPECT_LT(rms_m, 0.012);
  EXPECT_NEAR(normalised / fixes, 1.0, 0.2);
}

}  // namespace kleeman_test
}  // namespace octant
