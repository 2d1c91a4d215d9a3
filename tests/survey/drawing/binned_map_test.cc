// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/drawing/binned_map.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "survey/drawing/palette.h"
#include "survey/geometry/make_survey_model.h"
#include "survey/map/survey.h"
#include "tests/support/worlds.h"
#include "tests/survey/small_scene.h"

namespace octant::survey {
namespace binned_map_test {

using test::must;
using test::small_scene;
using test::small_site;
using ::testing::HasSubstr;

// Rec. 709 luminance: a grey print keeps the order of the colours, and so does reduced colour vision.
TEST(BinnedMap, ColoursGetLighterAndCostsFall) {
  BinnedMap scale{.columns = 101, .rows = 1};
  scale.low = 2.0, scale.high = 4.0;
  for (int i = 0; i <= 100; ++i)
    scale.bins.push_back(BinnedMap::Bin::kValue), scale.values.push_back(2.0 + 0.02 * i);
  const auto luminance = [&](std::size_t i) {
    const auto c = colour_of(scale, i);
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
  };
  for (std::size_t i = 5; i <= 100; i += 5) EXPECT_GT(luminance(i), luminance(i - 5)) << i;
  EXPECT_GT(luminance(100), 4 * luminance(0));
  // map_server's scale: 254 free, 0 occupied.
  const auto costs = costs_of(scale);
  EXPECT_EQ(costs.front(), 254);
  EXPECT_EQ(costs.back(), 1);
  for (std::size_t i = 1; i <= 100; ++i) EXPECT_LT(costs[i], costs[i - 1]);
  scale.values[50] = 4.1;
  scale.bins[51] = BinnedMap::Bin::kEmpty;
  scale.bins[52] = BinnedMap::Bin::kOffFloor;
  EXPECT_EQ(costs_of(scale)[50], 0);
  EXPECT_EQ(costs_of(scale)[51], 0);
  EXPECT_EQ(costs_of(scale)[52], 205);  // unknown
  scale.low_is_bad = true;
  EXPECT_EQ(costs_of(scale).front(), 1);
}

TEST(BinnedMap, ABinHoldsTheWorstOfItsCells) {
  Scene scene = small_scene();
  const auto survey = must(run_survey(must(make_survey_model(small_site(), scene)), scene, nullptr));
  const FloorMap& map = *survey.find("sigma_m");
  const auto cells = cell_map(survey, map), bins = binned_map(survey, map, 8);
  EXPECT_EQ(cells.columns, 24u);
  EXPECT_EQ(bins.columns, 8u);
  EXPECT_EQ(bins.bin_m, 1.5);
  double worst = 0.0, worst_bin = 0.0;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      worst = std::max(worst, cells.values[row * 24 + column]);
  worst_bin = bins.values[0];
  EXPECT_EQ(worst, worst_bin);
  EXPECT_EQ(cells.bins[7 * 24 + 11], BinnedMap::Bin::kOffFloor);  // in the column
  EXPECT_EQ(costs_of(cells)[7 * 24 + 11], 205);
  const auto pixels = pixels_of(cells);
  ASSERT_EQ(pixels.size(), 4u * 24 * 16);
  EXPECT_EQ(pixels[4 * (8 * 24 + 11) + 3], 0);  // the picture's rows go down
  EXPECT_EQ(pixels[3], 255);
}

TEST(Palette, HexadecimalDigitsAreColours) {
  EXPECT_EQ(rgb_of("#00204d"), (std::array<std::uint8_t, 3>{0x00, 0x20, 0x4d}));
  EXPECT_EQ(rgb_of("#ffe945"), (std::array<std::uint8_t, 3>{255, 233, 69}));
  EXPECT_EQ(kToleranceParts.size() + 1, kToleranceColours.size()) << "a limit between any two";
  EXPECT_TRUE(std::is_sorted(kToleranceParts.begin(), kToleranceParts.end()));
}

}  // namespace binned_map_test
}  // namespace octant::survey
