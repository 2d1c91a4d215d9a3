// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/undetermined_words.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace octant::test {
namespace undetermined_words_test {

using calib::UndeterminedBeacon;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const UndeterminedBeacon kSilent{"A4", "it was not heard", "drive where it is heard", 0.0};

UndeterminedBeacon known_to(const std::string& beacon, double sigma_m) {
  return {beacon, "its position is known to " + calib::length_in_words(sigma_m) + " only", "tape it",
          sigma_m};
}

TEST(LengthInWords, IsInMillimetresBelowAMetreAndNothingBeyondTenKilometres) {
  EXPECT_EQ(calib::length_in_words(0.0), "0 mm");
  EXPECT_EQ(calib::length_in_words(0.0344), "34 mm");
  EXPECT_EQ(calib::length_in_words(0.9994), "999 mm");
  EXPECT_EQ(calib::length_in_words(1.0), "1.00 m");
  EXPECT_EQ(calib::length_in_words(12.345), "12.35 m");
  EXPECT_EQ(calib::length_in_words(calib::kNothingM), "nothing");
  EXPECT_EQ(calib::length_in_words(INFINITY), "nothing");
  EXPECT_EQ(calib::length_in_words(NAN), "nothing");
}

TEST(UndeterminedBeacons, OneIsNamedWithItsReason) {
  EXPECT_THAT(calib::in_groups({kSilent}, 0.03), ElementsAre("beacon A4 (it was not heard)"));
  EXPECT_THAT(calib::in_groups({known_to("A1", 0.034)}, 0.03),
              ElementsAre("beacon A1 (its position is known to 34 mm only)"));
  EXPECT_THAT(calib::in_groups({{"A1", "its height is known to 34 mm only", "measure it", 0.034},
                                {"A2", "its height is known to 49 mm only", "measure it", 0.049}},
                               0.03),
              ElementsAre("beacons A1, A2 (their heights are known to 34 mm to 49 mm only, the tolerance is "
                          "30 mm)"));
  EXPECT_THAT(calib::warnings_of({kSilent}, 0.03),
              ElementsAre("beacon A4 is undetermined: it was not heard; drive where it is heard"));
}

TEST(UndeterminedBeacons, KnownTooBadlyAreOneWithTheRangeOfTheirSigmas) {
  const std::vector<UndeterminedBeacon> beacons = {known_to("A2", 0.041), known_to("A1", 0.034),
                                                   known_to("A3", 0.049)};
  EXPECT_THAT(
      calib::in_groups(beacons, 0.03),
      ElementsAre(
          "beacons A2, A1, A3 (their positions are known to 34 mm to 49 mm only, the tolerance is 30 mm)"));
  EXPECT_THAT(
      calib::warnings_of(beacons, 0.03),
      ElementsAre("3 beacons are undetermined: A2, A1, A3 (their positions are known to 34 mm to 49 mm "
                  "only, the tolerance is 30 mm); tape it"));
  EXPECT_THAT(
      calib::in_groups({known_to("A1", 0.0341), known_to("A2", 0.0339)}, 0.03),
      ElementsAre("beacons A1, A2 (their positions are known to 34 mm only, the tolerance is 30 mm)"));
}

TEST(UndeterminedBeacons, ForDifferentReasonsOrRemediesStandApart) {
  UndeterminedBeacon far = known_to("A9", 0.5);
  far.remedy = "hear it";
  UndeterminedBeacon silent = kSilent;
  silent.beacon = "A5";
  EXPECT_THAT(
      calib::in_groups({kSilent, known_to("A1", 0.04), far, silent}, 0.03),
      ElementsAre("beacons A4, A5 (they were not heard)", "beacon A1 (its position is known to 40 mm only)",
                  "beacon A9 (its position is known to 500 mm only)"));
}

// A meaningless sigma is a separate reason, not a length.
TEST(UndeterminedBeacons, OfWhichNothingIsKnownHaveNoLength) {
  const UndeterminedBeacon nowhere{"A6", "its position is hardly known at all", "tape it", 1e5},
      too{"A7", "its position is hardly known at all", "tape it", INFINITY};
  EXPECT_THAT(calib::in_groups({nowhere, known_to("A1", 0.04), too}, 0.03),
              ElementsAre("beacons A6, A7 (its position is hardly known at all)",
                          "beacon A1 (its position is known to 40 mm only)"));
}

TEST(UndeterminedBeacons, OfNoneNothingIsSaid) {
  EXPECT_THAT(calib::in_groups({}, 0.03), IsEmpty());
  EXPECT_THAT(calib::warnings_of({}, 0.03), IsEmpty());
}

}  // namespace undetermined_words_test
}  // namespace octant::test
