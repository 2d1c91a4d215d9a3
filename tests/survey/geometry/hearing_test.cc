// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// One path at a time against the maps' lanes; places to stop; a site's schedule.
#include "survey/geometry/hearing.h"

#include <gtest/gtest.h>

#include "models/physics/polygon.h"
#include "models/simulator/random.h"
#include "survey/geometry/geometry_map.h"
#include "survey/geometry/make_survey_model.h"
#include "survey/schedule/floor_schedule.h"
#include "survey/schedule/stop_places.h"
#include "tests/survey/halls.h"

namespace octant::survey {
namespace hearing_test {

using test::must;

/// The warehouse with beacons that look, receivers that look, and a threshold.
SurveyModel looking_model() {
  test::Hall hall = test::warehouse_hall();
  hall.site.vehicles.clear();
  hall.site.receivers.clear();
  test::add_octagon(hall.site, 2.2);
  BeamPattern beam;
  beam.name = "beam";
  beam.kind = BeamPattern::Kind::kCosinePower;
  beam.half_angle_rad = 1.2;
  hall.scene.patterns.push_back(beam);
  hall.scene.beacon_pattern = 0;
  hall.site.beacons.clear();
  Random draws(5);
  for (int i = 0; i < 12; ++i) {
    const std::string name = "B" + std::to_string(i);
    const double x = draws.uniform(0.5, 25.5);
    hall.site.beacons.push_back(
        test::beacon(name, {x, i % 2 == 0 ? 0.5 : 15.5, draws.uniform(2.0, 5.0)}, 0.0));
    SceneBeacon described;
    described.name = name;
    described.axis = draws.normal3().normalized();
    hall.scene.beacons.push_back(described);
  }
  hall.scene.acoustics = {
      .absorption_np_per_m = 0.1, .amplitude_1m_v = 5.0, .threshold_v = 0.1, .range_m = 12.0};
  return must(make_survey_model(hall.site, hall.scene));
}

/// Without a pattern in the scene, receivers have their calibrated directivity.
TEST(Hearing, ADirectionalArrayHearsAsCalibrated) {
  test::Hall hall = test::warehouse_hall();
  hall.site.vehicles.clear();
  hall.site.receivers.clear();
  test::add_octagon(hall.site, 2.2);
  hall.site.attenuation = AttenuationPrior{.amplitude_1m_v = {12.5, 0},
                                           .absorption_np_per_m = {0.1, 0},
                                           .rise_time_s = {},
                                           .threshold_v = 0.1,
                                           .half_power_angle_rad = {0.4, 0}};
  const SurveyModel model = must(make_survey_model(hall.site, hall.scene));
  hall.site.attenuation->half_power_angle_rad = {};
  const SurveyModel all_round = must(make_survey_model(hall.site, hall.scene));
  const AttenuationModel attenuation{.amplitude_1m_v = 12.5, .absorption_np_per_m = 0.1, .threshold_v = 0.1};
  Random draws(7);
  int heard = 0, heard_all_round = 0;
  for (int i = 0; i < 500; ++i) {
    const double x = draws.uniform(0, 26), y = draws.uniform(0, 16);
    const Pose T = Pose::planar(x, y, draws.uniform(-3, 3));
    for (std::size_t b = 0; b < model.beacons.size(); ++b)
      for (std::size_t r = 0; r < model.receivers.size(); ++r) {
        const Eigen::Vector3d to = model.beacons[b].p_map_m - T * model.receivers[r].p_vehicle_m;
        const double gain =
            std::exp(log_directivity((T.rotation * model.receivers[r].axis).dot(to.normalized()), 0.4).value);
        const bool loud = gain * amplitude_v(to.norm(), attenuation) >= 0.1;
        const bool here = hears(model, b, r, T);
        EXPECT_TRUE(loud || !here) << b << " " << r;
        heard += here;
        heard_all_round += hears(all_round, b, r, T);
      }
  }
  EXPECT_GT(heard, 200);
  EXPECT_LT(heard, heard_all_round);
}

TEST(Hearing, AsTheMapsHaveIt) {
  const SurveyModel model = looking_model();
  Random draws(6);
  PoseList poses;
  for (int i = 0; i < 500; ++i) {
    const double x = draws.uniform(0, 26), y = draws.uniform(0, 16);
    poses.add(x, y, 0.0, draws.uniform(-3, 3));
  }
  const auto heard = heard_at(model, poses);
  std::size_t yes = 0, no = 0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    for (std::size_t b = 0; b < model.beacons.size(); ++b) {
      bool any = false;
      for (std::size_t r = 0; r < model.receivers.size(); ++r)
        any = any || hears(model, b, r, Pose::planar(poses.x_m[i], poses.y_m[i], poses.heading_rad[i]));
      // The lanes take gains from a table of 4096 steps: a pattern's very edge may fall to either side.
      EXPECT_EQ(any, heard[b][i] != 0) << i << " " << b;
      (any ? yes : no)++;
    }
  EXPECT_GT(yes, 100U);
  EXPECT_GT(no, 100U);
}

TEST(StopPlaces, KeepTheirClearance) {
  const test::Hall hall = test::warehouse_hall();
  const SurveyModel model = must(make_empty_survey_model(hall.site, hall.scene));
  const StopPlaces stops = must(stop_places(model, hall.scene, 1.0, 0.4));
  EXPECT_GT(stops.places_m.size(), 50U);
  for (const auto& p : stops.places_m) {
    EXPECT_TRUE(stops.may_stop(p));
    EXPECT_GE(distance_to_outline_m(model.floor_m, p), 0.4);
    for (const SceneWall& wall : hall.scene.walls) EXPECT_FALSE(is_inside(wall.points_m, p)) << wall.name;
  }
  EXPECT_FALSE(stops.may_stop({-1, 5}));
  EXPECT_FALSE(stops.may_stop({0.2, 5}));
  EXPECT_FALSE(stop_places(model, hall.scene, 1.0, 20.0)) << "no room";
  EXPECT_FALSE(stop_places(model, hall.scene, 1e-3, 0.4)) << "too many";
}

/// Slots of a cellar, and of heights above the sea, are those of the same hall at ground level.
TEST(FloorSchedule, AHallBelowZeroOrFarAboveItIsAsHigh) {
  test::Hall hall = test::rectangle_hall();
  hall.site.motion = Motion::kSpatial;
  hall.site.beacons.clear();
  for (int i = 0; i < 5; ++i)
    hall.site.beacons.push_back(test::beacon("B" + std::to_string(i), {1.0 + i, 0.1 * i * i, 2.5}, 0.1));
  hall.scene.acoustics.range_m = 12.0;
  const SurveyModel model = must(make_survey_model(hall.site, hall.scene));
  const FloorSchedule above = must(floor_schedule(model, hall.scene, {}));
  EXPECT_NEAR(above.height_m, 3.0, 1e-12);
  SurveyModel cellar = model;
  cellar.vehicle_z_m -= 12.0;
  for (SurveyBeacon& b : cellar.beacons) b.p_map_m.z() -= 12.0;
  const FloorSchedule below = must(floor_schedule(cellar, hall.scene, {}));
  EXPECT_NEAR(below.height_m, above.height_m, 1e-12);
  EXPECT_NEAR(below.silent.slot_s, above.silent.slot_s, 1e-12);
  SurveyModel on_a_hill = model;
  on_a_hill.vehicle_z_m += 113.0;
  for (SurveyBeacon& b : on_a_hill.beacons) b.p_map_m.z() += 113.0;
  const FloorSchedule hill = must(floor_schedule(on_a_hill, hall.scene, {}));
  EXPECT_NEAR(hill.height_m, above.height_m, 1e-12);
  // The receivers relative to a vehicle's origin at zero, as in the plane.
  double lowest_m = 2.5;
  for (SurveyReceiver& r : on_a_hill.receivers) {
    lowest_m = std::min(lowest_m, r.p_vehicle_m.z());
    r.p_vehicle_m.z() += 113.0;
  }
  on_a_hill.vehicle_z_m = 0.0;
  EXPECT_NEAR(must(floor_schedule(on_a_hill, hall.scene, {})).height_m, 3.0 - lowest_m, 1e-12);
}

TEST(FloorSchedule, FarBeaconsShareASlot) {
  test::Hall hall = test::rectangle_hall();
  hall.scene.floor_m = {{0, 0}, {80, 0}, {80, 6}, {0, 6}};
  hall.scene.walls.clear();
  hall.site.beacons.clear();
  for (int i = 0; i < 8; ++i)
    hall.site.beacons.push_back(test::beacon("B" + std::to_string(i), {5.0 + 10 * i, 0.1, 2.5}, 0.1));
  hall.scene.acoustics.range_m = 12.0;
  const SurveyModel model = must(make_survey_model(hall.site, hall.scene));
  const FloorSchedule s = must(floor_schedule(model, hall.scene, {.wall_reflection = 0.8}));
  EXPECT_EQ(s.warnings.size(), 2U) << "no threshold; no common clock";
  EXPECT_NEAR(s.reverberance.volume_m3, 80 * 6 * 3.0, 1e-9);
  EXPECT_LT(s.plan.groups.size(), 8U);
  EXPECT_GE(s.plan.groups.size(), s.plan.least_groups);
  EXPECT_EQ(s.plan.between(0, 1), Sharing::kConfused);
  EXPECT_EQ(s.plan.between(0, 7), Sharing::kNeverBoth);
  // Distance only: no reception beyond 12 m, less than the hall's length, so no wall matters.
  EXPECT_NEAR(s.silent.single_echo_s, 12.0 / model.speed_mps, 1e-6);
  hall.scene.acoustics.range_m.reset();
  EXPECT_FALSE(floor_schedule(must(make_survey_model(hall.site, hall.scene)), hall.scene, {}));
}

}  // namespace hearing_test
}  // namespace octant::survey
