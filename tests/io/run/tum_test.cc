// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/tum.h"

#include "tests/io/io_support.h"

namespace octant::io {
namespace tum_test {

using test::expect_error;

Result<std::vector<TimedPose>> parse(const std::string& text) { return tum_from_text(text, "p.tum"); }

TEST(Tum, ReadsRowsCommentsAndMarks) {
  const auto poses =
      parse("\xEF\xBB\xBF# head\r\n\r\n1 2 3 4 0 0 0 2\r\n  2.5\t0 0 0 0 0 1 0 # turned\r\n").value();
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].T_map_vehicle.translation_m, Eigen::Vector3d(2, 3, 4));
  EXPECT_EQ(poses[0].T_map_vehicle.rotation.w(), 1.0) << "normalised";
  EXPECT_NEAR(std::abs(poses[1].T_map_vehicle.heading_rad()), M_PI, 1e-15);
  EXPECT_TRUE(parse("").value().empty());
}

TEST(Tum, SaysWhatIsWrongAndWhere) {
  expect_error(parse("# c\n1 0 0 0 0 0 0\n"), 2, "7 fields", "p.tum");
  expect_error(parse("1 0 0 0 0 0 0 1 9\n"), 1, "more than 8 fields");
  expect_error(parse("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"), 2, "strictly increasing");
  expect_error(parse("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"), 2, "strictly increasing");
  expect_error(parse("1 0 0 0 0 0 0 0\n"), 1, "quaternion of no length");
  expect_error(parse("1 0 nan 0 0 0 0 1\n"), 1, "'nan'; expected a finite number");
  expect_error(parse("1 x 0 0 0 0 0 1\n"), 1, "p.tum:1:3: 'x'");
  expect_error(parse("1 0 -1e160 0 0 0 0 1\n"), 1, "p.tum:1:5: '-1e160'; expected metres, at most 1e9");
  expect_error(parse("1,0,0,0,0,0,0,1\n"), 1, "no commas");
  expect_error(parse("1 0 0 0 0 0 0 1\n\xFF\n"), 2, "0xFF");
}

TEST(Tum, ReadsBackWhatItWrote) {
  EXPECT_TRUE(rc::check("read(write(x)) == x", [] {
    std::vector<TimedPose> poses(static_cast<std::size_t>(*rc::gen::inRange(0, 8)));
    double time_s = test::some_number();
    for (TimedPose& pose : poses) {
      pose.time_s = time_s += 1.0 + test::some_positive();
      pose.T_map_vehicle.translation_m = {test::some_number(), test::some_number(), test::some_number()};
      pose.T_map_vehicle.rotation =
          exp_rotation({test::some_fraction(), 3 * test::some_fraction(), -test::some_fraction()});
    }
    const auto back = parse(poses_to_tum(poses));
    RC_ASSERT(back.has_value());
    RC_ASSERT(back->size() == poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      RC_ASSERT((*back)[i].time_s == poses[i].time_s);
      RC_ASSERT((*back)[i].T_map_vehicle.translation_m == poses[i].T_map_vehicle.translation_m);
      RC_ASSERT((*back)[i].T_map_vehicle.rotation.coeffs() == poses[i].T_map_vehicle.rotation.coeffs());
    }
  }));
}

Fix some_fix(FixStatus status) {
  Fix fix;
  fix.status = status;
  fix.time_s = 1.5;
  fix.vehicle = VehicleId(0);
  fix.T_map_vehicle = Pose::planar(1, 2, 0.5);
  fix.covariance = Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal();
  fix.arrivals_used = 7;
  fix.arrivals_rejected = 1;
  return fix;
}

TEST(Fixes, TumHoldsThoseThatAreOk) {
  const auto poses =
      parse(fixes_to_tum({some_fix(FixStatus::kOk), some_fix(FixStatus::kPoorGeometry)})).value();
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_NEAR(poses[0].T_map_vehicle.heading_rad(), 0.5, 1e-15);
}

TEST(Fixes, CsvHoldsAllWithTheirStatus) {
  const NameTable names{.beacons = {}, .vehicles = {"a,b"}, .receivers = {}};
  Fix protected_fix = some_fix(FixStatus::kOk);
  protected_fix.T_map_vehicle = {{1, 2, 0}, Eigen::Quaterniond::Identity()};
  protected_fix.protection_level_m = 0.25;
  protected_fix.covariance(0, 1) = protected_fix.covariance(1, 0) = 0.02;
  protected_fix.velocity = VelocityEstimate{};
  protected_fix.velocity->mean << 0.5, 0, 0, 0, 0, 0.1;
  EXPECT_EQ(
      fixes_to_csv({protected_fix, some_fix(FixStatus::kTooFewArrivals)}, names),
      "time_s,vehicle,x_m,y_m,z_m,heading_rad,sigma_x_m,sigma_y_m,sigma_heading_rad,protection_level_m,"
      "arrivals_used,"
      "arrivals_rejected,status,integrity,integrity_reason,velocity_x_mps,velocity_y_mps,velocity_z_mps,"
      "turn_rate_x_radps,turn_rate_y_radps,turn_rate_z_radps,covariance_x_x,covariance_x_y,covariance_x_z,"
      "covariance_x_turn_x,covariance_x_turn_y,covariance_x_turn_z,covariance_y_y,covariance_y_z,"
      "covariance_y_turn_x,covariance_y_turn_y,covariance_y_turn_z,covariance_z_z,covariance_z_turn_x,"
      "covariance_z_turn_y,covariance_z_turn_z,covariance_turn_x_turn_x,covariance_turn_x_turn_y,"
      "covariance_turn_x_turn_z,covariance_turn_y_turn_y,covariance_turn_y_turn_z,covariance_turn_z_turn_z\n"
      "1.5,\"a,b\",1,2,0,0,0.2,0.3,0.1,0.25,7,1,ok,ok,,0.5,0,0,0,0,0.1,"
      "0.04,0.02,0,0,0,0,0.09,0,0,0,0,0,0,0,0,0,0,0,0,0,0.01\n"
      "1.5,\"a,b\",,,,,,,,,7,1,too_few_arrivals,no_fix,too_few_arrivals" +
          std::string(27, ',') + "\n");
}

/// The heading's variance of a spatial fix against a numeric derivative of heading_rad().
TEST(Fixes, HeadingSigmaOfATiltedVehicle) {
  Fix fix = some_fix(FixStatus::kOk);
  fix.T_map_vehicle.rotation = exp_rotation({0.3, -0.5, 1.1});
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Zero();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) root(i, j) = 0.01 * (1 + i + 2 * j);
  }
  fix.covariance = root * root.transpose();
  Eigen::RowVector3d gradient;
  const double step = 1e-6;
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d delta = Eigen::Vector3d::Zero();
    delta[i] = step;
    const Pose plus{{}, fix.T_map_vehicle.rotation * exp_rotation(delta)},
        minus{{}, fix.T_map_vehicle.rotation * exp_rotation(-delta)};
    gradient[i] = (plus.heading_rad() - minus.heading_rad()) / (2 * step);
  }
  const double expected =
      std::sqrt((gradient * fix.covariance.block<3, 3>(3, 3) * gradient.transpose()).value());
  const std::string row = fixes_to_csv({fix}, {{}, {"robot"}, {}});
  std::stringstream fields(row.substr(row.find('\n') + 1));
  std::string field;
  for (int i = 0; i < 9; ++i) std::getline(fields, field, ',');
  EXPECT_NEAR(std::stod(field), expected,
              1e-8 * expected);  // central differences: step^2 and rounding / step
}

}  // namespace tum_test
}  // namespace octant::io
