// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/floor_maps.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace octant::survey {
namespace floor_maps_test {

TEST(FloorMaps, AreThoseThatMakeSense) {
  SurveyModel model;
  Survey survey;
  const auto names = [&](bool route) {
    std::vector<std::string> all;
    std::vector<FloorMap*> by_name;
    for (const FloorMap& map : make_maps(wanted_maps(model, survey, {}, route), 3, model, by_name))
      all.push_back(map.name);
    return all;
  };
  const auto has = [&](const std::string& name, bool route = false) {
    const auto all = names(route);
    return std::find(all.begin(), all.end(), name) != all.end();
  };
  EXPECT_TRUE(has("sigma_m") && has("hdop") && has("loss_one_m") && has("mirror"));
  EXPECT_FALSE(has("loss_one_m", true) || has("loss_two_m", true)) << "no losses along routes";
  EXPECT_FALSE(has("total_m") || has("tdop") || has("vdop") || has("sigma_heading_rad"));
  model.unknowns = {.position = 3, .rotation = 3, .clock = true};
  model.motion = Motion::kSpatial;
  survey.calibrated = true;
  EXPECT_TRUE(has("total_m") && has("tdop") && has("vdop") && has("sigma_heading_rad"));
  EXPECT_FALSE(has("mirror")) << "in space there is no line to be mirrored in";
}

TEST(FloorMaps, EachIsFoundByItsNumber) {
  SurveyModel model;
  model.tolerance.fix_m = 0.05;
  Survey survey;
  std::vector<FloorMap*> by_name;
  auto maps = make_maps(wanted_maps(model, survey, {}, false), 4, model, by_name);
  ASSERT_EQ(by_name.size(), kMaps);
  EXPECT_EQ(by_name[kMapTotal], nullptr);
  EXPECT_EQ(by_name[kMapSigma]->name, "sigma_m");
  EXPECT_EQ(by_name[kMapBeacons]->name, "beacons_heard");
  EXPECT_EQ(by_name[kMapLossTwo]->name, "loss_two_m");
  EXPECT_TRUE(by_name[kMapBeacons]->low_is_bad);
  EXPECT_EQ(by_name[kMapLossTwo]->limit, 0.05);
  EXPECT_EQ(by_name[kMapHdop]->limit, std::nullopt) << "a ratio is not held against a length";
  for (const FloorMap& map : maps) EXPECT_EQ(map.values, std::vector<float>(4, kNoMapValue));
}

}  // namespace floor_maps_test
}  // namespace octant::survey
