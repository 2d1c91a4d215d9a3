// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/change.h"

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

namespace octant::test {
namespace {

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

TEST(Drift, OfNoTimeIsTheDefaultAndGrowsAsTheRootOfSquares) {
  const Drift now = Drift::of_months(0.0);
  EXPECT_EQ(now.beacon_m, Drift().beacon_m);
  EXPECT_EQ(now.attenuation, Drift().attenuation);
  EXPECT_EQ(Drift::of_months(-5.0).delay_s, Drift().delay_s) << "time does not run backwards";
  EXPECT_EQ(Drift::of_months(std::nan("")).delay_s, Drift().delay_s);
  // 0.1 mm a month in addition to 1 mm: after ten months the root of two.
  EXPECT_NEAR(Drift::of_months(10.0).beacon_m, std::sqrt(2.0) * 1e-3, 1e-15);
  EXPECT_NEAR(Drift::of_months(10.0).delay_s, std::sqrt(2.0) * 3e-6, 1e-18);
  EXPECT_NEAR(Drift::of_months(1e6).speed_mps, 3e4, 1.0);
}

}  // namespace
}  // namespace octant::test
