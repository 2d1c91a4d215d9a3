// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Shoval and Borenstein's experiments, from the burst to the pose, against the errors that the paper reports.
#include <algorithm>
#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "tests/models/localizers/binaural_world.h"

namespace octant {
namespace binaural_figures_test {

using test::chirp;
using test::kDegree;
using test::Obstruction;
using test::Sonar;
using test::two_robots;

constexpr std::uint64_t kSeed = 3;

struct Errors {
  int fixes = 0, tried = 0;
  double max_m = 0.0, max_deg = 0.0, sum_m = 0.0, sum_deg = 0.0;
  [[nodiscard]] double mean_m() const { return sum_m / fixes; }
  [[nodiscard]] double mean_deg() const { return sum_deg / fixes; }
};

std::ostream& operator<<(std::ostream& out, const Errors& e) {
  return out << e.fixes << " of " << e.tried << " fixes, position mean " << 1e3 * e.mean_m() << " max "
             << 1e3 * e.max_m << " mm, orientation mean " << e.mean_deg() << " max " << e.max_deg << " deg";
}

/// The laboratory: what delays the electronics and the threshold bring at 1.5 m is calibrated away.
class Laboratory : public testing::Test {
 protected:
  Laboratory() : random_(kSeed), deployment_(two_robots(1e-6)) {
    const Pose bench = opposite(1.5, 0.0, 0.0);
    double late_s = 0.0;
    for (const Arrival& a : chirp(deployment_, bench, sonar_, random_))
      late_s += (a.tof_s - test::distance_m(deployment_, bench, a.beacon.value, a.receiver.value) /
                               deployment_.speed_mps(20.0)) /
                4;
    for (DeploymentBeacon& b : deployment_.beacons) b.delay_s = late_s;
  }

  static Pose opposite(double x_m, double y_m, double turn_rad) {
    return Pose::planar(x_m, y_m, std::numbers::pi + turn_rad);
  }

  void measure(const Pose& truth, Errors& errors, const BinauralOptions& options = {},
               const Obstruction& way = {}) {
    Binaural localizer(deployment_, options);
    const Fix fix = localizer.locate(Observations{chirp(deployment_, truth, sonar_, random_, way), {}});
    ++errors.tried;
    if (!fix.ok()) return;
    ++errors.fixes;
    const double off_m = (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>().norm();
    const double off_deg =
        std::abs(wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad())) / kDegree;
    errors.max_m = std::max(errors.max_m, off_m);
    errors.max_deg = std::max(errors.max_deg, off_deg);
    errors.sum_m += off_m;
    errors.sum_deg += off_deg;
  }

  Random random_;
  Sonar sonar_;
  Deployment deployment_;
};

TEST_F(Laboratory, Figure5Range) {
  Errors near, far;
  for (double x = 0.5; x < 5.01; x += 0.1) measure(opposite(x, 0.0, 0.0), x <= 3.0 ? near : far);
  std::cout << "to 3 m: " << near << "\nto 5 m: " << far << "\n";
  EXPECT_EQ(near.fixes, near.tried);
  EXPECT_EQ(far.fixes, far.tried);
  EXPECT_LT(near.max_m, 0.03);  // paper: 3 cm to 3 m, 10 cm to 5.5 m
  EXPECT_LT(far.max_m, 0.10);
  EXPECT_LT(std::max(near.max_deg, far.max_deg), 0.05);  // paper: within 0.05 deg throughout
}

/// Far out a weaker signal loses its first cycle, on one receiver sooner than on the other: 6.9 mm, 1.1
/// degrees. The fourth range finds it (2.5 mm of misclosure or more, against four sigma of 0.34 mm), so that
/// there is no wrong fix.
TEST_F(Laboratory, ALostCycleIsFound) {
  sonar_.threshold_v = 0.02;
  Errors errors;
  for (double x = 3.0; x < 5.01; x += 0.02) measure(opposite(x, 0.0, 0.0), errors);
  std::cout << errors << "\n";
  EXPECT_LT(errors.fixes, errors.tried);
  EXPECT_GT(errors.fixes, errors.tried / 2);
  EXPECT_LT(errors.max_deg, 0.05);
  EXPECT_LT(errors.max_m, 0.10);
}

TEST_F(Laboratory, Figure6Offset) {
  Errors errors;
  for (double y = -0.29; y < 0.291; y += 0.02) measure(opposite(1.5, y, 0.0), errors);
  std::cout << errors << "\n";
  EXPECT_EQ(errors.fixes, errors.tried);
  EXPECT_LT(errors.max_m, 0.03);      // paper: below 3 cm
  EXPECT_LT(errors.mean_m(), 0.010);  // 1.0 cm
  EXPECT_LT(errors.max_deg, 1.2);
  EXPECT_LT(errors.mean_deg(), 0.4);
}

TEST_F(Laboratory, Figure7OffsetUnder9Point5Degrees) {
  Errors errors;
  for (double y = 0.01; y < 0.28; y += 0.01) measure(opposite(1.44, y, 9.5 * kDegree), errors);
  std::cout << errors << "\n";
  EXPECT_EQ(errors.fixes, errors.tried);
  EXPECT_LT(errors.max_deg, 0.7);  // paper: 0.7 deg; its mean of 0.02 deg is one of signed errors
  EXPECT_LT(errors.max_m, 0.03);   // 1 cm one way, 3 cm the other, of which most is the set-up's
}

TEST_F(Laboratory, Figure9Height) {
  Errors ignored, corrected;
  for (double z = -0.25; z < 0.251; z += 0.05) {
    Pose truth = opposite(1.5, 0.0, 0.0);
    truth.translation_m.z() = z;
    measure(truth, ignored);
    measure(truth, corrected, {.height_difference_m = z});
  }
  std::cout << "ignored: " << ignored << "\ncorrected: " << corrected << "\n";
  EXPECT_EQ(ignored.fixes, ignored.tried);
  EXPECT_LT(ignored.max_m, 0.04);  // paper: 4 cm and 1.5 deg up to 0.25 m
  EXPECT_LT(ignored.max_deg, 1.5);
  EXPECT_EQ(corrected.fixes, corrected.tried);
  EXPECT_LT(corrected.max_m, 0.5 * ignored.max_m);
}

TEST_F(Laboratory, Figure10Tilt) {
  Errors ignored, corrected;
  for (double tilt = -35; tilt < 36; tilt += 5) {
    Pose truth = opposite(1.5, 0.0, 0.0);
    truth.rotation = truth.rotation * Eigen::AngleAxisd(tilt * kDegree, Eigen::Vector3d::UnitY());
    const Pose level = opposite(1.5, 0.0, 0.0);
    Binaural blind(deployment_), knows(deployment_, {.pitch_rad = tilt * kDegree});
    const auto arrivals = chirp(deployment_, truth, sonar_, random_);
    for (auto [localizer, errors] : {std::pair{&blind, &ignored}, std::pair{&knows, &corrected}}) {
      const Fix fix = localizer->locate(Observations{arrivals, {}});
      ++errors->tried;
      if (!fix.ok()) continue;
      ++errors->fixes;
      errors->max_m =
          std::max(errors->max_m, (fix.T_map_vehicle.translation_m - level.translation_m).head<2>().norm());
      errors->max_deg =
          std::max(errors->max_deg,
                   std::abs(wrap_angle(fix.T_map_vehicle.heading_rad() - level.heading_rad())) / kDegree);
    }
  }
  std::cout << "ignored: " << ignored.max_m << " m " << ignored.max_deg
            << " deg, corrected: " << corrected.max_m << " m " << corrected.max_deg << " deg\n";
  EXPECT_EQ(ignored.fixes, ignored.tried);
  EXPECT_EQ(corrected.fixes, corrected.tried);
  EXPECT_LT(ignored.max_deg, 0.1);  // paper: orientation unaffected up to 35 deg
  EXPECT_LT(corrected.max_deg, 0.1);
  // The sonars are 0.3 m above the axis of the tilt, which displaces them by 0.17 m forward or back.
  EXPECT_NEAR(ignored.max_m, 0.3 * std::sin(35 * kDegree), 0.01);
  EXPECT_LT(corrected.max_m, 0.01);
}

TEST_F(Laboratory, Figure11Turn) {
  Errors errors;
  for (double turn = -24; turn < 24.5; turn += 2) measure(opposite(1.5, 0.0, turn * kDegree), errors);
  std::cout << errors << "\n";
  EXPECT_EQ(errors.fixes, errors.tried);
  EXPECT_LT(errors.mean_deg(), 0.06);  // paper
}

TEST_F(Laboratory, Table1Obstruction) {
  Errors none, partial, full, both;
  for (int k = 0; k < 5; ++k) {
    // A new setup each time, accurate to some centimetres and degrees.
    const Pose truth = opposite(1.5 + random_.uniform(-0.05, 0.05), random_.uniform(-0.05, 0.05),
                                random_.uniform(-4, 4) * kDegree);
    measure(truth, none);
    measure(truth, partial, {}, {.gain = {0.08, 1, 1, 1}, .detour_m = {0.015, 0, 0, 0}});
    measure(truth, full, {}, {.gain = {0.3, 1, 1, 1}, .detour_m = {0.13, 0, 0, 0}});
    measure(truth, both, {}, {.gain = {0, 0, 1, 1}, .detour_m = {}});
  }
  std::cout << "none: " << none << "\n";
  EXPECT_EQ(none.fixes, 5);
  EXPECT_LT(none.mean_deg(), 0.038);  // paper, table I row 1
  EXPECT_LT(none.mean_m(), 0.0023);
  // Rows 3 and 4: the paper reports 3.65 and 21.4 deg as fixes. The fourth range contradicts them.
  EXPECT_EQ(partial.fixes, 0);
  EXPECT_EQ(full.fixes, 0);
  EXPECT_EQ(both.fixes, 0);  // row 5: insufficient data
}

}  // namespace binaural_figures_test
}  // namespace octant
