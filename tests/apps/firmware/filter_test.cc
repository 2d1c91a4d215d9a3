// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Drive filter of the firmware edition against DriveFilter, row by row.
#include <cstdlib>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/deployment/deployment_json.h"
#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/odometry_noise.h"
#include "tests/apps/process.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace filter_test {

/// Commands for tests/apps/firmware/driver.c, and the poses that its filter must have after them.
template <int kDof>
struct Drive {
  std::string commands;
  std::vector<Pose> poses;
  std::vector<double> variances;  ///< of x
  std::size_t used = 0, rejected = 0;

  void add(const std::string& command, const DriveFilterOf<kDof>& filter) {
    commands += command + "\n";
    poses.push_back(filter.pose());
    variances.push_back(filter.covariance()(0, 0));
  }
};

/// Arrivals without noise at a pose: a start for the filter.
std::vector<Arrival> arrivals_at(const Pose& T, const Deployment& d) {
  const SharedState state = shared_state(d);
  std::vector<Arrival> out;
  for (std::size_t b = 0; b < d.beacons.size(); ++b)
    for (std::size_t r = 0; r < d.receivers.size(); ++r) {
      PathInput path = path_of(state, BeaconId(b), ReceiverId(r), d.speed_mps(d.medium.temperature_degC));
      path.T_map_vehicle = &T;
      Arrival a;
      a.beacon = BeaconId(b);
      a.receiver = ReceiverId(r);
      a.vehicle = VehicleId(0);
      a.epoch = 0;
      a.tof_s = predict_arrival_value(path).tof_s;
      out.push_back(a);
    }
  return out;
}

std::string row_of(const Arrival& a) {
  return fmt::format("{} {} {:.17g}", a.beacon.index(), a.receiver.index(), a.tof_s);
}

/// @param near_echoes  half of the echoes are near the gate
template <int kDof>
Drive<kDof> drive_of(const World& world, bool near_echoes) {
  Drive<kDof> drive;
  const Deployment& d = world.truth;
  const MeasurementLog& log = world.heldout;
  const EpochFixModel model = epoch_fix_model(d);
  const TrajectoryModel trajectory = trajectory_model(d);
  DriveFilterOf<kDof> filter(model, EpochFixOptions{}.rejection_sigmas, 0.0);
  const std::vector<Arrival> first = arrivals_at(log.truth.front().T_map_vehicle, d);
  const Fix fix = LeastSquaresLocalizer(d).locate(first);
  EXPECT_TRUE(fix.ok());
  drive.commands = fmt::format("E {} nan\n", first.size());
  for (const Arrival& a : first) drive.commands += row_of(a) + "\n";
  filter.start(fix.T_map_vehicle, fix.covariance);
  drive.add("S", filter);
  Trajectory one;
  std::size_t next = 0;
  for (const OdometryStep& step : log.odometry) {
    const Pose T = step.pose();
    const OdometryVariance variance = variance_of(step, OdometryAccuracy{});
    OdometryObservation whole;
    whole.distance_sigma_m = std::sqrt(variance.distance_m2);
    whole.heading_sigma_rad = std::sqrt(variance.heading_rad2);
    filter.predict(T, whole, 1.0);
    const Eigen::Vector3d& p = T.translation_m;
    const Eigen::Quaterniond& q = T.rotation;
    drive.add(fmt::format("M 0.05 {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}", p.x(), p.y(),
                          p.z(), q.x(), q.y(), q.z(), q.w()),
              filter);
    for (; next < log.arrivals.size() && log.arrivals[next].time_s <= step.time_s; ++next) {
      Arrival a = log.arrivals[next];
      if (next % 10 == 0) a.tof_s += near_echoes && next % 20 == 0 ? 7e-5 : 3e-3;
      set_epoch(one, std::span(&a, 1), {}, trajectory);
      ++(filter.update(one, one.arrivals.front()) == Rejection::kUsed ? drive.used : drive.rejected);
      drive.add("A " + row_of(a), filter);
    }
  }
  return drive;
}

/// Lines of the firmware for these commands.
std::vector<std::string> lines_of(const Deployment& deployment, const std::string& commands, bool single) {
  const TemporaryFolder box;
  EXPECT_TRUE(io::write_deployment(box / "d.json", deployment));
  std::vector<std::string> words = {"export", box / "d.json", "--c", box / "c"};
  if (single) words.emplace_back("--float");
  EXPECT_EQ(octant(words).exit, 0);
  spit(box / "commands.txt", commands);
  const std::string driver = OCTANT_SOURCE_DIR "/tests/apps/firmware/driver.c";
  const std::string build = fmt::format(
      "cd {0} && cc -std=c99 -O1 -Ic c/octant_fix.c c/octant_site.c {1} -o driver -lm "
      "&& ./driver commands.txt > out.txt",
      box.path().string(), driver);
  EXPECT_EQ(std::system(build.c_str()), 0);
  std::istringstream text(slurp(box / "out.txt"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

template <int kDof>
void expect_same_drive(bool single) {
  if (std::system("cc --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no C compiler";
  Scenario scenario = drive_scenario(20.0);
  scenario.site.motion = kDof == 3 ? Motion::kPlanar : Motion::kSpatial;
  scenario.log_odometry = true;
  const World world = must(simulate(scenario, 7));
  const Drive<kDof> drive = drive_of<kDof>(world, !single);  // at the gate, rounding decides
  EXPECT_GT(drive.used, 200u);
  EXPECT_GT(drive.rejected, 20u);
  const std::vector<std::string> lines = lines_of(world.truth, drive.commands, single);
  ASSERT_EQ(lines.size(), drive.poses.size() + 2);  // the fix first, memory and time last
  double worst_m = 0.0, worst_rad = 0.0, worst_variance = 0.0;
  for (std::size_t i = 0; i < drive.poses.size(); ++i) {
    std::istringstream row(lines[i + 1]);
    double used, x, y, z, qx, qy, qz, qw, variance;
    row >> used >> x >> y >> z >> qx >> qy >> qz >> qw >> variance;
    ASSERT_TRUE(row) << lines[i + 1];
    const Pose& T = drive.poses[i];
    worst_m = std::max(worst_m, (T.translation_m - Eigen::Vector3d(x, y, z)).norm());
    worst_rad = std::max(worst_rad, T.rotation.angularDistance(Eigen::Quaterniond(qw, qx, qy, qz)));
    worst_variance = std::max(worst_variance, std::abs(variance / drive.variances[i] - 1.0));
  }
  EXPECT_LT(worst_m, 1e-3);  // issue 47: the same fixes to a millimetre
  EXPECT_LT(worst_rad, 1e-3);
  EXPECT_LT(worst_variance, 0.02);
}

TEST(FirmwareFilter, FollowsAsTheDriveFilterInThePlane) { expect_same_drive<3>(false); }
TEST(FirmwareFilter, FollowsAsTheDriveFilterInSpace) { expect_same_drive<6>(false); }
TEST(FirmwareFilter, FollowsInSinglePrecision) {
  expect_same_drive<3>(true);
  expect_same_drive<6>(true);
}

}  // namespace filter_test
}  // namespace octant::test
