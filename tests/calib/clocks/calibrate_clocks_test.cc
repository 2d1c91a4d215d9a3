// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/clocks/calibrate_clocks.h"

#include <random>

#include <gtest/gtest.h>

#include "calib/solution/variances.h"

namespace octant::calib {
namespace calibrate_clocks_test {

constexpr double kSpeed_mps = 299702547.0, kNoise_s = 2e-10;

/// A room with eight anchors, whose receivers stamp the blinks of a tag and packets of the anchors on clocks
/// of their own.
struct ClockWorld {
  Site site;
  std::vector<Eigen::Vector3d> beacons_m;
  ClockLog log;
  ClockModel clocks;
};

struct WorldOptions {
  bool is_free = true;
  double jump_s = 0.0;           ///< step of the clock of A5 in the middle
  bool exchange = false;         ///< A2 and A6 in the site
  double packet_period_s = 0.1;  ///< of the anchors
};

/// Clock whose phase is a random walk about a line.
class WanderingClock {
 public:
  WanderingClock(std::mt19937_64& random, double deviation) : random_(&random), deviation_(deviation) {
    std::normal_distribution<double> normal;
    if (deviation > 0.0) rate_ = 2e-6 * normal(random), phase_s_ = normal(random);
  }
  double at(double time_s) {  // in the order of time
    std::normal_distribution<double> normal;
    const double step_s = std::max(time_s - time_s_, 0.0);
    phase_s_ += rate_ * step_s + deviation_ * std::sqrt(step_s) * normal(*random_);
    time_s_ = std::max(time_s, time_s_);
    return time_s + phase_s_;
  }

 private:
  std::mt19937_64* random_;
  double deviation_, rate_ = 0.0, phase_s_ = 0.0, time_s_ = 0.0;
};

ClockWorld world_of(unsigned seed, const WorldOptions& options = {}) {
  constexpr double kDuration_s = 24.0, kBlink_s = 0.4, kSigma_m = 0.2;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  ClockWorld world;
  Site& site = world.site;
  site.motion = Motion::kSpatial;
  site.medium = {.model = MediumModel::kConstant, .speed_mps = kSpeed_mps};
  site.timing.clock = Clock::kCycleOffset;
  site.noise.tof_sigma_s = kNoise_s;
  site.vehicles.resize(1);
  site.vehicles[0].receiver_count = 1;
  site.receivers.resize(1);
  site.receivers[0].vehicle = VehicleId(0);
  for (int b = 0; b < 8; ++b) {
    const Eigen::Vector3d corner(b & 1 ? 8.0 : 0.0, b & 2 ? 6.0 : 0.0, b & 4 ? 2.8 : 0.4);
    world.beacons_m.emplace_back(corner +
                                 0.2 * Eigen::Vector3d(normal(random), normal(random), normal(random)));
    SiteBeacon& beacon = site.beacons.emplace_back();
    beacon.name = "A" + std::to_string(b);
    const bool is_control = b == 0 || b == 3 || b == 6;
    const double sigma_m = is_control && !options.exchange ? 0.0 : kSigma_m;
    for (std::size_t i = 0; i < 3; ++i) {
      beacon.position_m[i] = world.beacons_m.back()[static_cast<int>(i)] + sigma_m * normal(random);
      beacon.sigma_m[i] = sigma_m;
    }
    world.clocks.of_device.push_back(options.is_free ? b : 0);
  }
  if (options.exchange) std::swap(site.beacons[2].position_m, site.beacons[6].position_m);
  world.clocks.is_free = options.is_free;
  for (int b = 0; b < 9; ++b) world.clocks.names.push_back(b < 8 ? "A" + std::to_string(b) : "tag");
  world.clocks.of_device.push_back(8);
  std::vector<WanderingClock> clocks;
  for (int b = 0; b < 8; ++b) clocks.emplace_back(random, options.is_free ? kTcxoDeviation : 0.0);
  double next_blink_s = 0.0, next_packet_s = 0.013;
  for (std::size_t packet = 0; std::min(next_blink_s, next_packet_s) < kDuration_s;) {
    const bool is_packet = next_packet_s < next_blink_s;
    const double time_s = is_packet ? next_packet_s : next_blink_s;
    const std::size_t from = is_packet ? packet++ % 8 : 8;
    (is_packet ? next_packet_s : next_blink_s) += is_packet ? options.packet_period_s : kBlink_s;
    const Eigen::Vector3d at_m = is_packet
                                     ? world.beacons_m[from]
                                     : Eigen::Vector3d(0.5 + 7 * uniform(random), 0.5 + 5 * uniform(random),
                                                       0.3 + 1.9 * uniform(random));
    Transmission t{time_s, kNoEpoch, DeviceId(from), {}, false};
    for (std::size_t b = 0; b < 8; ++b) {
      const double flight_s = (at_m - world.beacons_m[b]).norm() / kSpeed_mps;
      const double jump_s = b == 5 && time_s > kDuration_s / 2 ? options.jump_s : 0.0;
      const double noise_s = b == from ? 0.0 : kNoise_s * normal(random);
      t.receptions.push_back({DeviceId(b), clocks[b].at(time_s) - time_s + flight_s + noise_s + jump_s});
    }
    world.log.transmissions.push_back(std::move(t));
  }
  return world;
}

ClockCalibration calibrated(const ClockWorld& world) {
  return calibrate_clocks(world.site, std::vector<MeasurementLog>(1), {{world.log}, world.clocks}, {})
      .value();
}

/// Mean square of the errors of the beacons that are not fixed, in their sigmas, and root mean square [m].
struct BeaconErrors {
  double nees = 0.0, rmse_m = 0.0, bound_m = 0.0;
};

BeaconErrors errors_of(const ClockWorld& world, const ClockCalibration& c) {
  BeaconErrors e;
  double count = 0.0;
  const Variances variances(c.solution);
  for (std::size_t b = 0; b < 8; ++b)
    for (int i = 0; i < 3; ++i) {
      const double sigma_m = variances.beacon_sigma_m(b)[i];
      if (!(sigma_m > 0)) continue;
      const double error_m = c.solution.state.beacon_p_map_m[b][i] - world.beacons_m[b][i];
      e.nees += std::pow(error_m / sigma_m, 2);
      e.rmse_m += error_m * error_m, e.bound_m += sigma_m * sigma_m;
      count += 1.0;
    }
  return {e.nees / count, std::sqrt(e.rmse_m / count), std::sqrt(e.bound_m / count)};
}

TEST(CalibrateClocks, FindsAnchorsWithFreeClocksWithinTheirSigmas) {
  double nees = 0.0, rmse_m = 0.0, bound_m = 0.0;
  constexpr unsigned kSeeds = 3;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const ClockWorld world = world_of(seed);
    const ClockCalibration c = calibrated(world);
    ASSERT_EQ(c.solution.status, SolveStatus::kConverged) << c.solution.message;
    EXPECT_TRUE(c.solution.contradictions.empty());
    EXPECT_TRUE(c.findings.empty());
    const BeaconErrors e = errors_of(world, c);
    nees += e.nees / kSeeds, rmse_m += e.rmse_m, bound_m += e.bound_m;
    EXPECT_EQ(c.clocks.size(), 9U);
  }
  EXPECT_LT(rmse_m, 1.25 * bound_m);
  EXPECT_GT(nees, 0.5);  // 45 errors
  EXPECT_LT(nees, 2.0);
}

TEST(CalibrateClocks, NamesTheClockThatJumps) {
  const ClockCalibration c = calibrated(world_of(4, {.jump_s = 3e-8}));
  ASSERT_EQ(c.findings.size(), 1U);
  EXPECT_EQ(c.findings[0].kind, "clock_step");
  EXPECT_NE(c.findings[0].text.find("The clock of A5 jumps by 0.0"), std::string::npos) << c.findings[0].text;
  EXPECT_NE(c.findings[0].text.find(" us at 12.0"), std::string::npos) << c.findings[0].text;
}

TEST(CalibrateClocks, NamesExchangedAnchors) {
  const ClockCalibration c = calibrated(world_of(5, {.exchange = true}));
  ASSERT_EQ(c.solution.contradictions.size(), 1U);
  EXPECT_EQ(c.solution.contradictions[0].kind, ContradictionKind::kExchanged);
  EXPECT_EQ(c.solution.contradictions[0].subject, "A2, A6");
}

}  // namespace calibrate_clocks_test
}  // namespace octant::calib
