// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// The 40-minute drive of drive_bench.cc and drive_ceres_bench.cc, as plain numbers for all but Octant.

#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <Eigen/Core>

#include "calib/adjust/adjust.h"
#include "calib/calibrate.h"
#include "tests/support/worlds.h"

namespace octant::test {

inline constexpr double kDriveTolerance = 1e-6;

struct DriveStart {
  calib::Problem problem;
  std::vector<Trajectory> trajectories;  ///< states and marks of the solution, kept for all
  calib::ParameterLayout layout;
  Eigen::VectorXd x;  ///< beacons two centimetres off
  double best_cost = 0.0;
};

inline const DriveStart& drive_start(int seconds) {
  static std::map<int, DriveStart> kept;
  if (const auto found = kept.find(seconds); found != kept.end()) return found->second;
  Scenario scenario = drive_scenario(seconds);
  scenario.heldout_path.duration_s = 5.0;
  const World world = must(simulate(scenario, 1));
  DriveStart s{must(calib::make_problem(world.site, {world.run})), {}, {}, {}};
  calib::SolveOptions options;
  options.threads = 2;
  calib::Solution solution = calib::solve(s.problem, options);
  SharedState state = solution.state;
  s.layout = calib::make_layout(s.problem, state);
  s.trajectories = solution.trajectories;
  Eigen::VectorXd best = s.layout.vector_of(state);
  calib::AdjustOptions to_the_end;
  to_the_end.function_tolerance = 1e-13;
  s.best_cost = calib::adjust(s.problem, s.layout, solution.trajectories, best, to_the_end).cost;
  for (std::size_t b = 0; b < state.beacon_p_map_m.size(); ++b)
    if (!s.problem.site.beacons[b].is_control_point())
      state.beacon_p_map_m[b] += 0.02 * Eigen::Vector3d(std::sin(2.0 * static_cast<double>(b)),
                                                        std::cos(3.0 * static_cast<double>(b)), 0.5);
  s.x = s.layout.vector_of(state);
  return kept.emplace(seconds, std::move(s)).first->second;
}

inline void report_drive(benchmark::State& state, const DriveStart& start, double cost) {
  const auto arrivals = static_cast<double>(start.trajectories[0].arrivals.size());
  state.counters["arrivals"] = arrivals;
  state.counters["states"] = static_cast<double>(start.trajectories[0].nodes.size());
  state.counters["above_best"] = cost / start.best_cost - 1.0;
  state.counters["per_arrival"] = benchmark::Counter(
      arrivals, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

struct PlainArrival {
  std::size_t node, beacon, receiver;
  double alpha, tof_s, sigma_s, speed_mps;
};
struct PlainStep {
  double dx, dy, turn, k, k_turn;
};
using Pose3 = std::array<double, 3>;

/// Residual of an arrival and its derivatives by beacon, delay [us], receiver, speed, pose.
struct Sighting {
  double residual, by_beacon[3], by_delay, by_receiver[3], by_speed, by_pose[3];
  Sighting(const PlainArrival& a, const double* p, double delay_us, const double* o, double offset,
           const double* T) {
    const double c = std::cos(T[2]), s = std::sin(T[2]);
    const double lx = c * o[0] - s * o[1], ly = s * o[0] + c * o[1];
    const double v[3] = {T[0] + lx - p[0], T[1] + ly - p[1], o[2] - p[2]};
    const double d = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), speed = a.speed_mps + offset;
    residual = (a.tof_s - d / speed - 1e-6 * delay_us) / a.sigma_s;
    const double k = -1.0 / (a.sigma_s * speed * d);
    for (int i = 0; i < 3; ++i) by_beacon[i] = -k * v[i];
    by_receiver[0] = k * (c * v[0] + s * v[1]);
    by_receiver[1] = k * (c * v[1] - s * v[0]);
    by_receiver[2] = k * v[2];
    by_delay = -1e-6 / a.sigma_s;
    by_speed = d / (speed * speed * a.sigma_s);
    by_pose[0] = k * v[0];
    by_pose[1] = k * v[1];
    by_pose[2] = k * (v[1] * lx - v[0] * ly);
  }
};

/// Everything as arrays.
struct PlainDrive {
  std::vector<PlainArrival> arrivals;
  std::vector<PlainStep> steps;
  std::vector<Pose3> poses;
  std::vector<Pose3> beacons, receivers;
  std::vector<double> delays_us;
  double speed_offset = 0.0;

  explicit PlainDrive(const DriveStart& start) {
    const SharedState state = start.layout.state_of(start.x);
    for (const Eigen::Vector3d& p : state.beacon_p_map_m) beacons.push_back({p.x(), p.y(), p.z()});
    for (const double d : state.beacon_delay_s) delays_us.push_back(1e6 * d);
    for (const Eigen::Vector3d& o : state.receiver_p_vehicle_m) receivers.push_back({o.x(), o.y(), o.z()});
    speed_offset = state.speed_offset_mps[0];
    const Trajectory& t = start.trajectories[0];
    for (const Node& n : t.nodes)
      poses.push_back({n.T_map_vehicle.translation_m.x(), n.T_map_vehicle.translation_m.y(),
                       n.T_map_vehicle.heading_rad()});
    for (std::size_t k = 1; k < poses.size(); ++k)  // headings that run on
      poses[k][2] = poses[k - 1][2] + wrap_angle(poses[k][2] - poses[k - 1][2]);
    for (const ArrivalObservation& a : t.arrivals)
      if (a.rejection == Rejection::kUsed)
        arrivals.push_back(
            {a.node, a.beacon.index(), a.receiver.index(), a.alpha, a.tof_s, a.sigma_s, a.model_speed_mps});
    for (const OdometryObservation& o : t.odometry)
      steps.push_back({o.T_before_after.translation_m.x(), o.T_before_after.translation_m.y(),
                       o.T_before_after.heading_rad(), 1.0 / o.distance_sigma_m, 1.0 / o.heading_sigma_rad});
  }
  [[nodiscard]] Pose3 at(std::size_t node, double alpha) const {
    const Pose3 &a = poses[node], &b = poses[std::min(node + 1, poses.size() - 1)];
    return {a[0] + alpha * (b[0] - a[0]), a[1] + alpha * (b[1] - a[1]), a[2] + alpha * (b[2] - a[2])};
  }
};

/// Three residuals of an odometry step, with derivatives row by row.
inline void odometry(const PlainStep& s, const double* A, const double* B, double* r, double* JA,
                     double* JB) {
  const double c = std::cos(A[2]), e = std::sin(A[2]), dx = B[0] - A[0], dy = B[1] - A[1];
  const double x = c * dx + e * dy, y = c * dy - e * dx;
  r[0] = s.k * (s.dx - x);
  r[1] = s.k * (s.dy - y);
  r[2] = s.k_turn * wrap_angle(s.turn - (B[2] - A[2]));
  const double a[9] = {s.k * c, s.k * e, -s.k * y, -s.k * e, s.k * c, s.k * x, 0, 0, s.k_turn};
  const double b[9] = {-s.k * c, -s.k * e, 0, s.k * e, -s.k * c, 0, 0, 0, -s.k_turn};
  if (JA != nullptr) std::copy(a, a + 9, JA);
  if (JB != nullptr) std::copy(b, b + 9, JB);
}

/// Calls add(mean, sigma, block) for each prior.
template <class Add>
void for_each_prior(const Site& site, PlainDrive& d, Add&& add) {
  for (std::size_t b = 0; b < d.beacons.size(); ++b) {
    const SiteBeacon& beacon = site.beacons[b];
    if (!beacon.is_control_point())
      add({*beacon.position_m[0], *beacon.position_m[1], *beacon.position_m[2]}, *beacon.sigma_m[0],
          d.beacons[b].data());
    add({1e6 * site.timing.delay_s}, 1e6 * site.timing.delay_sigma_s, &d.delays_us[b]);
  }
  for (std::size_t r = 0; r < d.receivers.size(); ++r) {
    const Eigen::Vector3d& o = site.receivers[r].position_m;
    add({o.x(), o.y(), o.z()}, site.receivers[r].sigma_m[0], d.receivers[r].data());
  }
  add({0.0}, site.speed_sigma_mps, &d.speed_offset);
}

}  // namespace octant::test
