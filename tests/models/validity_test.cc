// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/validity.h"

#include <gtest/gtest.h>

#include "models/support/utc_time.h"

namespace octant {
namespace validity_test {

Deployment ten_by_five() {
  Deployment d;
  d.medium.model = MediumModel::kCramer1993;
  d.validity_temperature_degC = {18.0, 21.0};
  d.validity_area_m = {{0, 0}, {10, 0}, {10, 5}, {0, 5}};
  return d;
}

MeasurementLog run_at(std::optional<double> temperature_degC, std::vector<double> of_arrivals = {NAN}) {
  MeasurementLog run;
  run.temperature_degC = temperature_degC;
  for (const double degC : of_arrivals) {
    Arrival a;
    a.temperature_degC = degC;
    run.arrivals.push_back(a);
  }
  return run;
}

Fix fix_at(double x_m, double y_m, FixStatus status = FixStatus::kOk) {
  Fix fix;
  fix.status = status;
  fix.T_map_vehicle.translation_m = {x_m, y_m, 0};
  return fix;
}

TEST(Validity, TemperaturesAreThoseOfArrivalsThenOfTheRun) {
  EXPECT_FALSE(stated_temperatures(run_at({})));
  EXPECT_EQ(stated_temperatures(run_at(20.0)).value(), (std::array<double, 2>{20.0, 20.0}));
  EXPECT_EQ(stated_temperatures(run_at(20.0, {15.0, NAN})).value(), (std::array<double, 2>{15.0, 20.0}));
  EXPECT_EQ(stated_temperatures(run_at({}, {15.0, NAN, 16.5})).value(), (std::array<double, 2>{15.0, 16.5}));
}

TEST(Validity, TemperatureOutsideTheWidenedRangeIsTold) {
  const Deployment d = ten_by_five();
  EXPECT_FALSE(outside_validity(d, run_at(18.0 - kTemperatureMargin_degC), {}).any());
  EXPECT_FALSE(outside_validity(d, run_at(21.0 + kTemperatureMargin_degC), {}).any());
  EXPECT_EQ(outside_validity(d, run_at(12.9), {}).temperature_degC, 12.9);
  EXPECT_EQ(outside_validity(d, run_at(20.0, {20.0, 26.1}), {}).temperature_degC, 26.1);
  Deployment constant = d;
  constant.medium.model = MediumModel::kConstant;
  EXPECT_FALSE(outside_validity(constant, run_at(60.0), {}).any());
}

TEST(Validity, InSpaceHeightsCountAsTheAreaDoes) {
  Deployment d = ten_by_five();
  EXPECT_DOUBLE_EQ(distance_from_validity_m(d, {5, 2, 9}), 0.0);
  d.validity_heights_m = {1.0, 3.0};
  EXPECT_DOUBLE_EQ(distance_from_validity_m(d, {5, 2, 2}), 0.0);
  EXPECT_DOUBLE_EQ(distance_from_validity_m(d, {13, 2, 7}), 5.0);
  EXPECT_DOUBLE_EQ(distance_from_validity_m(d, {5, 2, -1}), 2.0);
  EXPECT_EQ(outside_validity(d, run_at(20.0), std::vector{fix_at(5, 2)}).outside, 0U) << "within the margin";
  d.validity_heights_m = {2.0, 3.0};
  EXPECT_EQ(outside_validity(d, run_at(20.0), std::vector{fix_at(5, 2)}).outside, 1U);
}

TEST(Validity, AnUnstatedTemperatureIsToldWhereItMatters) {
  Deployment d = ten_by_five();
  EXPECT_TRUE(outside_validity(d, run_at({}), {}).reference_assumed);
  EXPECT_FALSE(outside_validity(d, run_at({}, {}), {}).reference_assumed) << "bearings alone know no speed";
  d.medium.model = MediumModel::kConstant;
  EXPECT_FALSE(outside_validity(d, run_at({}), {}).reference_assumed);
}

TEST(Validity, FixesOutsideTheWidenedAreaAreCounted) {
  const Deployment d = ten_by_five();
  const double margin_m = kAreaMargin * std::hypot(10.0, 5.0);
  const Fix fixes[] = {fix_at(5, 2), fix_at(10 + 0.99 * margin_m, 2), fix_at(13, 9),
                       fix_at(50, 50, FixStatus::kAmbiguous)};
  const auto found = outside_validity(d, run_at(20.0), fixes);
  EXPECT_EQ(found.fixes, 3u);
  EXPECT_EQ(found.outside, 1u);
  EXPECT_NEAR(found.farthest_m, 5.0, 1e-12) << "from the corner (10, 5): 3 and 4";
}

TEST(Validity, AreasMayBeLinesPointsOrUnknown) {
  EXPECT_EQ(distance_from_area_m({}, {3, 4}), 0.0);
  EXPECT_NEAR(distance_from_area_m({{0, 0}}, {3, 4}), 5.0, 1e-12);
  EXPECT_NEAR(distance_from_area_m({{0, 0}, {10, 0}}, {5, 2}), 2.0, 1e-12);
  EXPECT_NEAR(distance_from_area_m({{0, 0}, {10, 0}}, {5, -2}), 2.0, 1e-12);
  EXPECT_EQ(distance_from_area_m({{0, 0}, {10, 0}, {10, 5}}, {9, 1}), 0.0);
}

Deployment of_new_year() {
  Deployment d = ten_by_five();
  d.created = "2026-01-01T00:00:00Z";
  d.tolerance.beacon_m = 0.024477;  // ten millimetres, one sigma
  d.beacons = {{.name = "A"}, {.name = "B"}, {.name = "C", .status = BeaconStatus::kUndetermined}};
  d.beacons[1].covariance_m2(1, 1) = 0.006 * 0.006;
  d.beacons[2].covariance_m2 = Eigen::Matrix3d::Identity();
  return d;
}

double due_after_months(const Deployment& d) {
  const auto due = calibration_due(d);
  return due ? static_cast<double>(due->at_s - *utc_seconds(d.created)) / (30.44 * 86400.0) : -1.0;
}

TEST(Validity, ARecalibrationIsDueByTheCalendar) {
  Deployment d = of_new_year();
  EXPECT_FALSE(calibration_due(d)) << "nothing is stated";
  d.validity_period.months = 12.0;
  EXPECT_NEAR(due_after_months(d), 12.0, 1e-6);
  EXPECT_FALSE(calibration_due(d)->by_drift());
  d.created = "last spring";
  EXPECT_FALSE(calibration_due(d));
}

TEST(Validity, ARecalibrationIsDueWhenABeaconMayHaveLeftTheTolerance) {
  Deployment d = of_new_year();
  d.validity_period.beacon_drift_m_per_month = 0.001;
  EXPECT_NEAR(due_after_months(d), 8.0, 1e-3) << "6 mm and 8 mm make 10 mm";
  EXPECT_EQ(calibration_due(d)->beacon, "B");
  d.validity_period.months = 3.0;
  EXPECT_NEAR(due_after_months(d), 3.0, 1e-6) << "whichever is sooner";
  EXPECT_FALSE(calibration_due(d)->by_drift());
  d.validity_period.months.reset();
  d.beacons[1].covariance_m2(1, 1) = 0.02 * 0.02;
  EXPECT_EQ(due_after_months(d), 0.0) << "it was never within";
  d.beacons[1].covariance_m2(1, 1) = 0.0;
  d.validity_period.beacon_drift_m_per_month = 1e-6;
  EXPECT_FALSE(calibration_due(d)) << "in eight hundred years";
}

}  // namespace validity_test
}  // namespace octant
