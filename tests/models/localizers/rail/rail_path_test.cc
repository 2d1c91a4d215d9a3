// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/rail/rail_path.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace octant {
namespace rail_path_test {

/// Rounding of ranges and places of some tens of metres, magnified where a range hardly changes with the
/// place (a hundred times).
constexpr double kExact_m = 1e-9;

const Rail kStraight{.from_m = {1.0, 0.5}, .to_m = {39.0, 2.5}};
const Rail kArc{.shape = Rail::Shape::kArc, .centre_m = {6.0, 5.0}, .radius_m = 4.0};

TEST(RailPath, FollowsItsLine) {
  for (const Rail& rail : {kStraight, kArc}) {
    for (double s = -10; s < 12; s += 0.7) {
      const double h = 1e-6;
      const Pose a = rail_point(rail, s - h).T_map_vehicle, b = rail_point(rail, s + h).T_map_vehicle;
      Eigen::Vector3d by_s;
      by_s << (b.translation_m - a.translation_m).head<2>(), wrap_angle(b.heading_rad() - a.heading_rad());
      EXPECT_LT((by_s / (2 * h) - rail_point(rail, s).by_s).norm(), 1e-8) << "central differences";
      const Eigen::Vector2d along = rail_point(rail, s).by_s.head<2>();
      EXPECT_NEAR(
          wrap_angle(std::atan2(along.y(), along.x()) - rail_point(rail, s).T_map_vehicle.heading_rad()), 0,
          1e-14);
    }
  }
  EXPECT_NEAR(rail_wrapped_m(kArc, rail_length_m(kArc) + 0.5), 0.5, 1e-14);
}

TEST(RailPlaces, AreAtTheRange) {
  const Eigen::Vector3d o(0.25, -0.1, 0.5), p(9.0, 6.5, 2.0);
  for (const Rail& rail : {kStraight, kArc}) {
    for (double s = -11; s < 12; s += 0.31) {
      const auto distance_m = [&](double at) { return (rail_point(rail, at).T_map_vehicle * o - p).norm(); };
      const RailPlaces places = rail_places(rail, o, p, distance_m(s), 1e-12);
      ASSERT_EQ(places.count, 2);
      EXPECT_NEAR(distance_m(places.s_m[0]), distance_m(s), 1e-12);
      EXPECT_NEAR(distance_m(places.s_m[1]), distance_m(s), 1e-12);
      const double nearest_m = std::min(std::abs(rail_wrapped_m(rail, places.s_m[0] - s)),
                                        std::abs(rail_wrapped_m(rail, places.s_m[1] - s)));
      EXPECT_LT(nearest_m, kExact_m) << s;
    }
    EXPECT_EQ(rail_places(rail, o, p, 0.5, 0.01).count, 0) << "nearer than the rail comes";
  }
  EXPECT_EQ(rail_places(kArc, o, {6, 5, 2}, 4.3, 0.01).count, 0)
      << "above the centre all places are equally far";
}

}  // namespace rail_path_test
}  // namespace octant
