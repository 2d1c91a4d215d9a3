// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/space/space_track.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/localizers/common/separation.h"
#include "models/localizers/methods.h"
#include "models/simulator/random.h"

namespace octant {
namespace space_track_test {

constexpr double kSpeed_mps = 340.0, kSigma_m = 0.03;

Deployment deployment_of(const std::vector<Eigen::Vector3d>& beacons, const Eigen::Vector3d& lever_m) {
  Deployment d;
  d.motion = Motion::kSpatial;
  d.medium.model = MediumModel::kConstant;
  d.medium.speed_mps = kSpeed_mps;
  d.timing.clock = Clock::kSynchronised;
  d.noise.tof_sigma_s = kSigma_m / kSpeed_mps;
  for (const Eigen::Vector3d& p : beacons) {
    DeploymentBeacon b;
    b.name = "B" + std::to_string(d.beacons.size());
    b.position_m = p;
    d.beacons.push_back(b);
  }
  SiteVehicle vehicle;
  vehicle.receiver_count = 1;
  d.vehicles.push_back(vehicle);
  DeploymentReceiver receiver;
  receiver.name = "r0";
  receiver.vehicle = VehicleId(0);
  receiver.position_m = lever_m;
  d.receivers.push_back(receiver);
  return d;
}

/// Joint covariance of beacons.
void know_beacons_to(double sigma_m, Deployment& d) {
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i) d.covariance.parameters.push_back(parameters::beacon_position(b, i));
  const auto n = static_cast<Eigen::Index>(d.covariance.parameters.size());
  d.covariance.matrix = sigma_m * sigma_m * Eigen::MatrixXd::Identity(n, n);
}

const Eigen::Vector3d kNoLever = Eigen::Vector3d::Zero();
const std::vector<Eigen::Vector3d> kHall = {{0, 0, 0.3}, {10, 0, 4.0}, {10, 8, 0.5},
                                            {0, 8, 4.2}, {5, -1, 3.0}, {5, 9, 1.0}};

struct Flight {
  MeasurementLog log;
  std::vector<Pose> truth;  ///< at the instants
};

/// Through the hall on a smooth curve, turning about all axes; all beacons answer ten times a second.
/// @param beacons  where they are in truth
Flight fly(const std::vector<Eigen::Vector3d>& beacons, const Eigen::Vector3d& lever_m, double echoes,
           int instants, double height_m, Random& random) {
  Flight f;
  for (int k = 0; k < instants; ++k) {
    const double t = 0.1 * k;
    Pose T;
    T.translation_m = {5 + 3 * std::sin(0.4 * t), 4 + 2.5 * std::sin(0.27 * t + 1),
                       height_m + 0.4 * std::sin(0.5 * t)};
    T.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.9 * t, Eigen::Vector3d(0.3, 0.5, 1).normalized()));
    f.truth.push_back(T);
    const Eigen::Vector3d p = T.translation_m + T.rotation * lever_m;
    for (std::size_t b = 0; b < beacons.size(); ++b) {
      double range = (p - beacons[b]).norm() + kSigma_m * random.normal();
      if (random.uniform() < echoes) range += 0.3 + 3 * random.uniform();
      Arrival a;
      a.time_s = t + 1e-4 * static_cast<double>(b);
      a.tof_s = range / kSpeed_mps;
      a.beacon = BeaconId(b);
      a.receiver = ReceiverId(0);
      a.vehicle = VehicleId(0);
      f.log.arrivals.push_back(a);
    }
  }
  return f;
}

struct Errors {
  double rmse_m = 0.0, nees = 0.0, velocity_nees = 0.0;
  std::size_t count = 0;
};

Errors errors_of(const std::vector<Fix>& fixes, const Flight& f, const Eigen::Vector3d& lever_m) {
  Errors e;
  EXPECT_EQ(fixes.size(), f.truth.size());
  for (std::size_t k = 5; k < std::min(fixes.size(), f.truth.size()); ++k) {
    if (!fixes[k].ok()) continue;
    // With one antenna the place meant is the antenna's, and the origin's as far as the lever arm leaves it.
    const Eigen::Vector3d truth =
        f.truth[k].translation_m +
        (lever_m.norm() > 0.05 ? Eigen::Vector3d(0, 0, 0) : f.truth[k].rotation * lever_m);
    const Eigen::Vector3d off = fixes[k].T_map_vehicle.translation_m - truth;
    e.rmse_m += off.squaredNorm();
    e.nees += off.dot(Eigen::Matrix3d(fixes[k].covariance.topLeftCorner<3, 3>()).ldlt().solve(off)) / 3;
    ++e.count;
    if (!fixes[k].velocity || k + 1 == f.truth.size()) continue;
    const Eigen::Vector3d v_mps = (f.truth[k + 1].translation_m - f.truth[k - 1].translation_m) / 0.2,
                          off2 = (fixes[k].velocity->mean.head<3>() - v_mps).cwiseAbs2();
    e.velocity_nees += off2.cwiseQuotient(fixes[k].velocity->variance.head<3>()).mean();
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, e.count));
  e.rmse_m = std::sqrt(e.rmse_m / count), e.nees /= count, e.velocity_nees /= count;
  return e;
}

/// The pooled NEES of twelve flights with twenty independent segments each scatters by less than a tenth.
TEST(SpaceTrack, FixesAreAsGoodAsTheySay) {
  double nees = 0.0, of_velocity = 0.0, worst_m = 0.0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed, 1);
    const Flight f = fly(kHall, kNoLever, 0.0, 300, 1.5, random);
    const Errors e = errors_of(track_in_space(f.log, deployment_of(kHall, kNoLever)), f, kNoLever);
    EXPECT_GE(e.count, 290u);
    nees += e.nees / 12;
    of_velocity += e.velocity_nees / 12;
    worst_m = std::max(worst_m, e.rmse_m);
  }
  EXPECT_LT(worst_m, 2 * kSigma_m) << "six ranges an instant and a smooth track";
  EXPECT_GT(nees, 0.7);
  EXPECT_LT(nees, 1.3);
  EXPECT_NEAR(of_velocity, 0.6, 0.5) << "smoother than white acceleration";
}

TEST(SpaceTrack, EchoesAreLeftOut) {
  Random random(3, 1);
  const Flight f = fly(kHall, kNoLever, 0.1, 400, 1.5, random);
  const auto fixes = track_in_space(f.log, deployment_of(kHall, kNoLever));
  const Errors e = errors_of(fixes, f, kNoLever);
  EXPECT_GE(e.count, 390u);
  EXPECT_LT(e.rmse_m, 2.5 * kSigma_m);
  int rejected = 0;
  for (const Fix& fix : fixes) rejected += fix.arrivals_rejected;
  EXPECT_GT(rejected, 180) << "one in ten of 2,400";
  EXPECT_LT(rejected, 320);
}

/// Beacon errors with the joint covariance: the errors of a flight do not average out, and the covariance
/// contains them.
TEST(SpaceTrack, TheCalibrationsPartCounts) {
  double nees = 0.0, without = 0.0;
  constexpr int kFlights = 20;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
    Random random(seed, 2);
    std::vector<Eigen::Vector3d> off = kHall;
    for (Eigen::Vector3d& p : off)
      p += 0.06 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    Deployment d = deployment_of(kHall, kNoLever);
    const Flight f = fly(off, kNoLever, 0.0, 150, 1.5, random);
    without += errors_of(track_in_space(f.log, d), f, kNoLever).nees / kFlights;
    know_beacons_to(0.06, d);
    nees += errors_of(track_in_space(f.log, d), f, kNoLever).nees / kFlights;
  }
  EXPECT_GT(without, 2.0);
  EXPECT_GT(nees, 0.6);  // twenty flights of some few independent geometries each
  EXPECT_LT(nees, 1.5);
}

/// The effect of the antenna's lever arm on the origin is in the covariance, and the rotation is unknown.
TEST(SpaceTrack, TheLeverArmCounts) {
  const Eigen::Vector3d lever_m(0.3, -0.1, 0.2);
  Random random(5, 1);
  const Flight f = fly(kHall, lever_m, 0.0, 600, 1.5, random);
  const auto fixes = track_in_space(f.log, deployment_of(kHall, lever_m));
  const Errors e = errors_of(fixes, f, lever_m);
  EXPECT_GT(e.nees, 0.4);
  EXPECT_LT(e.nees, 1.8);
  EXPECT_DOUBLE_EQ(fixes[10].covariance(4, 4), kUnknownRotationVariance);
}

TEST(SpaceTrack, OfTwoMirrorImagesTheCalibratedOrElseTheLowerOneIsTaken) {
  for (const double height_m : {1.2, 4.8}) {
    std::vector<Eigen::Vector3d> level = kHall;
    for (Eigen::Vector3d& p : level) p.z() = 3.0;
    Random random(7, 1);
    const Flight f = fly(level, kNoLever, 0.0, 200, height_m, random);
    Deployment deployment = deployment_of(level, kNoLever);
    if (height_m > 3.0) deployment.validity_heights_m = {4.0, 6.0};
    EXPECT_LT(errors_of(track_in_space(f.log, deployment), f, kNoLever).rmse_m, 0.2);
    deployment.validity_heights_m = {-1.0, 6.0};  // both images are possible, and the fixes say so
    for (const Fix& fix : track_in_space(f.log, deployment)) EXPECT_GT(fix.covariance(2, 2), 1.0);
  }
}

// A rig that is carried up and down through the plane of its beacons. Ranges determine the distance from the
// plane but not its sign. A filter that is reflected at the plane where the rig passed through it, or vice
// versa, stays on the wrong side until the next passage.
TEST(SpaceTrack, ThroughThePlaneOfItsBeaconsATrackTakesTheLikelierSides) {
  std::vector<Eigen::Vector3d> level = kHall;
  for (std::size_t b = 0; b < level.size(); ++b) level[b].z() = 1.6 + (b % 2 == 0 ? 0.05 : -0.05);
  double squares_m2 = 0.0, nees = 0.0;
  constexpr std::uint64_t kFlights = 20;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
    Random random(seed, 2);
    const Flight f = fly(level, kNoLever, 0.0, 300, 1.7, random);
    const Errors e = errors_of(track_in_space(f.log, deployment_of(level, kNoLever)), f, kNoLever);
    squares_m2 += e.rmse_m * e.rmse_m;
    nees += e.nees;
  }
  EXPECT_LT(std::sqrt(squares_m2 / kFlights), 0.12);  // 0.07; on the side that is come upon first 0.34
  EXPECT_GT(nees / kFlights, 0.2);
  EXPECT_LT(nees / kFlights, 1.3);
}

// Beacon heights with errors of centimetres may favour the mirror image with any significance.
TEST(SpaceTrack, BelowACeilingWhoseHeightsAreOffATrackStaysBelow) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed, 3);
    std::vector<Eigen::Vector3d> ceiling = kHall, stated = kHall;
    for (std::size_t b = 0; b < ceiling.size(); ++b) {
      stated[b].z() = 3.0 + 0.05 * random.normal();
      ceiling[b].z() = stated[b].z() + 0.1 * random.normal();
    }
    const Flight f = fly(ceiling, kNoLever, 0.0, 200, 2.2, random);
    Deployment deployment = deployment_of(stated, kNoLever);
    know_beacons_to(0.1, deployment);
    for (const Fix& fix : track_in_space(f.log, deployment))
      EXPECT_LT(fix.T_map_vehicle.translation_m.z(), 3.2) << "seed " << seed;
  }
}

TEST(SpaceTrack, APauseOfTheRadioBeginsAnew) {
  Random random(8, 1);
  Flight f = fly(kHall, kNoLever, 0.0, 300, 1.5, random);
  for (Arrival& a : f.log.arrivals)
    if (a.time_s > 14.95) a.time_s += 60;
  EXPECT_LT(errors_of(track_in_space(f.log, deployment_of(kHall, kNoLever)), f, kNoLever).rmse_m,
            2.5 * kSigma_m);
}

MeasurementLog in_epochs(MeasurementLog log, std::size_t beacons) {
  log.has_epochs = true;
  for (std::size_t i = 0; i < log.arrivals.size(); ++i)
    log.arrivals[i].epoch = static_cast<std::int64_t>(i / beacons);
  return log;
}

TEST(SpaceTrack, EpochsAreInstantsOfADrive) {
  Random random(16, 1);
  const Flight f = fly(kHall, kNoLever, 0.1, 200, 1.5, random);
  const auto fixes =
      locate_run(Method::kTracker, deployment_of(kHall, kNoLever), in_epochs(f.log, kHall.size()));
  const Errors e = errors_of(fixes.value(), f, kNoLever);
  EXPECT_EQ(e.count + 5, f.truth.size());
  EXPECT_LT(e.rmse_m, 1.5 * kSigma_m);
  EXPECT_EQ(fixes->back().epoch, 199);
}

TEST(SpaceTrack, StopsThatNothingTiesTogetherAreLocatedOneByOne) {
  Random random(17, 1);
  Flight f = fly(kHall, kNoLever, 0.0, 50, 1.5, random);
  f.log = in_epochs(f.log, kHall.size());
  for (Arrival& a : f.log.arrivals) a.time_s += 60.0 * static_cast<double>(a.epoch);
  const Deployment d = deployment_of(kHall, kNoLever);
  EXPECT_EQ(choose_method(d, f.log).method, Method::kLeastSquares);
  for (const Method method : {Method::kAuto, Method::kTracker}) {
    const auto fixes = locate_run(method, d, f.log);
    ASSERT_TRUE(fixes.has_value());
    EXPECT_EQ(errors_of(*fixes, f, kNoLever).count + 5, f.truth.size());
  }
}

// The first position may be wrong; a track that its arrivals do not support is rejected.
TEST(SpaceTrack, NothingIsTrackedAmongArrivalsThatDisagree) {
  Random random(18, 1);
  Flight f = fly(kHall, kNoLever, 0.0, 40, 1.5, random);
  for (Arrival& a : f.log.arrivals) a.tof_s += 10 * random.uniform() / kSpeed_mps;
  for (const Fix& fix : track_in_space(f.log, deployment_of(kHall, kNoLever))) EXPECT_FALSE(fix.ok());
}

TEST(SpaceTrack, BeaconsInALineGiveNoFix) {
  Random random(19, 1);
  const std::vector<Eigen::Vector3d> line = {{0, 0, 0.5}, {2, 0, 1.0}, {4, 0, 1.5}, {6, 0, 2.0}};
  const Flight f = fly(line, kNoLever, 0.0, 100, 1.5, random);
  Deployment d = deployment_of(line, kNoLever);
  d.beacons[1].position_m.y() = 0.1;  // but as well as the calibration knows
  know_beacons_to(0.1, d);
  for (const Fix& fix : track_in_space(f.log, d)) EXPECT_EQ(fix.status, FixStatus::kPoorGeometry);
}

TEST(SpaceTrack, TwoBeaconsGiveNoFix) {
  Random random(9, 1);
  const std::vector<Eigen::Vector3d> two = {kHall[0], kHall[1]};
  const Flight f = fly(two, kNoLever, 0.0, 50, 1.5, random);
  for (const Fix& fix : track_in_space(f.log, deployment_of(two, kNoLever))) EXPECT_FALSE(fix.ok());
}

TEST(SpaceTrack, AutoTakesItForADriveInSpace) {
  Random random(10, 1);
  const Flight f = fly(kHall, kNoLever, 0.0, 20, 1.5, random);
  const Deployment d = deployment_of(kHall, kNoLever);
  EXPECT_TRUE(is_drive_in_space(d, f.log));
  EXPECT_EQ(choose_method(d, f.log).method, Method::kTracker);
  MeasurementLog epochs = in_epochs(f.log, kHall.size());
  EXPECT_TRUE(is_drive_in_space(d, epochs));
  for (Arrival& a : epochs.arrivals) a.time_s += 10.0 * static_cast<double>(a.epoch);
  EXPECT_FALSE(is_drive_in_space(d, epochs)) << "stops, located one by one";
}

constexpr SpaceTrackOptions kProtectedInSpace{.protect = true};

double off_m(const Fix& fix, const Pose& truth) {
  return (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>().norm();
}

// Compared with the track of a log without the beacon, started, filtered and smoothed separately.
TEST(SpaceTrack, TheLevelIsTheFarthestOfTheTracksWithoutABeacon) {
  Random random(11, 1);
  const Flight f = fly(kHall, kNoLever, 0.0, 200, 1.5, random);
  const Deployment d = deployment_of(kHall, kNoLever);
  const auto fixes = track_in_space(f.log, d, kProtectedInSpace);
  std::vector<double> expected_m(fixes.size());
  for (std::size_t b = 0; b < kHall.size(); ++b) {
    MeasurementLog log = f.log;
    std::erase_if(log.arrivals, [&](const Arrival& a) { return a.beacon == BeaconId(b); });
    const auto without = track_in_space(log, d);
    ASSERT_EQ(without.size(), fixes.size());
    for (std::size_t k = 0; k < fixes.size(); ++k)
      expected_m[k] =
          std::max(expected_m[k], off_m(without[k], fixes[k].T_map_vehicle) +
                                      kFaultySigmas * std::sqrt(horizontal_variance(without[k].covariance)));
  }
  for (std::size_t k = 0; k < fixes.size(); ++k) {
    expected_m[k] =
        std::max(expected_m[k], kFaultFreeSigmas * std::sqrt(horizontal_variance(fixes[k].covariance)));
    // Instants lie up to 0.1 ms apart, and the first guess of the place is another one.
    EXPECT_NEAR(fixes[k].protection_level_m, expected_m[k], 0.02 * expected_m[k]) << k;
  }
}

TEST(SpaceTrack, ABeaconAtFaultStaysWithinTheLevel) {
  const Deployment d = deployment_of(kHall, kNoLever);
  int leveled = 0, beyond = 0, fixes = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed, 3);
    Flight f = fly(kHall, kNoLever, 0.0, 200, 1.5, random);
    // Creeps, or is late from one instant on.
    const double late_m = 0.02 * std::exp(random.uniform() * 5), per_s = seed % 2 ? 0.0 : late_m / 5;
    const BeaconId bad(static_cast<std::size_t>(random.uniform(0, 5.999)));
    for (Arrival& a : f.log.arrivals)
      if (a.beacon == bad && a.time_s > 6.0)
        a.tof_s += (per_s > 0 ? per_s * (a.time_s - 6.0) : late_m) / kSpeed_mps;
    const auto found = track_in_space(f.log, d, kProtectedInSpace);
    ASSERT_EQ(found.size(), f.truth.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      ++fixes;
      if (!(found[k].ok() && found[k].protection_level_m > 0.0)) continue;
      ++leveled;
      beyond += off_m(found[k], f.truth[k]) > found[k].protection_level_m;
    }
  }
  EXPECT_EQ(beyond, 0) << "of " << leveled << ", of which chance takes one in 2,000, and neighbours share it";
  EXPECT_GT(leveled, fixes / 2);
}

TEST(SpaceTrack, LevelsChangeNoFixAndAreNotThereUnasked) {
  Random random(12, 1);
  const Flight f = fly(kHall, kNoLever, 0.05, 100, 1.5, random);
  const Deployment d = deployment_of(kHall, kNoLever);
  const auto plain = track_in_space(f.log, d), bounded = track_in_space(f.log, d, kProtectedInSpace);
  ASSERT_EQ(plain.size(), bounded.size());
  for (std::size_t k = 0; k < plain.size(); ++k) {
    EXPECT_EQ(plain[k].T_map_vehicle.translation_m, bounded[k].T_map_vehicle.translation_m);
    EXPECT_EQ(plain[k].rejections, bounded[k].rejections);
    EXPECT_EQ(plain[k].protection_level_m, 0.0);
    EXPECT_GT(bounded[k].protection_level_m, 0.0);
  }
}

TEST(SpaceTrack, ThreeBeaconsHaveNoLevel) {
  Random random(13, 1);
  const std::vector<Eigen::Vector3d> three(kHall.begin(), kHall.begin() + 3);
  const Flight f = fly(three, kNoLever, 0.0, 50, 1.5, random);
  for (const Fix& fix : track_in_space(f.log, deployment_of(three, kNoLever), kProtectedInSpace))
    EXPECT_EQ(fix.protection_level_m, 0.0);
}

/// Only the fifth beacon determines on which side of a wall of four the vehicle is. If it is faulty, the
/// position may be the mirror image.
TEST(SpaceTrack, WhereOneBeaconTellsTheSideItTakesThatWithIt) {
  Random random(14, 1);
  std::vector<Eigen::Vector3d> wall = {{0, 0, 0.3}, {10, 0, 4.0}, {10, 0, 0.5}, {0, 0, 4.2}, {5, 9, 1.0}};
  const Flight f = fly(wall, kNoLever, 0.0, 100, 1.5, random);
  const auto fixes = track_in_space(f.log, deployment_of(wall, kNoLever), kProtectedInSpace);
  for (std::size_t k = 0; k < fixes.size(); ++k)
    if (fixes[k].protection_level_m > 0.0)
      EXPECT_GT(fixes[k].protection_level_m, 1.9 * f.truth[k].translation_m.y()) << k;
}

}  // namespace space_track_test
}  // namespace octant
