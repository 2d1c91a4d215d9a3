// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/column_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace octant::io {
namespace column_unit_test {

using ::testing::HasSubstr;

TEST(ColumnUnit, IsReadFromTheEndOfTheName) {
  const struct {
    const char *name, *target;
    double factor;
  } cases[] = {{"timestamp_ms", "time_s", 1e-3},
               {"Laufzeit [ms]", "tof_s", 1e-3},
               {"Laufzeit[\xC2\xB5s]", "tof_s", 1e-6},
               {"range (cm)", "distance_m", 1e-2},
               {"Distance in ft", "distance_m", 0.3048},
               {"range in in", "distance_m", 0.0254},
               {"micros", "time_s", 1e-6},
               {"millis", "time_s", 1e-3},
               {"MS", "time_s", 1e-3},
               {"peak_mV", "amplitude_v", 1e-3},
               {"t", "time_s", 1.0},
               {"time_s_of_day", "time_s", 1.0},
               {"m", "distance_m", 1.0},
               {"tof_min", "tof_s", 1.0},
               {"r_in", "distance_m", 1.0},
               {"dwell [min]", "time_s", 60.0},
               {"air_degC", "temperature_degC", 1.0},
               {"s", "distance_m", 1.0}};
  for (const auto& c : cases) {
    const auto unit = unit_of_column(c.name, c.target);
    ASSERT_TRUE(unit) << c.name;
    EXPECT_DOUBLE_EQ(unit->factor, c.factor) << c.name;
    EXPECT_EQ(unit->offset, 0.0) << c.name;
  }
}

TEST(ColumnUnit, TemperaturesAreConverted) {
  const auto fahrenheit = unit_of_column(
      "T [\xC2\xB0"
      "F]",
      "temperature_degC");
  ASSERT_TRUE(fahrenheit);
  EXPECT_NEAR(fahrenheit->factor * 68.0 + fahrenheit->offset, 20.0, 1e-12);
  const auto kelvin = unit_of_column("T (K)", "temperature_degC");
  ASSERT_TRUE(kelvin);
  EXPECT_NEAR(kelvin->factor * 293.15 + kelvin->offset, 20.0, 1e-12);
}

TEST(ColumnUnit, UnknownUnitsAndUnitsOfOtherQuantitiesAreErrors) {
  const auto found = [](const char* name, const char* target) {
    const auto unit = unit_of_column(name, target);
    return unit ? std::string() : unit.error().message();
  };
  EXPECT_THAT(found("Laufzeit [ticks]", "tof_s"),
              HasSubstr("column 'Laufzeit [ticks]' states the unit 'ticks'"));
  EXPECT_THAT(found("Laufzeit [ticks]", "tof_s"), HasSubstr("tof_s=Laufzeit [ticks]*FACTOR"));
  EXPECT_THAT(found("range_ms", "distance_m"), HasSubstr("column 'range_ms' is in 'ms'"));
  EXPECT_THAT(found("range (cm)", "tof_s"), HasSubstr("is in 'cm'"));
}

}  // namespace column_unit_test
}  // namespace octant::io
