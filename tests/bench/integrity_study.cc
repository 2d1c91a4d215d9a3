// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Frequency of fixes beyond their protection level, with faults at given rates:
//   octant_integrity least_squares|tracker|every_fix [EPOCHS] [SEED]
// A hall of 20 x 12 m with eight beacons and an octagon; times of flight to 10 us, beacons calibrated to 2 mm
// (new random errors every 1,000 epochs). A beacon is faulty in a thousandth of the epochs (`every_fix`: one
// of those received, in each). All its arrivals, or some of them, have an error of 1 to 1,000 sigmas
// (`every_fix`: 1 to 30), late in four of five cases. A hundredth of the arrivals are echoes, 0.3 to 12 ms
// late. The tracker drives, and a fault lasts five seconds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <random>
#include <vector>

#include "models/localizers/common/protection.h"
#include "models/localizers/drive/drive_tracker.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "tests/support/worlds.h"

namespace octant::bench {
namespace {

constexpr double kRange_m = 12.0, kHearingCosine_hall = 0.38, kCalibrated_m = 2e-3;
constexpr double kEcho = 0.01;

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
double normal(std::mt19937_64& random) { return std::normal_distribution<double>()(random); }
double log_uniform(std::mt19937_64& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}

/// Fault of a beacon: error of each of its arrivals.
struct Fault {
  bool all_alike = true;
  double size_s = 0.0, smallest = 1.0, largest = 1000.0, sigma_s = 1e-5;

  void draw(std::mt19937_64& random) {
    all_alike = uniform(random, 0, 1) < 0.5;
    size_s = one(random);
  }
  double one(std::mt19937_64& random) const {
    return sigma_s * log_uniform(random, smallest, largest) * (uniform(random, 0, 1) < 0.8 ? 1 : -1);
  }
  double of_arrival(std::mt19937_64& random) const {
    if (all_alike) return size_s;
    return uniform(random, 0, 1) < 0.5 ? one(random) : 0.0;
  }
};

/// The true hall, and the hall in a deployment.
class Hall {
 public:
  explicit Hall(std::mt19937_64& random) : random_(random) {
    Scenario s = test::hall_scenario();
    s.path.epochs = s.heldout_path.epochs = 1;
    truth = test::must(simulate(s, 1)).truth;
  }

  /// Beacons where a calibration of that accuracy finds them.
  Deployment calibrated() {
    Deployment d = truth;
    const auto n = static_cast<Eigen::Index>(3 * d.beacons.size());
    d.covariance.matrix = kCalibrated_m * kCalibrated_m * Eigen::MatrixXd::Identity(n, n);
    d.covariance.parameters.clear();
    for (std::size_t b = 0; b < d.beacons.size(); ++b) {
      for (int k = 0; k < 3; ++k) {
        d.covariance.parameters.push_back(parameters::beacon_position(b, static_cast<std::size_t>(k)));
        d.beacons[b].position_m[k] += kCalibrated_m * normal(random_);
      }
      d.beacons[b].covariance_m2 = kCalibrated_m * kCalibrated_m * Eigen::Matrix3d::Identity();
    }
    return d;
  }

  bool is_heard(const Pose& T, std::size_t beacon) const {
    return (truth.beacons[beacon].position_m - T.translation_m).norm() < kRange_m;
  }

  /// Arrivals of one beacon at all receivers in reach. @param fault  null: no fault
  void hear(const Pose& T, std::size_t beacon, double time_s, const Fault* fault, std::vector<Arrival>& out) {
    const double speed_mps = truth.speed_mps(truth.medium.temperature_degC);
    for (std::size_t r = 0; r < truth.receivers.size(); ++r) {
      const DeploymentReceiver& receiver = truth.receivers[r];
      const Eigen::Vector3d to = truth.beacons[beacon].position_m - T * receiver.position_m;
      if (to.norm() > kRange_m || to.normalized().dot(T.rotation * *receiver.axis) < kHearingCosine_hall)
        continue;
      Arrival a;
      a.time_s = time_s;
      a.beacon = BeaconId(beacon);
      a.receiver = ReceiverId(r);
      a.vehicle = VehicleId(0);
      a.tof_s = to.norm() / speed_mps + truth.beacons[beacon].delay_s + receiver.delay_s +
                truth.noise.tof_sigma_s * normal(random_);
      if (fault != nullptr) a.tof_s += fault->of_arrival(random_);
      if (uniform(random_, 0, 1) < kEcho) a.tof_s += log_uniform(random_, 0.3e-3, 12e-3);
      out.push_back(a);
    }
  }

  Deployment truth;

 private:
  std::mt19937_64& random_;
};

/// Counts of fixes and of those beyond their level.
struct Tally {
  long epochs = 0, ok = 0, leveled = 0, beyond = 0, beyond_unfaulted = 0, excluded = 0, false_exclusions = 0;
  double largest_m = 0.0;
  std::vector<float> levels_m, errors_m;

  void add(const Fix& fix, const Pose& truth, bool faulted) {
    ++epochs;
    if (!fix.ok()) return;
    ++ok;
    const bool at_fault =
        std::count(fix.rejections.begin(), fix.rejections.end(), Rejection::kBeaconFault) > 0;
    excluded += at_fault;
    false_exclusions += at_fault && !faulted;
    if (fix.protection_level_m == 0.0) return;
    ++leveled;
    const double off_m = (fix.T_map_vehicle.translation_m - truth.translation_m).head<2>().norm();
    const bool out = off_m > fix.protection_level_m;
    beyond += out;
    beyond_unfaulted += out && !faulted;
    largest_m = std::max(largest_m, out ? off_m : 0.0);
    levels_m.push_back(static_cast<float>(fix.protection_level_m));
    errors_m.push_back(static_cast<float>(off_m));
  }

  /// Probability of this number or more beyond, if each has the given risk (binomial).
  double chance(double risk) const {
    if (beyond == 0) return 1.0;
    double less = 0.0;
    for (long k = 0; k < beyond; ++k)
      less += std::exp(std::lgamma(leveled + 1.0) - std::lgamma(k + 1.0) - std::lgamma(leveled - k + 1.0) +
                       k * std::log(risk) + (leveled - k) * std::log1p(-risk));
    return std::max(0.0, 1.0 - less);
  }

  static double quantile(std::vector<float>& values, double at) {
    if (values.empty()) return 0.0;
    const auto place =
        values.begin() + static_cast<std::ptrdiff_t>(at * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place;
  }

  void print(const char* what, double risk) {
    const auto share = [this](long n) {
      return 100.0 * static_cast<double>(n) / static_cast<double>(epochs);
    };
    std::printf("%s: %ld epochs, ok %.4f %%, with a level %.4f %%\n", what, epochs, share(ok),
                share(leveled));
    std::printf(
        "  beyond their level %ld (%ld of them without a fault), stated risk %.2g: %.1f expected, chance of "
        "as "
        "many %.3g; the largest %.3f m\n",
        beyond, beyond_unfaulted, risk, risk * static_cast<double>(leveled), chance(risk), largest_m);
    std::printf("  errors 50 %% %.4f m, 99.9 %% %.4f m; levels 50 %% %.4f m, 95 %% %.4f m\n",
                quantile(errors_m, 0.5), quantile(errors_m, 0.999), quantile(levels_m, 0.5),
                quantile(levels_m, 0.95));
    for (const double limit_m : {0.03, 0.05, 0.1, 0.2}) {
      const long within =
          std::count_if(levels_m.begin(), levels_m.end(), [&](float l) { return l <= limit_m; });
      std::printf("  available at an alert limit of %.2f m: %.4f %%\n", limit_m, share(within));
    }
    std::printf("  beacons excluded in %ld fixes, in %ld without a fault\n", excluded, false_exclusions);
  }
};

Tally least_squares(long epochs, std::mt19937_64& random, bool every_fix) {
  Hall hall(random);
  Tally tally;
  std::optional<LeastSquaresLocalizer> localizer;
  std::vector<Arrival> arrivals;
  Fault fault;
  if (every_fix) fault.largest = 30.0;
  Fix fix;
  for (long k = 0; k < epochs; ++k) {
    if (k % 1000 == 0) localizer.emplace(hall.calibrated());
    const Pose T = Pose::planar(uniform(random, 0.5, 19.5), uniform(random, 0.5, 11.5),
                                uniform(random, -std::numbers::pi, std::numbers::pi));
    std::vector<std::size_t> heard;
    for (std::size_t b = 0; b < hall.truth.beacons.size(); ++b)
      if (hall.is_heard(T, b)) heard.push_back(b);
    const std::size_t chosen = heard.empty() ? 0 : heard[random() % heard.size()];
    bool faulted = false;
    arrivals.clear();
    for (const std::size_t b : heard) {
      const bool bad = every_fix ? b == chosen : uniform(random, 0, 1) < kBeaconFaultRate;
      if (bad) fault.draw(random);
      faulted = faulted || bad;
      hall.hear(T, b, static_cast<double>(k), bad ? &fault : nullptr, arrivals);
    }
    for (Arrival& a : arrivals) a.epoch = k;
    localizer->LeastSquaresLocalizer::Localizer::locate(Observations{arrivals, {}}, fix);
    tally.add(fix, T, faulted);
  }
  return tally;
}

/// Moves the pose, and returns the odometry.
OdometryStep drive(Pose& T, double time_s, double d, double turn, const OdometryAccuracy& accuracy,
                   std::mt19937_64& random) {
  const double sxy =
      std::sqrt(accuracy.distance_sigma_m_per_sqrt_m * accuracy.distance_sigma_m_per_sqrt_m * d +
                accuracy.floor_m * accuracy.floor_m);
  const double sh =
      std::sqrt(accuracy.heading_sigma_rad_per_sqrt_m * accuracy.heading_sigma_rad_per_sqrt_m * d +
                accuracy.floor_rad * accuracy.floor_rad);
  T = T * Pose::planar(d, 0.0, turn);
  OdometryStep step;
  step.time_s = time_s;
  step.vehicle = VehicleId(0);
  step.dx_m = d + sxy * normal(random);
  step.dy_m = sxy * normal(random);
  step.dheading_rad = turn + sh * normal(random);
  return step;
}

Tally tracker(long epochs, std::mt19937_64& random) {
  Hall hall(random);
  Tally tally;
  constexpr double kStep_s = 0.05, kSpeed_mps = 0.6, kFault_s = 5.0;
  const OdometryAccuracy accuracy;
  std::optional<DriveTracker> tracker;
  Pose T;
  double turn_rate = 0.0;
  struct Lasting {
    Fault fault;
    double until_s = -1.0;
  };
  std::vector<Lasting> faults(hall.truth.beacons.size());
  std::vector<Arrival> arrivals;
  Fix fix;
  for (long k = 0; k < epochs; ++k) {
    const double time_s = kStep_s * static_cast<double>(k);
    if (k % 1000 == 0) {  // another calibration, another drive
      TrackerOptions options;
      options.protect = true;
      tracker.emplace(hall.calibrated(), accuracy, options);
      static_cast<void>(tracker->move({.time_s = time_s - kStep_s, .vehicle = VehicleId(0)}));  // the anchor
      T = Pose::planar(uniform(random, 5, 15), uniform(random, 4, 8), uniform(random, -3, 3));
      Eigen::Vector3d off = 0.01 * Eigen::Vector3d(normal(random), normal(random), normal(random));
      tracker->start(Pose::planar(T.translation_m.x() + off.x(), T.translation_m.y() + off.y(),
                                  T.heading_rad() + off.z()),
                     1e-4 * Eigen::Matrix3d::Identity());
      for (Lasting& f : faults) f.until_s = -1.0;
    }
    // Towards the middle near the walls, else as it likes.
    const Eigen::Vector2d to = Eigen::Vector2d(10, 6) - T.translation_m.head<2>();
    const double bearing = wrap_angle(std::atan2(to.y(), to.x()) - T.heading_rad());
    const bool near_wall = std::abs(to.x()) > 8.0 || std::abs(to.y()) > 4.5;
    turn_rate =
        near_wall ? std::copysign(0.7, bearing) : std::clamp(turn_rate + 0.1 * normal(random), -0.7, 0.7);
    const OdometryStep step = drive(T, time_s, kSpeed_mps * kStep_s, turn_rate * kStep_s, accuracy, random);
    static_cast<void>(tracker->move(step));
    arrivals.clear();
    const std::size_t b = static_cast<std::size_t>(k) % hall.truth.beacons.size();
    bool faulted = false;
    for (std::size_t i = 0; i < faults.size(); ++i) {
      if (uniform(random, 0, 1) < kBeaconFaultRate * kStep_s / kFault_s && faults[i].until_s < time_s) {
        faults[i].fault.draw(random);
        faults[i].until_s = time_s + kFault_s;
      }
      // The effect of a fault on the pose lasts longer than the fault.
      faulted = faulted || faults[i].until_s + kFault_s > time_s;
    }
    hall.hear(T, b, time_s, faults[b].until_s > time_s ? &faults[b].fault : nullptr, arrivals);
    if (arrivals.empty()) continue;
    tracker->locate(Observations{arrivals, {}}, fix);
    tally.add(fix, T, faulted);
  }
  return tally;
}

}  // namespace
}  // namespace octant::bench

int main(int argc, char** argv) {
  using namespace octant::bench;
  const char* what = argc > 1 ? argv[1] : "least_squares";
  const long epochs = argc > 2 ? std::atol(argv[2]) : 1'000'000;
  std::mt19937_64 random(argc > 3 ? static_cast<std::uint64_t>(std::atoll(argv[3])) : 1);
  if (std::strcmp(what, "tracker") == 0) {
    tracker(epochs, random).print(what, octant::kProtectionRisk);
  } else {
    const bool every_fix = std::strcmp(what, "every_fix") == 0;
    // With a certain fault, the remaining risk is that of the fix without this beacon.
    const double risk =
        every_fix ? std::exp(-octant::kFaultySigmas * octant::kFaultySigmas / 2) : octant::kProtectionRisk;
    least_squares(epochs, random, every_fix).print(what, risk);
  }
}
