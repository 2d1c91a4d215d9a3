// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/chi_square.h"

#include <cmath>

#include <gtest/gtest.h>

namespace octant {
namespace chi_square_test {

TEST(ChiSquare, TailAgreesWithTheTables) {
  // NIST/SEMATECH e-Handbook, table 1.3.6.7.4: upper critical values, printed to three decimals.
  struct Printed {
    int degrees_of_freedom;
    double at_5_percent, at_1_in_1000;
  };
  for (const Printed& row :
       {Printed{1, 3.841, 10.828}, Printed{2, 5.991, 13.816}, Printed{3, 7.815, 16.266},
        Printed{4, 9.488, 18.467}, Printed{7, 14.067, 24.322}, Printed{10, 18.307, 29.588},
        Printed{60, 79.082, 99.607}, Printed{99, 123.225, 148.230}}) {
    EXPECT_NEAR(chi_square_tail(row.at_5_percent, row.degrees_of_freedom), 0.05, 2e-5)
        << row.degrees_of_freedom;
    EXPECT_NEAR(chi_square_tail(row.at_1_in_1000, row.degrees_of_freedom), 0.001, 1e-6)
        << row.degrees_of_freedom;
    EXPECT_NEAR(chi_square_beyond(0.05, row.degrees_of_freedom), row.at_5_percent, 6e-4)
        << row.degrees_of_freedom;
  }
  EXPECT_DOUBLE_EQ(chi_square_tail(0, 3), 1.0);
}

TEST(ChiSquare, LogarithmGoesOnWhereTheProbabilityIsNone) {
  EXPECT_EQ(chi_square_tail(5000, 3), 0.0);
  EXPECT_DOUBLE_EQ(log_chi_square_tail(5000, 2), -2500.0);
  // Q = erfc(sqrt(x/2)) is about exp(-x/2) / sqrt(pi x / 2) (1 - 1/x), with a relative error of 3 / x^2.
  EXPECT_NEAR(log_chi_square_tail(5000, 1), -2500 - 0.5 * std::log(M_PI * 2500) + std::log1p(-1.0 / 5000),
              2e-7);
  // Both forms of the scaled error function meet at x = 50.
  EXPECT_NEAR(log_chi_square_tail(49.9999999, 1), log_chi_square_tail(50.0000001, 1), 2e-7);
}

}  // namespace chi_square_test
}  // namespace octant
