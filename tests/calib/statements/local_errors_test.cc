// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Tests of assumptions in recordings whose errors depend on the place or vary slowly.
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/simulator/random.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace local_errors_test {

using testing::HasSubstr;
using testing::IsEmpty;

/// Smooth random function of a point (in the plane, or in time), with a standard deviation of 1.
class SmoothField {
 public:
  SmoothField(double wavelength, Random& random) {
    for (Wave& wave : waves_) {
      const double direction_rad = random.uniform(0.0, 2 * std::numbers::pi);
      wave.number = 2 * std::numbers::pi / wavelength *
                    Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
      wave.phase_rad = random.uniform(0.0, 2 * std::numbers::pi);
    }
  }
  [[nodiscard]] double at(const Eigen::Vector2d& p) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += std::cos(wave.number.dot(p) + wave.phase_rad);
    return sum * std::sqrt(2.0 / static_cast<double>(waves_.size()));
  }

 private:
  struct Wave {
    Eigen::Vector2d number;
    double phase_rad = 0.0;
  };
  std::array<Wave, 4> waves_;
};

/// Adds an error to each arrival: a smooth function of some point for each beacon.
World with_smooth_errors(World world, double sigma_s, double wavelength, std::uint64_t seed,
                         const std::function<Eigen::Vector2d(const Arrival&)>& point) {
  Random random(seed, 7);
  std::vector<SmoothField> fields;
  for (std::size_t b = 0; b < world.site.beacons.size(); ++b) fields.emplace_back(wavelength, random);
  for (Arrival& a : world.run.arrivals) a.tof_s += sigma_s * fields[a.beacon.index()].at(point(a));
  return world;
}

/// Errors that depend on the place, as reflections and antennas cause.
World with_errors_of_places(World world, double sigma_s, std::uint64_t seed) {
  return with_smooth_errors(world, sigma_s, 8.0, seed, [&world](const Arrival& a) -> Eigen::Vector2d {
    Pose pose;
    EXPECT_TRUE(interpolate_poses(world.run.truth, a.time_s, 10.0, pose));
    return (pose * world.site.receivers[a.receiver.index()].position_m).head<2>();
  });
}

/// Errors of each beacon that vary slowly, a third of the recording per wave.
World with_slow_errors(World world, double sigma_s, std::uint64_t seed) {
  const double span_s = world.run.arrivals.back().time_s - world.run.arrivals.front().time_s;
  return with_smooth_errors(world, sigma_s, span_s / 3, seed, [](const Arrival& a) -> Eigen::Vector2d {
    return {a.time_s, 0.0};
  });
}

/// Contradictions of assumptions about the site and the clocks. The share of early arrivals is another test.
std::string in_words(const calib::Solution& solution) {
  std::string text;
  for (const Contradiction& c : solution.contradictions)
    if (c.stated != "to be heard along the straight path") text += octant::in_words(c) + "\n";
  return text;
}

/// A hall in which all beacons, their delays and the receivers have priors.
Scenario hall_of_priors() {
  Scenario s = hall_scenario();
  for (SiteBeacon& b : s.site.beacons)
    if (!b.is_control_point()) b.sigma_m = {0.05, 0.05, 0.05};
  return s;
}

// Single receivers, delays and positions were blamed: they absorb a part of such errors.
TEST(LocalErrors, OfPlacesContradictNothing) {
  for (const double sigma_s : {3e-5, 6e-5})
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
      EXPECT_THAT(
          in_words(solution_of(with_errors_of_places(must(simulate(hall_of_priors(), seed)), sigma_s, seed))),
          IsEmpty())
          << "seed " << seed << ", " << sigma_s;
}

TEST(LocalErrors, OfPlacesDoNotHideAFalsePosition) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    World world = with_errors_of_places(must(simulate(hall_of_priors(), seed)), 5e-5, seed);
    *world.site.beacons[3].position_m[0] += 1.0;
    EXPECT_THAT(in_words(solution_of(world)), HasSubstr("B3")) << seed;
  }
}

// A clock that jumps was blamed.
TEST(LocalErrors, ThatVarySlowlyContradictNothing) {
  for (const double sigma_s : {3e-5, 6e-5})
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
      EXPECT_THAT(
          in_words(solution_of(with_slow_errors(must(simulate(hall_of_priors(), seed)), sigma_s, seed))),
          IsEmpty())
          << "seed " << seed << ", " << sigma_s;
}

}  // namespace local_errors_test
}  // namespace octant::test
