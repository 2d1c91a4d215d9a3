// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Placement: against regular, random and greedy layouts in three halls.
#include "survey/placement.h"

#include <chrono>
#include <gtest/gtest.h>

#include "tests/survey/halls.h"

namespace octant::survey {
namespace {

TEST(Placement, Trial) {
  for (auto hall : test::three_halls()) {
    if (const char* cone = std::getenv("CONE")) {
      BeamPattern b; b.name = "cone"; b.half_angle_rad = std::atof(cone) * M_PI / 180;
      if (std::getenv("POWER")) { b.kind = BeamPattern::Kind::kCosinePower; b.exponent = std::atof(std::getenv("POWER")); }
      hall.scene.patterns.push_back(b);
      hall.scene.beacon_pattern = 0;
      SceneBeacon sb; sb.name = "B0"; sb.axis = Eigen::Vector3d(1,0,0); hall.scene.beacons.push_back(sb);
    }
    if (std::getenv("OFFSET") && hall.name != "aisles") hall.site.timing.clock = Clock::kCycleOffset;
    if (std::getenv("PERM")) hall.scene.noise.sigma_m_per_m = std::atof(std::getenv("PERM"));
    if (const char* range = std::getenv("RANGE")) hall.scene.acoustics.range_m = std::atof(range);
    const auto model = test::must(make_survey_model(hall.site, hall.scene));
    for (std::size_t n = 4; n <= 12; n += std::getenv("STEP") ? 1 : 4) {
      PlacementOptions o; if (std::getenv("EV")) o.evaluations = std::atoi(std::getenv("EV"));
      const auto t0 = std::chrono::steady_clock::now();
      const Placement p = test::must(place_beacons(model, hall.scene, n, o));
      const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count();
      std::printf("%s %zu: worst %.4f (greedy %.4f regular %.4f random %.4f) cov %.3f reg cov %.3f ratio %.3f  mean %.4f  evals %zu %.1f s\n", hall.name.c_str(), n, p.figures.objective_m, p.greedy.objective_m,
                  p.regular.objective_m, p.random.objective_m, p.figures.covered_fraction, p.regular.covered_fraction, p.figures.objective_m / p.regular.objective_m, p.figures.mean_m, p.evaluations, s);
    }
  }
}

}  // namespace
}  // namespace octant::survey
