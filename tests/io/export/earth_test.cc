// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/export/earth.h"

#include "tests/io/io_support.h"

namespace octant::io::test {
namespace earth_test {

TEST(Earth, PlacesKeepTheirDistances) {
  // Back to earth-centred coordinates by the textbook's forward formula: distances are those of the map.
  const auto centred = [](const EarthPlace& p) {
    const double a = 6378137.0, f = 1 / 298.257223563, e2 = f * (2 - f), d = std::acos(-1.0) / 180;
    const double s = std::sin(p.latitude_deg * d), c = std::cos(p.latitude_deg * d),
                 N = a / std::sqrt(1 - e2 * s * s);
    return Eigen::Vector3d((N + p.altitude_m) * c * std::cos(p.longitude_deg * d),
                           (N + p.altitude_m) * c * std::sin(p.longitude_deg * d),
                           (N * (1 - e2) + p.altitude_m) * s);
  };
  for (const EarthOrigin& origin :
       {EarthOrigin{52.5, 13.4, 40.0, 1.0}, EarthOrigin{-33.9, 179.9999, 0.0, -2.0},
        EarthOrigin{89.99, -120.0, 10.0, 0.3}, EarthOrigin{0.0, 0.0, 0.0, 0.0}})
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(30, 40, 2), Eigen::Vector3d(-5000, 20000, 100)}) {
      const EarthPlace at = place_on_earth(p, origin);
      const Eigen::Vector3d from = centred(place_on_earth(Eigen::Vector3d::Zero(), origin));
      EXPECT_NEAR((centred(at) - from).norm(), p.norm(), 1e-6);
      EXPECT_LE(std::abs(at.longitude_deg), 180.0);
    }
  // North of the origin along the meridian.
  const EarthPlace north = place_on_earth({0, 1000, 0}, {45.0, 9.0, 0.0, std::acos(-1.0) / 2});
  EXPECT_GT(north.latitude_deg, 45.0);
  EXPECT_NEAR(north.longitude_deg, 9.0, 1e-12);
  EXPECT_FALSE(origin_from_words("52.5", 90));
  EXPECT_FALSE(origin_from_words("52.5,x", 90));
  EXPECT_FALSE(origin_from_words("91,0", 90));
  EXPECT_FALSE(origin_from_words("1,2,3,4", 90));
  EXPECT_TRUE(origin_from_words("-33.9,151.2,20", 90));
}

}  // namespace earth_test
}  // namespace octant::io::test
