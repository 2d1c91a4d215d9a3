// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/attenuation.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/support/golden.h"

namespace octant {
namespace attenuation_test {

TEST(TimeWalk, HasThePrintedDigits) {
  const auto file = test::golden("time_walk");
  AttenuationModel model;
  model.rise_time_s = file["rise_10_90_s"].get<double>() / std::log(9.0);
  for (const auto& c : file["cases"]) {
    model.threshold_v = c["threshold_over_amplitude"];
    const auto walk_s = time_walk_s(1.0, model);
    ASSERT_TRUE(walk_s);
    EXPECT_NEAR(*walk_s * file["speed_mps"].get<double>() * 1000, c["walk_mm"].get<double>(),
                c["half_digit_mm"].get<double>())
        << c;
  }
}

TEST(TimeWalk, BelowOrAtTheThresholdNothingIsHeard) {
  const AttenuationModel model{.threshold_v = 0.2, .rise_time_s = 4.5e-4};
  for (double amplitude : {0.0, 0.1, 0.2, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    const auto walk_s = time_walk_s(amplitude, model);
    ASSERT_FALSE(walk_s) << amplitude;
    EXPECT_EQ(walk_s.error().code, Errc::kNotHeard);
  }
  EXPECT_TRUE(time_walk_s(std::nextafter(0.2, 1.0), model));
}

TEST(TimeWalk, VanishesWithoutThresholdOrRise) {
  EXPECT_EQ(*time_walk_s(1.0, {.threshold_v = 0.0, .rise_time_s = 4.5e-4}), 0.0);
  EXPECT_EQ(*time_walk_s(1.0, {.threshold_v = 0.5, .rise_time_s = 0.0}), 0.0);
}

RC_GTEST_PROP(TimeWalk, EnvelopeCrossesTheThresholdThen, ()) {
  const double threshold_v = *rc::gen::inRange(1, 1000) * 1e-3;
  const double amplitude_v = threshold_v * (1.0 + *rc::gen::inRange(1, 100000) * 1e-3);
  const double tau_s = *rc::gen::inRange(1, 1000) * 1e-6;
  const double walk_s = *time_walk_s(amplitude_v, {.threshold_v = threshold_v, .rise_time_s = tau_s});
  const double envelope_v = amplitude_v * -std::expm1(-walk_s / tau_s);
  RC_ASSERT(walk_s > 0);
  // Two roundings, magnified by A/V in the logarithm's argument.
  RC_ASSERT(std::abs(envelope_v - threshold_v) < 1e-12 * amplitude_v);
}

RC_GTEST_PROP(TimeWalk, LouderIsEarlier, ()) {
  const AttenuationModel model{.threshold_v = 0.1, .rise_time_s = 4.5e-4};
  const double soft_v = 0.1 + *rc::gen::inRange(1, 10000) * 1e-3;
  RC_ASSERT(*time_walk_s(soft_v * 1.01, model) < *time_walk_s(soft_v, model));
}

TEST(Directivity, FallsByThreeDecibelsAtTheHalfPowerAngle) {
  for (const double angle_rad : {0.1, 0.3927, 1.0, 2.5}) {
    EXPECT_NEAR(log_directivity(1.0, angle_rad).value, 0.0, 1e-15);
    EXPECT_NEAR(std::exp(log_directivity(std::cos(angle_rad), angle_rad).value), 1 / std::sqrt(2.0), 1e-12)
        << angle_rad;
    double before = 1.0;
    for (double off_rad = 0.0; off_rad <= M_PI; off_rad += 0.01) {
      const LogDirectivity d = log_directivity(std::cos(off_rad), angle_rad);
      EXPECT_LE(d.value, before);
      EXPECT_TRUE(std::isfinite(d.value) && std::isfinite(d.by_cosine) &&
                  std::isfinite(d.by_half_power_angle))
          << off_rad;
      before = d.value;
    }
  }
  EXPECT_TRUE(std::isfinite(log_directivity(-1.0 - 1e-12, 0.4).value)) << "rounded beyond";
}

RC_GTEST_PROP(Directivity, DerivativesAreTheNumericOnes, ()) {
  const double angle_rad = 0.05 + *rc::gen::inRange(0, 2500) * 1e-3,
               cosine = -0.95 + *rc::gen::inRange(0, 1900) * 1e-3;
  const LogDirectivity d = log_directivity(cosine, angle_rad);
  constexpr double kStep = 1e-6;
  const double by_cosine =
      (log_directivity(cosine + kStep, angle_rad).value - log_directivity(cosine - kStep, angle_rad).value) /
      (2 * kStep);
  const double by_angle =
      (log_directivity(cosine, angle_rad + kStep).value - log_directivity(cosine, angle_rad - kStep).value) /
      (2 * kStep);
  RC_ASSERT(std::abs(d.by_cosine - by_cosine) < 1e-6 * (1 + std::abs(by_cosine)));
  RC_ASSERT(std::abs(d.by_half_power_angle - by_angle) < 1e-5 * (1 + std::abs(by_angle)));
}

TEST(TimeWalk, ByTheLogarithmOfTheAmplitude) {
  const AttenuationModel model{.threshold_v = 0.2, .rise_time_s = 4.5e-4};
  for (const double volts : {0.25, 0.5, 2.0, 10.0}) {
    constexpr double kStep = 1e-6;
    const double numeric =
        (*time_walk_s(volts * std::exp(-kStep), model) - *time_walk_s(volts * std::exp(kStep), model)) /
        (2 * kStep);
    EXPECT_NEAR(walk_by_log_amplitude_s(volts, model), numeric, 1e-6 * numeric) << volts;
  }
  EXPECT_NEAR(walk_by_log_amplitude_s(0.1, model), 19 * 4.5e-4, 1e-12) << "held below the threshold";
}

TEST(Attenuation, AnAmplitudeAtTheReceiversStopIsNoMeasurement) {
  AttenuationModel model;
  EXPECT_TRUE(model.measures(1e6));
  EXPECT_FALSE(model.measures(0.0) || model.measures(std::numeric_limits<double>::quiet_NaN()));
  model.saturation_v = 4.7;
  EXPECT_TRUE(model.measures(4.69));
  EXPECT_FALSE(model.measures(4.7));
}

TEST(Amplitude, SpreadsAndIsAbsorbed) {
  const AttenuationModel spreading{.amplitude_1m_v = 12.5};
  EXPECT_DOUBLE_EQ(amplitude_v(1.0, spreading), 12.5);
  EXPECT_DOUBLE_EQ(amplitude_v(5.0, spreading), 2.5);  // Kleeman's 1/d
  const AttenuationModel both{.amplitude_1m_v = 12.5, .absorption_np_per_m = 0.15};
  EXPECT_NEAR(amplitude_v(10.0, both), 1.25 * std::exp(-1.5), 1e-15);
}

}  // namespace attenuation_test
}  // namespace octant
