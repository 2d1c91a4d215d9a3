// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Compares the C interface with the class that it wraps, number by number.
#include "apps/robot/octant/octant.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "tests/apps/robot/robot.h"

namespace octant::test {
namespace octant_test {

octant_arrival arrival_of(const Heard& heard) {
  octant_arrival a = octant_arrival_of(heard.beacon.data(), heard.receiver.data(), heard.tof_s, heard.time_s);
  a.epoch = heard.epoch;
  a.amplitude_v = heard.amplitude_v;
  return a;
}

/// All numbers of a place and of a fix are the same bits.
void expect_same(const Place& place, const octant_fix& fix) {
  EXPECT_EQ(place.ok ? 1 : 0, fix.ok);
  EXPECT_STREQ(place.status, fix.status);
  EXPECT_STREQ(place.integrity, fix.integrity);
  EXPECT_STREQ(place.integrity_reason, fix.integrity_reason);
  const double places[] = {place.time_s,
                           place.x_m,
                           place.y_m,
                           place.z_m,
                           place.heading_rad,
                           place.qx,
                           place.qy,
                           place.qz,
                           place.qw,
                           place.sigma_x_m,
                           place.sigma_y_m,
                           place.sigma_z_m,
                           place.sigma_heading_rad,
                           place.protection_level_m};
  const double fixes[] = {fix.time_s,
                          fix.x_m,
                          fix.y_m,
                          fix.z_m,
                          fix.heading_rad,
                          fix.qx,
                          fix.qy,
                          fix.qz,
                          fix.qw,
                          fix.sigma_x_m,
                          fix.sigma_y_m,
                          fix.sigma_z_m,
                          fix.sigma_heading_rad,
                          fix.protection_level_m};
  EXPECT_EQ(std::memcmp(places, fixes, sizeof places), 0);
  EXPECT_EQ(std::memcmp(place.covariance, fix.covariance, sizeof fix.covariance), 0);
  EXPECT_EQ(place.has_velocity ? 1 : 0, fix.has_velocity);
  EXPECT_EQ(std::memcmp(place.velocity_mps, fix.velocity_mps, sizeof fix.velocity_mps), 0);
  EXPECT_EQ(std::memcmp(place.turn_rate_radps, fix.turn_rate_radps, sizeof fix.turn_rate_radps), 0);
  EXPECT_EQ(std::memcmp(place.sigma_velocity_mps, fix.sigma_velocity_mps, sizeof fix.sigma_velocity_mps), 0);
  EXPECT_EQ(
      std::memcmp(place.sigma_turn_rate_radps, fix.sigma_turn_rate_radps, sizeof fix.sigma_turn_rate_radps),
      0);
  EXPECT_EQ(place.arrivals_used, fix.arrivals_used);
  EXPECT_EQ(place.arrivals_rejected, fix.arrivals_rejected);
  EXPECT_EQ(place.vehicle, fix.vehicle);
}

/// Positioner of the C interface that is closed at the end of a test.
class Opened {
 public:
  Opened(const std::string& path, octant_options options) {
    EXPECT_EQ(octant_open(path.c_str(), &options, &handle_), OCTANT_DONE) << octant_last_error();
  }
  ~Opened() { octant_close(handle_); }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  octant_positioner* get() { return handle_; }

 private:
  octant_positioner* handle_ = nullptr;
};

void keep(const octant_fix* fix, void* user) { static_cast<std::vector<octant_fix>*>(user)->push_back(*fix); }

void expect_same_drive(Motion motion) {
  Scenario scenario = drive_scenario(20.0);
  scenario.site.motion = motion;
  scenario.log_odometry = true;
  const World world = must(simulate(scenario, 7));
  const Robot robot(world);
  std::vector<octant_fix> fixes;
  octant_options options = octant_default_options();
  options.on_fix = keep;
  options.user = &fixes;
  Opened opened(robot.path(), options);
  Positioner positioner(robot.path());
  std::vector<Place> places;
  positioner.on_place([&](const Place& place) { places.push_back(place); });
  const MeasurementLog& log = world.heldout;
  std::size_t next = 0;
  for (const OdometryStep& row : log.odometry) {
    for (; next < log.arrivals.size() && log.arrivals[next].time_s <= row.time_s; ++next) {
      const Heard heard = robot.heard(log.arrivals[next]);
      const octant_arrival arrival = arrival_of(heard);
      EXPECT_TRUE(positioner.hear(heard));
      EXPECT_EQ(octant_add_arrival(opened.get(), &arrival), OCTANT_DONE) << octant_last_error();
    }
    const Pose T = row.pose();
    octant_odometry_step step = octant_step_at(row.time_s);
    step.dx_m = T.translation_m.x(), step.dy_m = T.translation_m.y(), step.dz_m = T.translation_m.z();
    step.qx = T.rotation.x(), step.qy = T.rotation.y(), step.qz = T.rotation.z(), step.qw = T.rotation.w();
    EXPECT_EQ(octant_add_step(opened.get(), &step), OCTANT_DONE) << octant_last_error();
    EXPECT_TRUE(positioner.move(
        {step.time_s, step.dx_m, step.dy_m, 0.0, {}, step.dz_m, step.qx, step.qy, step.qz, step.qw}));
  }
  positioner.flush();
  EXPECT_EQ(octant_flush(opened.get()), OCTANT_DONE);
  ASSERT_EQ(places.size(), fixes.size());
  EXPECT_GT(fixes.size(), 150u);
  for (std::size_t i = 0; i < fixes.size(); ++i) expect_same(places[i], fixes[i]);
  octant_fix soon;
  const double soon_s = log.odometry.back().time_s + 0.1;
  EXPECT_EQ(octant_predict(opened.get(), soon_s, nullptr, &soon), OCTANT_DONE);
  expect_same(positioner.predict(soon_s), soon);
}

TEST(OctantC, FollowsAsThePositionerDoesInThePlane) { expect_same_drive(Motion::kPlanar); }
TEST(OctantC, FollowsAsThePositionerDoesInSpace) { expect_same_drive(Motion::kSpatial); }

TEST(OctantC, LocatesAsThePositionerDoesAtEveryTemperature) {
  const World world = must(simulate(hall_scenario(), 5));
  const Robot robot(world);
  Positioner positioner(robot.path());
  Opened opened(robot.path(), octant_default_options());
  const std::vector<Arrival>& all = world.heldout.arrivals;
  std::vector<octant_arrival> arrivals;
  std::vector<Heard> heard;
  for (const Arrival& a : all)
    if (a.epoch == all.front().epoch) heard.push_back(robot.heard(a));
  for (const Heard& one : heard) arrivals.push_back(arrival_of(one));
  octant_fix fix;
  for (const double temperature : {std::nan(""), -5.0, 30.0}) {
    EXPECT_EQ(octant_set_temperature(opened.get(), temperature), OCTANT_DONE);
    for (Heard& one : heard) one.temperature_degC = temperature;
    EXPECT_EQ(octant_locate(opened.get(), arrivals.data(), arrivals.size(), &fix), OCTANT_DONE);
    expect_same(positioner.locate(heard), fix);
  }
  EXPECT_EQ(octant_set_temperature(opened.get(), std::numeric_limits<double>::infinity()),
            OCTANT_BAD_ARGUMENT);
}

TEST(OctantC, WrongCallsAreRefusedWithAReason) {
  const Robot robot(must(simulate(hall_scenario(), 5)));
  octant_options options = octant_default_options();
  octant_positioner* none = nullptr;
  EXPECT_EQ(octant_open(nullptr, &options, &none), OCTANT_BAD_DEPLOYMENT);
  EXPECT_EQ(octant_open(robot.path().c_str(), nullptr, &none), OCTANT_BAD_ARGUMENT);
  EXPECT_EQ(octant_open(robot.path().c_str(), &options, nullptr), OCTANT_BAD_ARGUMENT);
  EXPECT_EQ(octant_open_memory(nullptr, 5, &options, &none), OCTANT_BAD_DEPLOYMENT);
  EXPECT_EQ(octant_open_memory("{\"type\"", 7, &options, &none), OCTANT_BAD_DEPLOYMENT);
  EXPECT_EQ(none, nullptr);
  options.lateness_s = std::nan("");
  EXPECT_EQ(octant_open(robot.path().c_str(), &options, &none), OCTANT_BAD_DEPLOYMENT);
  EXPECT_NE(std::string(octant_last_error()).find("lateness"), std::string::npos);
  octant_fix fix;
  EXPECT_EQ(octant_locate(nullptr, nullptr, 0, &fix), OCTANT_BAD_ARGUMENT);
  octant_close(nullptr);

  Opened opened(robot.path(), octant_default_options());
  EXPECT_EQ(octant_locate(opened.get(), nullptr, 3, &fix), OCTANT_BAD_ARGUMENT);
  EXPECT_EQ(octant_locate(opened.get(), nullptr, 0, &fix), OCTANT_DONE);
  EXPECT_EQ(fix.ok, 0);
  EXPECT_STREQ(fix.status, "too_few_arrivals");
  EXPECT_EQ(octant_predict(opened.get(), 1.0, "nobody", &fix), OCTANT_DONE);
  EXPECT_EQ(fix.ok, 0);
  const octant_arrival nobody = octant_arrival_of("nobody", "r0", 0.01, 1.0);
  EXPECT_EQ(octant_add_arrival(opened.get(), &nobody), OCTANT_REFUSED);
  octant_odometry_step step = octant_step_at(1.0);
  step.qw = 0.0;
  EXPECT_EQ(octant_add_step(opened.get(), &step), OCTANT_REFUSED) << "no rotation";
  octant_odometry_pose pose = octant_pose_at(std::nan(""));
  EXPECT_EQ(octant_add_pose(opened.get(), &pose), OCTANT_REFUSED);
  pose = octant_pose_at(1.0);
  EXPECT_EQ(octant_add_pose(opened.get(), &pose), OCTANT_DONE) << octant_last_error();
}

/// A C++ callback must not throw; if it does, the exception does not leave the C functions.
TEST(OctantC, AnExceptionOfACallbackBecomesAResult) {
  const World world = must(simulate(hall_scenario(), 5));
  const Robot robot(world);
  octant_options options = octant_default_options();
  options.on_fix = [](const octant_fix*, void*) { throw std::runtime_error("from the callback"); };
  Opened opened(robot.path(), options);
  for (const Arrival& a : world.heldout.arrivals)
    if (a.epoch == world.heldout.arrivals.front().epoch) {
      const octant_arrival arrival = arrival_of(robot.heard(a));
      EXPECT_EQ(octant_add_arrival(opened.get(), &arrival), OCTANT_DONE);
    }
  EXPECT_EQ(octant_flush(opened.get()), OCTANT_FAULT);
  EXPECT_STREQ(octant_last_error(), "from the callback");
}

}  // namespace octant_test
}  // namespace octant::test
