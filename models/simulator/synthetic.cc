// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/simulator/synthetic.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "models/physics/measurement.h"
#include "models/simulator/random.h"
#include "models/simulator/synthetic_path.h"
#include "models/simulator/synthetic_sensors.h"
#include "models/simulator/synthetic_truth.h"
#include "models/trajectory/odometry_noise.h"

namespace octant {
namespace {

constexpr double kFiringPhase =
    0.26;  // phase of the firings within a slot, out of step with the odometry of a drive
constexpr double kAudible = 1.05;  // smallest ratio of amplitude to threshold; a crossing at the threshold
                                   // itself would be infinitely late

/// Rounds to a whole number of quanta. Divides by the tick rate if that is an integer, so that the result
/// prints as a short decimal.
double counted(double tof_s, double quantum_s) {
  const double ticks = std::round(tof_s / quantum_s), ticks_per_s = std::round(1 / quantum_s);
  return std::abs(ticks_per_s * quantum_s - 1) < 1e-12 ? ticks / ticks_per_s : ticks * quantum_s;
}

/// One firing of a beacon, and the properties common to all receivers.
struct Shot {
  BeaconId beacon;
  double fired_s = 0.0;
  double temperature_degC = 20.0;
  std::int64_t epoch = kNoEpoch;
  double cycle_offset_s = 0.0;
  double cycle_began_s = 0.0;
  bool shadowed = false;  ///< the direct path is blocked for the whole epoch
  double detour_s = 0.0;  ///< additional time of the path around the obstacle
};

class Recorder {
 public:
  Recorder(const Scenario& scenario, const Scenario::Path& path, const SharedState& truth, Random draws)
      : scenario_(scenario),
        spec_(path),
        truth_(truth),
        draws_(draws),
        path_(make_path(scenario, path, draws_)) {}

  /// @param sensor_draws  separate stream for bearings and scans, so that arrivals are the same with and
  /// without them
  MeasurementLog record(std::vector<double>& lateness_s, Random sensor_draws);

 private:
  void record_stops();
  void record_drive();
  void record_odometry();
  void record_shot(const Shot& shot);
  void record_arrival(const Shot& shot, ReceiverId receiver);
  [[nodiscard]] bool hears(const Shot& shot, ReceiverId receiver, const Pose& T_map_vehicle) const;
  [[nodiscard]] PathOutput flight(const Shot& shot, ReceiverId receiver) const;
  [[nodiscard]] double lateness(const Shot& shot, double tof_s);
  [[nodiscard]] Pose measured(const Pose& truth);
  [[nodiscard]] double temperature(double progress) const {
    return scenario_.site.medium.temperature_degC + scenario_.warming_degC * (progress - 0.5);
  }
  /// Draws whether a beacon is shadowed, and the detour of its path.
  void draw_shadow(Shot& shot) {
    shot.shadowed = draws_.uniform() < scenario_.echo_fraction / 2;
    shot.detour_s = draws_.log_uniform(scenario_.echo_delay_s[0], scenario_.echo_delay_s[1]);
  }

  const Scenario& scenario_;
  const Scenario::Path& spec_;
  const SharedState& truth_;
  Random draws_;
  TruePath path_;
  MeasurementLog log_;
  std::vector<double> lateness_s_;
};

/// Noise-free time of flight. The vehicle moves while the signal travels, hence the fixed-point iteration.
PathOutput Recorder::flight(const Shot& shot, ReceiverId receiver) const {
  const Timing& timing = scenario_.site.timing;
  const bool two_way = timing.ranging == Ranging::kTwoWay;
  PathInput input =
      path_of(truth_, shot.beacon, receiver,
              speed_mps(scenario_.site.medium, shot.temperature_degC) + truth_.speed_offset_mps[0]);
  if (two_way) input.delay_s += timing.turnaround_s;
  const Pose sent = path_.at(shot.fired_s);
  PathOutput out;
  for (int i = 0; i < 20; ++i) {  // contraction factor: ratio of vehicle speed to signal speed
    const double before_s = out.tof_s;
    const Pose heard = path_.at(shot.fired_s + before_s);
    const Pose T_hear_send = heard.inverse() * sent;
    input.T_map_vehicle = &heard;
    input.T_hear_send = two_way ? &T_hear_send : nullptr;
    out = predict_arrival_value(input);
    if (std::abs(out.tof_s - before_s) < 1e-15) break;
  }
  return out;
}

bool Recorder::hears(const Shot& shot, ReceiverId receiver, const Pose& T_map_vehicle) const {
  const Eigen::Vector3d from_receiver = truth_.beacon_p_map_m[shot.beacon.index()] -
                                        T_map_vehicle * truth_.receiver_p_vehicle_m[receiver.index()];
  const double distance_m = from_receiver.norm();
  if (distance_m > scenario_.range_m) return false;
  const auto& axis = scenario_.site.receivers[receiver.index()].axis;
  const double cosine =
      axis ? (T_map_vehicle.rotation * axis->normalized()).dot(from_receiver) / distance_m : 1.0;
  if (const auto& model = truth_.attenuation) {
    const double gain = axis && model->directional()
                            ? std::exp(log_directivity(cosine, model->half_power_angle_rad).value)
                            : 1.0;
    if (!(gain * amplitude_v(distance_m, *model) > kAudible * model->threshold_v)) return false;
  }
  return !axis || scenario_.hearing_half_angle_rad >= M_PI ||
         cosine > std::cos(scenario_.hearing_half_angle_rad);
}

/// Lateness of an arrival due to an echo, or earliness of a spurious one. Uses the same number of draws in
/// any case, so that worlds with and without echoes share their noise.
double Recorder::lateness(const Shot& shot, double tof_s) {
  const double half = scenario_.echo_fraction / 2;
  const bool echo =
      draws_.uniform() <
      half / (1 - half);  // among arrivals that are not shadowed, so that both kinds are equally frequent
  const double detour_s = draws_.log_uniform(scenario_.echo_delay_s[0], scenario_.echo_delay_s[1]);
  const bool early = draws_.uniform() < scenario_.early_fraction;
  const double part = draws_.uniform(0.3, 0.95);
  if (early) return (part - 1) * tof_s;
  if (shot.shadowed) return shot.detour_s;
  return echo ? detour_s : 0.0;
}

void Recorder::record_arrival(const Shot& shot, ReceiverId receiver) {
  const Noise& noise = scenario_.site.noise;
  const PathOutput direct = flight(shot, receiver);
  const double late_s = lateness(shot, direct.tof_s);
  double tof_s = direct.tof_s + shot.cycle_offset_s + noise.tof_sigma_s * draws_.normal() + late_s;
  const double meter = draws_.normal();
  Arrival arrival;
  arrival.time_s = to_microsecond(shot.fired_s + direct.tof_s + late_s);
  if (scenario_.site.timing.clock == Clock::kCycleOffset)
    tof_s += truth_.drift(VehicleId(std::size_t{0})) * (arrival.time_s - shot.cycle_began_s);
  if (scenario_.quantum_s > 0) tof_s = counted(tof_s, scenario_.quantum_s);
  arrival.tof_s = tof_s;
  arrival.beacon = shot.beacon;
  arrival.receiver = receiver;
  arrival.vehicle = VehicleId(std::size_t{0});
  arrival.epoch = shot.epoch;
  if (scenario_.log_amplitude)
    arrival.amplitude_v =
        std::min(std::exp(direct.log_amplitude) * (1 + noise.amplitude_relative_sigma * meter),
                 truth_.attenuation->saturation_v);
  if (scenario_.warming_degC != 0) arrival.temperature_degC = shot.temperature_degC;
  // The last arrivals of a drive have no odometry and are dropped.
  if (path_.moving && arrival.time_s > path_.end_s() - spec_.odometry_period_s) return;
  log_.arrivals.push_back(arrival);
  lateness_s_.push_back(late_s);
}

void Recorder::record_shot(const Shot& shot) {
  if (!scenario_.site.tof_sigma_given) return;  // the site has bearings or scans only
  const Pose T_map_vehicle = path_.at(shot.fired_s);
  const SiteVehicle& vehicle = scenario_.site.vehicles[0];
  for (std::size_t r = vehicle.first_receiver; r < vehicle.first_receiver + vehicle.receiver_count; ++r) {
    if (hears(shot, ReceiverId(r), T_map_vehicle)) record_arrival(shot, ReceiverId(r));
  }
}

Pose Recorder::measured(const Pose& truth) {
  const Eigen::Vector3d rotation = draws_.normal3(), position = draws_.normal3();
  const PoseAccuracy& accuracy = scenario_.pose_accuracy;
  const bool planar = scenario_.site.motion == Motion::kPlanar;
  Pose pose = truth;
  pose.translation_m +=
      accuracy.position_sigma_m * (planar ? Eigen::Vector3d(position.x(), position.y(), 0.0) : position);
  const double tilt_rad = planar ? 0.0 : accuracy.attitude_sigma_rad;
  pose.rotation = truth.rotation * exp_rotation({tilt_rad * rotation.x(), tilt_rad * rotation.y(),
                                                 accuracy.heading_sigma_rad * rotation.z()});
  if (!accuracy.heading_known) pose.rotation.setIdentity();
  return pose;
}

void Recorder::record_stops() {
  const std::size_t beacons = scenario_.site.beacons.size();
  const auto samples = static_cast<int>(std::lround(dwell_s(scenario_, spec_) / kTruthPeriod_s)) + 1;
  log_.has_epochs = true;
  for (int k = 0; k < spec_.epochs; ++k) {
    const double start_s = path_.start_s + k * path_.period_s;
    const Pose& stop = path_.poses[static_cast<std::size_t>(k)];
    const double offset_s = draws_.uniform(scenario_.cycle_offset_s[0], scenario_.cycle_offset_s[1]);
    std::vector<Shot> shots(beacons);
    for (std::size_t b = 0; b < beacons; ++b) {
      shots[b].beacon = BeaconId(b);
      shots[b].temperature_degC = temperature((k + 0.5) / spec_.epochs);
      shots[b].epoch = k;
      if (scenario_.site.timing.clock == Clock::kCycleOffset) shots[b].cycle_offset_s = offset_s;
      shots[b].cycle_began_s = start_s;
      draw_shadow(shots[b]);
    }
    for (std::size_t i = 0; i < beacons * static_cast<std::size_t>(spec_.rounds); ++i) {
      Shot& shot = shots[i % beacons];
      shot.fired_s = start_s + spec_.slot_s * static_cast<double>(i);
      record_shot(shot);
    }
    const Pose survey = measured(stop);  // constant error during a stop
    for (int i = 0; i < samples; ++i) {
      const double time_s = to_microsecond(start_s + i * kTruthPeriod_s);
      log_.truth.push_back({time_s, stop});
      if (scenario_.log_poses) log_.poses.push_back({time_s, survey});
    }
  }
}

void Recorder::record_odometry() {
  const VehicleId vehicle(std::size_t{0});
  const auto rows =
      static_cast<std::size_t>(std::floor((path_.end_s() - path_.start_s) / spec_.odometry_period_s + 1e-9)) +
      1;
  for (std::size_t i = 0; i < rows; ++i) {
    const double time_s = to_microsecond(path_.start_s + spec_.odometry_period_s * static_cast<double>(i));
    const Pose pose = path_.at(time_s);
    const Eigen::Vector3d slip = draws_.normal3();
    const bool in_space = scenario_.site.motion == Motion::kSpatial;
    if (!in_space || scenario_.log_odometry) {
      OdometryStep step{.time_s = time_s, .vehicle = vehicle};
      if (i > 0) {
        step.set_pose(log_.truth.back().T_map_vehicle.inverse() * pose);
        const OdometryVariance variance = variance_of(step, scenario_.odometry_accuracy);
        const double sigma_m = std::sqrt(variance.distance_m2), sigma_rad = std::sqrt(variance.heading_rad2);
        step.dx_m += sigma_m * slip.x();
        step.dy_m += sigma_m * slip.y();
        if (in_space) {
          const Eigen::Vector3d twist = draws_.normal3();
          step.dz_m += sigma_m * slip.z();
          step.turn_x_rad += sigma_rad * twist.x();
          step.turn_y_rad += sigma_rad * twist.y();
          step.dheading_rad += sigma_rad * twist.z();
        } else {
          step.dheading_rad += sigma_rad * slip.z();
        }
      }
      log_.odometry.push_back(step);
    }
    log_.truth.push_back({time_s, pose});
    if (scenario_.log_poses) log_.poses.push_back({time_s, measured(pose)});
  }
}

void Recorder::record_drive() {
  const double duration_s = path_.end_s() - path_.start_s;
  const std::size_t beacons = scenario_.site.beacons.size();
  const auto firings = beacons == 0 ? 0 : static_cast<std::size_t>(duration_s / spec_.slot_s);
  for (std::size_t i = 0; i < firings; ++i) {
    Shot shot;
    shot.beacon = BeaconId(i % beacons);
    shot.fired_s = path_.start_s + spec_.slot_s * (static_cast<double>(i) + kFiringPhase);
    shot.temperature_degC = temperature((shot.fired_s - path_.start_s) / duration_s);
    draw_shadow(shot);
    record_shot(shot);
  }
  record_odometry();
}

MeasurementLog Recorder::record(std::vector<double>& lateness_s, Random sensor_draws) {
  log_.vehicle = VehicleId(std::size_t{0});
  log_.pose_accuracy = scenario_.pose_accuracy;
  log_.odometry_accuracy = scenario_.odometry_accuracy;
  if (path_.moving) {
    record_drive();
  } else {
    record_stops();
  }
  std::vector<std::size_t> order(log_.arrivals.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return log_.arrivals[a].time_s < log_.arrivals[b].time_s; });
  std::vector<Arrival> sorted;
  lateness_s.clear();
  for (const std::size_t i : order) {
    sorted.push_back(log_.arrivals[i]);
    sorted.back().line = static_cast<int>(sorted.size()) + 1;  // line below the header
    lateness_s.push_back(lateness_s_[i]);
  }
  log_.arrivals = std::move(sorted);
  log_.rows = log_.arrivals.size();
  record_sensors(scenario_, spec_, path_, truth_, sensor_draws, log_);
  return std::move(log_);
}

}  // namespace

Result<World> simulate(const Scenario& scenario, std::uint64_t seed) {
  if (auto sound = check_scenario(scenario); !sound) return fail(sound.error());
  Random site_draws(seed, 0);
  const SharedState truth = draw_truth(scenario, site_draws);
  World world;
  world.site = known_site(scenario, truth, site_draws);
  world.run =
      Recorder(scenario, scenario.path, truth, Random(seed, 1)).record(world.run_lateness_s, Random(seed, 3));
  world.heldout = Recorder(scenario, scenario.heldout_path, truth, Random(seed, 2))
                      .record(world.heldout_lateness_s, Random(seed, 4));
  world.truth = true_deployment(scenario, truth, world.run.arrivals.size());
  return world;
}

}  // namespace octant
