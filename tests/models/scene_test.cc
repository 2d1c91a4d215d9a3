// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/scene.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/simulator/random.h"

namespace octant::test {
namespace scene_test {

using Kind = BeamPattern::Kind;

BeamPattern pattern(Kind kind, double half_angle_rad = 1.0) {
  BeamPattern p;
  p.kind = kind;
  p.half_angle_rad = half_angle_rad;
  return p;
}

double at(const BeamPattern& p, double angle_rad) { return beam_gain(p, std::cos(angle_rad)); }

TEST(BeamGain, OfAConeIsOneUpToItsAngle) {
  const BeamPattern cone = pattern(Kind::kCone);
  EXPECT_EQ(at(cone, 0.0), 1.0);
  EXPECT_EQ(at(cone, 0.999), 1.0);
  EXPECT_EQ(at(cone, 1.001), 0.0);
  const BeamPattern all_round = pattern(Kind::kCone, 3.2);
  EXPECT_EQ(beam_gain(all_round, -1.0), 1.0) << "pi or more: all round";
}

TEST(BeamGain, OfACosineIsItsPower) {
  BeamPattern cosine = pattern(Kind::kCosinePower, 1.5);
  cosine.exponent = 3.0;
  EXPECT_NEAR(at(cosine, 1.0), std::pow(std::cos(1.0), 3), 1e-15);
  cosine.half_angle_rad = 3.2;
  EXPECT_EQ(at(cosine, 1.7), 0.0) << "nothing behind";
  EXPECT_EQ(at(cosine, M_PI), 0.0);
}

TEST(BeamGain, OfAHalfPowerAngleIsThreeDecibelsDownThere) {
  BeamPattern bell = pattern(Kind::kHalfPower, 3.2);
  bell.half_power_angle_rad = 0.7;
  EXPECT_EQ(at(bell, 0.0), 1.0);
  EXPECT_NEAR(at(bell, 0.7), std::sqrt(0.5), 1e-12);
  bell.half_angle_rad = 0.6;
  EXPECT_EQ(at(bell, 0.7), 0.0);
}

TEST(BeamGain, OfATableIsLinearBetweenItsAngles) {
  BeamPattern table = pattern(Kind::kTable);
  table.angle_rad = {0.0, 0.5, 1.0};
  table.gain = {1.0, 0.8, 0.2};
  EXPECT_NEAR(at(table, 0.25), 0.9, 1e-12);
  EXPECT_NEAR(at(table, 0.75), 0.5, 1e-12);
  EXPECT_NEAR(at(table, 0.9999999), 0.2, 1e-6);
  EXPECT_EQ(at(table, 1.01), 0.0) << "beyond the last angle";
  EXPECT_EQ(at(pattern(Kind::kTable), 0.0), 0.0) << "an empty one";
}

// Cosines come from products of unit vectors and may be a rounding beyond one.
RC_GTEST_PROP(BeamGain, IsANumberThatDoesNotRiseOffTheAxis, ()) {
  BeamPattern p =
      pattern(*rc::gen::element(Kind::kCone, Kind::kCosinePower, Kind::kHalfPower, Kind::kTable), 1.2);
  p.angle_rad = {0.0, 0.4, 1.5, 3.1};
  p.gain = {1.0, 0.7, 0.3, 0.1};
  double before = 1.0;
  for (double cosine = 1.0 + 1e-12; cosine > -1.0 - 1e-12; cosine -= 0.01) {
    const double gain = beam_gain(p, cosine);
    RC_ASSERT(gain >= 0.0 && gain <= before + 1e-12);
    before = gain;
  }
  RC_ASSERT(beam_gain(p, -1.0 - 1e-15) >= 0.0);
}

}  // namespace scene_test
}  // namespace octant::test
