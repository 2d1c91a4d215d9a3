// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/change.h"

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "models/changes/change_sigmas.h"

namespace octant::test {
namespace change_test {

TEST(ChangeKind, IsFoundAgainByItsName) {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(ChangeKind::kAmplitude); ++i) {
    const auto kind = static_cast<ChangeKind>(i);
    EXPECT_EQ(change_kind(to_string(kind)), kind);
    EXPECT_TRUE(names.insert(to_string(kind)).second);
  }
  EXPECT_STREQ(to_string(ChangeKind::kBeaconMoved), "beacon_moved");
  EXPECT_EQ(change_kind("moved"), std::nullopt);
  EXPECT_EQ(change_kind(""), std::nullopt);
}

TEST(ChangeKind, HasTheUnitOfItsSize) {
  EXPECT_STREQ(unit_of(ChangeKind::kDelay), "s");
  EXPECT_STREQ(unit_of(ChangeKind::kSpeed), "m/s");
  EXPECT_STREQ(unit_of(ChangeKind::kAmplitude), "1");
  for (const ChangeKind kind :
       {ChangeKind::kBeaconMoved, ChangeKind::kReceiver, ChangeKind::kExchanged, ChangeKind::kDatum})
    EXPECT_STREQ(unit_of(kind), "m");
}

TEST(Drift, AfterNoTimeIsTheDefaultAndGrowsAsTheRootOfSquares) {
  const auto after = [](double months) { return drift_after(months, {}, 340.0); };
  const Drift now = after(0.0);
  EXPECT_EQ(now.beacon_m, Drift().beacon_m);
  EXPECT_EQ(now.attenuation, Drift().attenuation);
  EXPECT_EQ(after(-5.0).delay_s, now.delay_s) << "time does not run backwards";
  EXPECT_EQ(after(std::nan("")).delay_s, now.delay_s);
  // 0.1 mm a month in addition to 1 mm: after ten months the root of two.
  EXPECT_NEAR(after(10.0).beacon_m, std::sqrt(2.0) * 1e-3, 1e-15);
  EXPECT_NEAR(after(10.0).delay_s, std::sqrt(2.0) * 1e-3 / 340.0, 1e-15);
  EXPECT_NEAR(after(1e6).speed_mps, 3e4, 1.0);
}

TEST(Drift, OfDelaysIsARangeByTheKindOfMedium) {
  EXPECT_NEAR(340.0 * drift_after(0.0, {}, 340.0).delay_s, 1e-3, 1e-12);
  EXPECT_NEAR(1500.0 * drift_after(0.0, {}, 1500.0).delay_s, 0.01, 1e-12);
  EXPECT_NEAR(2.997e8 * drift_after(0.0, {}, 2.997e8).delay_s, 0.02, 1e-12);
}

TEST(Drift, RatesOfTheSiteReplaceThoseOfTheMedium) {
  const Drift drift = drift_after(12.0, {.beacon_m_per_year = 0.5, .delay_m_per_year = 3.0}, 2.997e8);
  EXPECT_NEAR(drift.beacon_m, 0.5, 1e-4);
  EXPECT_NEAR(2.997e8 * drift.delay_s, 3.0, 1e-3);
  EXPECT_EQ(drift.receiver_m, drift_after(12.0, {}, 2.997e8).receiver_m);
}

}  // namespace change_test
}  // namespace octant::test
