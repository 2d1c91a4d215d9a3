// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/geometry/plain_hdop.h"

#include <cmath>

#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "survey/geometry/geometry_map.h"

namespace octant::survey {
namespace {

TEST(PlainHdop, AgreesWithTheMap) {
  Random draw(4);
  for (const std::size_t columns : {1u, 7u, 64u, 131u}) {
    SurveyModel model;
    model.receivers = {{"r", {0, 0, 0.3}}};
    model.unknowns = unknowns_of(Motion::kPlanar, Clock::kSynchronised, model.receivers);
    model.noise.constant_m = 1.0;
    std::vector<Eigen::Vector3d> places;
    for (int i = 0; i < 11; ++i) {
      places.emplace_back(1e5 + draw.uniform(0, 30), draw.uniform(0, 20),
                          draw.uniform(2, 3));  // far from the map's origin
      model.beacons.push_back({"B", places.back()});
    }
    const PlainGrid grid{{1e5 - 2, -3}, 0.4, columns, 37};
    PoseList poses;
    for (std::size_t r = 0; r < grid.rows; ++r)
      for (std::size_t c = 0; c < columns; ++c)
        poses.add(grid.origin_m.x() + 0.4 * (static_cast<double>(c) + 0.5),
                  grid.origin_m.y() + 0.4 * (static_cast<double>(r) + 0.5), 0, 0);
    const auto map = evaluate_poses(model, poses, {.integrity = false});
    const auto plain = plain_hdop(places, 0.3, grid, 2);
    ASSERT_EQ(plain.size(), poses.size());
    // The stated accuracy: single precision, determinants lose HDOP^2 times 6e-8.
    for (std::size_t i = 0; i < plain.size(); ++i) EXPECT_NEAR(plain[i], map.hdop[i], 1e-4 * map.hdop[i]);
  }
}

TEST(PlainHdop, NothingFromBeaconsInALineOnTheLine) {
  const auto hdop = plain_hdop({{0, 0.5, 1}, {5, 0.5, 1}}, 0.0, {{0, 0}, 1.0, 10, 1});
  for (const float v : hdop) EXPECT_TRUE(std::isinf(v));
}

}  // namespace
}  // namespace octant::survey
