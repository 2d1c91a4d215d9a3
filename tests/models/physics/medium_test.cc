// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/medium.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/golden.h"

namespace octant {
namespace medium_test {

constexpr double kDecibelsPerNeper = 8.685889638065037;  // 20 / ln 10

TEST(Medium, SpeedHasThePrintedDigits) {
  for (const auto& c : test::golden_cases("speed_of_sound")) {
    Medium medium;
    medium.model = c["model"] == "cramer1993" ? MediumModel::kCramer1993 : MediumModel::kLinearTemperature;
    medium.relative_humidity = c.value("relative_humidity", 0.5);
    medium.pressure_pa = c.value("pressure_pa", 101325.0);
    EXPECT_NEAR(speed_mps(medium, c["temperature_degC"]), c["speed_mps"].get<double>(),
                c["half_digit_mps"].get<double>())
        << c;
  }
}

TEST(Medium, OneKelvinIs18MillimetresInTenMetres) {
  const Medium medium{.model = MediumModel::kCramer1993};
  const double by_kelvin = (speed_mps(medium, 20.5) - speed_mps(medium, 19.5)) / speed_mps(medium, 20.0);
  EXPECT_NEAR(by_kelvin * 1e6, 1816, 0.5);  // ppm, the design notes' digits
}

TEST(Medium, SpeedGrowsWithTemperatureAndHumidityInTheStatedRange) {
  Medium medium{.model = MediumModel::kCramer1993};
  for (double pressure_pa : {75e3, 102e3}) {
    medium.pressure_pa = pressure_pa;
    for (double t = 0; t < 30; t += 0.5) {
      for (double humidity = 0; humidity < 1; humidity += 0.1) {
        medium.relative_humidity = humidity;
        const double here = speed_mps(medium, t);
        EXPECT_GT(speed_mps(medium, t + 0.5), here);
        medium.relative_humidity = humidity + 0.1;
        EXPECT_GT(speed_mps(medium, t), here);
      }
    }
  }
}

TEST(Medium, ConstantKnowsNoTemperature) {
  const Medium medium{.model = MediumModel::kConstant, .speed_mps = 2.998e8};
  EXPECT_EQ(speed_mps(medium, -40.0), 2.998e8);
  EXPECT_EQ(speed_mps(medium), 2.998e8);
}

TEST(Medium, TheAirOfASpeedHasThatSpeed) {
  for (const Medium& medium :
       {Medium{.model = MediumModel::kCramer1993}, Medium{.model = MediumModel::kLinearTemperature}})
    for (const double t : {-30.0, 0.0, 17.3, 41.0})
      EXPECT_NEAR(temperature_at(medium, speed_mps(medium, t)).value(), t, 1e-8);
  EXPECT_NEAR(temperature_at({.model = MediumModel::kLinearTemperature}, 343.42).value(), 20.0, 1e-8);
  EXPECT_FALSE(temperature_at({.model = MediumModel::kCramer1993}, 1480.0)) << "water";
  EXPECT_FALSE(temperature_at({.model = MediumModel::kConstant}, 343.0));
}

TEST(Medium, ReferenceTemperatureIsTheDefault) {
  const Medium medium{.model = MediumModel::kLinearTemperature, .temperature_degC = 25.0};
  EXPECT_EQ(speed_mps(medium), speed_mps(medium, 25.0));
}

TEST(Medium, AbsorptionHasThePrintedDigits) {
  for (const auto& c : test::golden_cases("absorption")) {
    const double np_per_m =
        air_absorption_np_per_m(c["frequency_hz"], c["temperature_degC"], c["relative_humidity"], 101325.0);
    EXPECT_NEAR(np_per_m * kDecibelsPerNeper * 1000, c["db_per_km"].get<double>(),
                c["half_digit_db_per_km"].get<double>())
        << c;
  }
}

TEST(Medium, AbsorptionAt40kHzPeaksBetweenDryAndWet) {
  const auto at = [](double humidity) { return air_absorption_np_per_m(40e3, 20.0, humidity, 101325.0); };
  EXPECT_GT(at(0.55), at(0.1));
  EXPECT_GT(at(0.55), at(1.0));
}

TEST(Medium, NamesAreThoseOfTheSiteFile) {
  EXPECT_EQ(to_string(MediumModel::kConstant), "constant");
  EXPECT_EQ(to_string(MediumModel::kLinearTemperature), "linear_temperature");
  EXPECT_EQ(to_string(MediumModel::kCramer1993), "cramer1993");
}

}  // namespace medium_test
}  // namespace octant
