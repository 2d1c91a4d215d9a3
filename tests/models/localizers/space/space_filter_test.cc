// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Tracks of a vehicle in space while one beacon's path is late for seconds.
#include "models/localizers/space/space_filter.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "models/localizers/space/space_track.h"
#include "models/simulator/random.h"

namespace octant {
namespace space_filter_test {

constexpr double kSpeed_mps = 340.0, kSigma_m = 0.02, kPeriod_s = 0.1;
const std::vector<Eigen::Vector3d> kHall = {{0, 0, 0.3}, {10, 0, 4.0}, {10, 8, 0.5},
                                            {0, 8, 4.2}, {5, -1, 3.0}, {5, 9, 1.0}};

Deployment lasting_errors() {
  Deployment d;
  d.motion = Motion::kSpatial;
  d.medium.model = MediumModel::kConstant;
  d.medium.speed_mps = kSpeed_mps;
  d.noise.tof_sigma_s = kSigma_m / kSpeed_mps;
  d.correlated_noise = {.sigma_s = 0.05 / kSpeed_mps, .time_s = 1.5};
  for (const Eigen::Vector3d& p : kHall) d.beacons.emplace_back().position_m = p;
  d.vehicles.emplace_back().receiver_count = 1;
  d.receivers.emplace_back().vehicle = VehicleId(0);
  return d;
}

Eigen::Vector3d place_at(double time_s) {
  return {5 + 3 * std::sin(0.4 * time_s), 4 + 2.5 * std::sin(0.27 * time_s + 1),
          1.5 + 0.4 * std::sin(0.5 * time_s)};
}

/// A flight of 30 s. All beacons answer ten times a second; the path of beacon B2 is longer by late_m(time).
template <class Late>
MeasurementLog flight(std::uint64_t seed, Late&& late_m) {
  Random random(seed);
  MeasurementLog log;
  for (int k = 0; k < 300; ++k)
    for (std::size_t b = 0; b < kHall.size(); ++b) {
      Arrival& a = log.arrivals.emplace_back();
      a.time_s = kPeriod_s * k;
      a.beacon = BeaconId(b);
      a.receiver = ReceiverId(0);
      a.vehicle = VehicleId(0);
      const double range_m = (place_at(a.time_s) - kHall[b]).norm() + kSigma_m * random.normal();
      a.tof_s = (range_m + (b == 2 ? late_m(a.time_s) : 0.0)) / kSpeed_mps;
    }
  return log;
}

/// Largest error of a flight's fixes, relative to their covariance (Mahalanobis distance).
double largest_error(const MeasurementLog& log) {
  double largest = 0.0;
  for (const Fix& fix : track_in_space(log, lasting_errors())) {
    EXPECT_TRUE(fix.ok());
    const Eigen::Vector3d off = fix.T_map_vehicle.translation_m - place_at(fix.time_s);
    const Eigen::Matrix3d P = fix.covariance.topLeftCorner<3, 3>();
    largest = std::max(largest, std::sqrt(off.dot(P.ldlt().solve(off))));
  }
  return largest;
}

/// The largest of some hundred independent normal errors in space exceeds it once in 10,000 flights.
constexpr double kLargest = 5.3;

TEST(SpaceFilter, APathThatBecomesLateSlowlyDoesNotMisleadTheTrack) {
  const auto slowly = [](double t) { return t > 10 && t < 14 ? 1.5 * std::min(1.0, (t - 10) / 2) : 0.0; };
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    EXPECT_LT(largest_error(flight(seed, slowly)), kLargest) << "seed " << seed;
}

TEST(SpaceFilter, APathThatIsLateAtFirstDoesNotMisleadTheStart) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    EXPECT_LT(largest_error(flight(seed, [](double t) { return t < 2.6 ? 2.5 : 0.0; })), kLargest)
        << "seed " << seed;
}

}  // namespace space_filter_test
}  // namespace octant
