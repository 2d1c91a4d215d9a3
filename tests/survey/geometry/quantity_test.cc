// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/quantity.h"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "models/simulator/random.h"

namespace octant::survey {
namespace quantity_test {

/// Number and unit of "2.41 mm".
struct Read {
  double number = 0.0;
  std::string unit;
};
Read read(const std::string& text) {
  const std::size_t blank = text.find(' ');
  EXPECT_NE(blank, std::string::npos) << text;
  EXPECT_EQ(text.substr(0, blank).find('e'), std::string::npos) << text << " is no number that people write";
  return {std::stod(text.substr(0, blank)), text.substr(blank + 1)};
}

double metres_of_unit(const std::string& unit) { return unit == "m" ? 1.0 : unit == "mm" ? 1e-3 : 0.0; }
double seconds_of_unit(const std::string& unit) {
  return unit == "s" ? 1.0 : unit == "ms" ? 1e-3 : unit == "us" || unit == "µs" ? 1e-6 : 1e-9;
}

TEST(Quantity, ALengthReadsBackToItsThreeDigits) {
  Random draws(20261125);
  for (int i = 0; i < 20000; ++i) {
    const double length_m = draws.log_uniform(1e-6, 1e5) * (i % 2 == 0 ? 1 : -1);
    const Read text = read(length_text(length_m));
    // Half a unit of the third digit is at most 0.5 % of the number.
    EXPECT_NEAR(text.number * metres_of_unit(text.unit), length_m, 0.00501 * std::abs(length_m))
        << length_text(length_m);
  }
}

TEST(Quantity, ALengthBelowAMetreThatRoundsToOneIsAMetre) {
  EXPECT_EQ(length_text(0.9994), "999 mm");
  EXPECT_EQ(length_text(0.9996), "1 m");
  EXPECT_EQ(length_text(std::nextafter(1.0, 0.0)), "1 m");
  EXPECT_EQ(length_text(-0.9999), "-1 m");
}

TEST(Quantity, LongLengthsHaveAllTheirMetres) {
  EXPECT_EQ(length_text(3.2), "3.2 m");
  EXPECT_EQ(length_text(999.4), "999 m");
  EXPECT_EQ(length_text(999.6), "1000 m");
  EXPECT_EQ(length_text(12345.6), "12346 m");
}

TEST(Quantity, LengthsThatNobodyReadsInMetresAreInMillimetres) {
  EXPECT_EQ(length_text(0.00241), "2.41 mm");
  EXPECT_EQ(length_text(0.0), "0 mm");
  EXPECT_EQ(length_text(-0.0301), "-30.1 mm");
  EXPECT_EQ(length_unit(0.5).name, "mm");
  EXPECT_EQ(length_unit(0.5).per_si, 1e3);
  EXPECT_EQ(length_unit(1.0).name, "m");
}

TEST(Quantity, ATimeReadsBackToItsFourDigits) {
  Random draws(20261126);
  for (int i = 0; i < 20000; ++i) {
    const double time_s = draws.log_uniform(1e-12, 9e3) * (i % 2 == 0 ? 1 : -1);
    const Read text = read(time_text(time_s));
    EXPECT_NEAR(text.number * seconds_of_unit(text.unit), time_s, 0.000501 * std::abs(time_s));
    // The printed one differs in the letter alone.
    std::string printed = time_symbol_text(time_s);
    if (const auto at = printed.find("µ"); at != std::string::npos) printed.replace(at, 2, "u");
    EXPECT_EQ(printed, time_text(time_s));
  }
}

TEST(Quantity, AColumnsUnitSuitsItsLargestNumber) {
  for (const auto& [largest_s, name] : {std::pair{0.5e-9, "ns"},
                                        {0.9e-7, "ns"},
                                        {1e-7, "us"},
                                        {9.99e-4, "us"},
                                        {1e-3, "ms"},
                                        {0.999, "ms"},
                                        {1.0, "s"},
                                        {100.0, "s"}}) {
    const Unit unit = time_unit(largest_s);
    EXPECT_EQ(unit.name, name) << largest_s;
    EXPECT_NEAR(unit.per_si * seconds_of_unit(unit.name), 1.0, 1e-15) << "the unit is what its name says";
    EXPECT_NEAR(unit.per_si * seconds_of_unit(unit.symbol), 1.0, 1e-15);
  }
  EXPECT_EQ(time_unit(0.0).name, "us") << "a column of zeros is one of delays";
  EXPECT_EQ(time_unit(std::numeric_limits<double>::quiet_NaN()).name, "s");
}

TEST(FigureText, IsAsPeopleReadIt) {
  EXPECT_EQ(figure_text(0.0421, "m"), "42.1 mm");
  EXPECT_EQ(figure_text(0.0994, "m"), "99.4 mm");
  EXPECT_EQ(figure_text(0.0996, "m"), "0.0996 m");
  EXPECT_EQ(figure_text(3.2, "m"), "3.2 m");
  EXPECT_EQ(figure_text(1.414, ""), "1.41");
  EXPECT_EQ(figure_text(0.25, "rad"), "0.25 rad");
  EXPECT_EQ(figure_text(std::numeric_limits<double>::infinity(), "m"), "no fix");
  EXPECT_EQ(figure_text(1234.5, "m"), "1234 m") << "nobody reads 1.23e+03";
  EXPECT_EQ(figure_text(2500, ""), "2500");
}

}  // namespace quantity_test
}  // namespace octant::survey
