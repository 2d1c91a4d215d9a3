// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report/report_geometry.h"

#include <cmath>

#include <gtest/gtest.h>

#include "survey/geometry/geometry_map.h"
#include "survey/geometry/make_survey_model.h"
#include "tests/survey/report_input.h"

namespace octant::survey {
namespace report_geometry_test {

/// Five beacons at 2.5 m round a calibrated square of 6 m, a vehicle with one receiver.
ReportInput square_site() {
  ReportInput input;
  Deployment& d = input.plan.deployment;
  d.medium.model = MediumModel::kConstant;
  d.medium.speed_mps = 343.0;
  d.noise.tof_sigma_s = 1e-5;
  for (const auto& [name, x, y] :
       {std::tuple{"B0", 0, 0}, {"B1", 10, 0}, {"B2", 10, 10}, {"B3", 0, 10}, {"B4", 5, 11}})
    d.beacons.push_back(test_beacon(name, x, y, 0.001, BeaconStatus::kCalibrated));
  d.vehicles.resize(1);
  d.vehicles[0].receiver_count = 1;
  d.receivers.resize(1);
  d.receivers[0].name = "r0";
  d.receivers[0].vehicle = VehicleId(0);
  d.validity_area_m = {{2, 2}, {8, 2}, {8, 8}, {2, 8}};
  return input;
}

TEST(ReportGeometry, LossIsWhatRemainsWithoutTheBeacon) {
  ReportInput input = square_site();
  add_geometry(input, 1);
  ASSERT_FALSE(input.plan.maps.empty());
  ASSERT_EQ(input.losses.size(), 5u);
  ASSERT_TRUE(input.no_loss && input.no_loss->map);
  EXPECT_DOUBLE_EQ(input.no_loss->covered_fraction, 1.0);
  for (const BeaconLoss& loss : input.losses) {
    EXPECT_GT(*loss.p95, *input.no_loss->p95) << loss.beacon;
    // Reference from a model that never had the beacon.
    Deployment without = square_site().plan.deployment;
    std::erase_if(without.beacons, [&](const auto& b) { return b.name == loss.beacon; });
    const SurveyModel model = *make_survey_model(without, Scene{});
    const NamedMap& map = *loss.map;
    PoseList poses;
    std::vector<double> found_mm;
    for (std::size_t i = 0; i < map.values.size(); i += 37) {
      const Eigen::Vector2d p =
          map.corner_m + map.cell_m * Eigen::Vector2d(static_cast<double>(i % map.columns) + 0.5,
                                                      static_cast<double>(i / map.columns) + 0.5);
      poses.add(p.x(), p.y(), model.vehicle_z_m, 0.0);
      found_mm.push_back(map.values[i]);
    }
    const GeometryFigures expected = evaluate_poses(model, poses);
    for (std::size_t i = 0; i < poses.size(); ++i)
      EXPECT_NEAR(found_mm[i], 1e3 * expected[kSigma][i], 1e-6 * found_mm[i]);  // sums in another order
  }
  for (std::size_t i = 1; i < input.losses.size(); ++i)
    EXPECT_GE(*input.losses[i - 1].p95, *input.losses[i].p95);
}

TEST(ReportGeometry, NothingToTellIsNoFault) {
  ReportInput empty;
  add_geometry(empty, 1);
  EXPECT_TRUE(empty.plan.maps.empty());
  EXPECT_TRUE(empty.losses.empty());
  ReportInput two = square_site();
  two.plan.deployment.beacons.resize(2);
  add_geometry(two, 1);
  ASSERT_EQ(two.losses.size(), 2u);
  EXPECT_EQ(two.losses[0].covered_fraction, 0.0);  // one circle is no fix
  EXPECT_FALSE(two.losses[0].median.has_value());
  EXPECT_FALSE(report_html(two, {.interactive = false}).empty());
}

}  // namespace report_geometry_test
}  // namespace octant::survey
