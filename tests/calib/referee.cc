// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/referee.h"

#include <cmath>
#include <map>
#include <memory>

#include <ceres/ceres.h>

namespace octant::test {
namespace {

/// One arrival. Parameters: beacon 3, beacon delay 1, receiver delay 1, site delay 1, speed offset 1,
/// receiver 3, attenuation 3, state before 4 and state after 4 (x, y, heading, cycle offset). Delays and
/// offsets in microseconds.
struct ArrivalResidual {
  ArrivalObservation a;
  double threshold_v;
  bool attenuated;
  template <class T>
  bool operator()(const T* beacon, const T* beacon_delay, const T* receiver_delay, const T* site_delay,
                  const T* speed, const T* o, const T* attenuation, const T* before, const T* after,
                  T* residual) const {
    using std::cos;
    using std::exp;
    using std::log;
    using std::sin;
    using std::sqrt;
    T pose[4];
    for (int i = 0; i < 4; ++i) pose[i] = before[i] + T(a.alpha) * (after[i] - before[i]);
    const T x = pose[0] + cos(pose[2]) * o[0] - sin(pose[2]) * o[1] - beacon[0];
    const T y = pose[1] + sin(pose[2]) * o[0] + cos(pose[2]) * o[1] - beacon[1];
    const T z = o[2] - beacon[2];
    const T d = sqrt(x * x + y * y + z * z);
    T tof = d / (T(a.model_speed_mps) + speed[0]) +
            T(1e-6) * (beacon_delay[0] + receiver_delay[0] + site_delay[0] + before[3]);
    residual[1] = T(0);
    if (attenuated) {
      const T log_amplitude = log(attenuation[0]) - log(d) - attenuation[1] * d;
      tof = tof - T(1e-6) * attenuation[2] * log(T(1) - T(threshold_v) / exp(log_amplitude));
      if (a.log_amplitude_sigma > 0)
        residual[1] = (T(a.log_amplitude) - log_amplitude) / T(a.log_amplitude_sigma);
    }
    residual[0] = (T(a.tof_s) - tof) / T(a.sigma_s);
    return true;
  }
};

struct OdometryResidual {
  OdometryObservation o;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using std::cos;
    using std::sin;
    const T dx = b[0] - a[0], dy = b[1] - a[1];
    residual[0] =
        (T(o.T_before_after.translation_m.x()) - (cos(a[2]) * dx + sin(a[2]) * dy)) / T(o.distance_sigma_m);
    residual[1] =
        (T(o.T_before_after.translation_m.y()) - (cos(a[2]) * dy - sin(a[2]) * dx)) / T(o.distance_sigma_m);
    residual[2] = (T(o.T_before_after.heading_rad()) - (b[2] - a[2])) / T(o.heading_sigma_rad);
    return true;
  }
};

struct PoseResidual {
  PoseObservation p;
  double heading_rad;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    const T w(p.alpha);
    residual[0] = (T(p.T_map_vehicle.translation_m.x()) - (a[0] + w * (b[0] - a[0]))) / T(p.position_sigma_m);
    residual[1] = (T(p.T_map_vehicle.translation_m.y()) - (a[1] + w * (b[1] - a[1]))) / T(p.position_sigma_m);
    residual[2] = (T(heading_rad) - (a[2] + w * (b[2] - a[2]))) / T(p.heading_sigma_rad);
    return true;
  }
};

struct PriorResidual {
  double mean, sigma;
  int index;
  template <class T>
  bool operator()(const T* x, T* residual) const {
    residual[0] = (x[index] - T(mean)) / T(sigma);
    return true;
  }
};

struct TapeResidual {
  ControlDistance d;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using std::sqrt;
    const T x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    residual[0] = (sqrt(x * x + y * y + z * z) - T(d.distance_m)) / T(d.sigma_m);
    return true;
  }
};

class Referee {
 public:
  Referee(const calib::Problem& problem, const calib::Solution& solution)
      : problem_(problem), site_(problem.site), solution_(solution) {}

  RefereeResult run() {
    load();
    for (std::size_t i = 0; i < solution_.trajectories.size(); ++i) add_trajectory(i);
    add_priors();
    hold_fixed();
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-16;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-14;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_, &summary);
    RefereeResult result;
    result.converged = summary.IsSolutionUsable();
    result.cost = summary.final_cost;
    collect(result);
    return result;
  }

 private:
  using State = std::array<double, 4>;

  void load() {
    const double nudge = 3e-3;  // metres: a few sigmas, so that the referee has to find the optimum by itself
    const SharedState& s = solution_.state;
    for (std::size_t b = 0; b < site_.beacons.size(); ++b) {
      beacons_.push_back({s.beacon_p_map_m[b].x(), s.beacon_p_map_m[b].y(), s.beacon_p_map_m[b].z()});
      for (std::size_t i = 0; i < 3; ++i)
        if (site_.beacons[b].sigma_m[i].value_or(1.0) > 0)
          beacons_[b][i] += nudge * std::sin(static_cast<double>(3 * b + i));
      beacon_delays_.push_back(1e6 * s.beacon_delay_s[b]);
    }
    for (std::size_t r = 0; r < site_.receivers.size(); ++r) {
      receivers_.push_back(
          {s.receiver_p_vehicle_m[r].x(), s.receiver_p_vehicle_m[r].y(), s.receiver_p_vehicle_m[r].z()});
      receiver_delays_.push_back(1e6 * s.receiver_delay_s[r]);
    }
    site_delay_ = 1e6 * s.site_delay_s;
    speed_ = s.speed_offset_mps[0];
    if (s.attenuation)
      attenuation_ = {s.attenuation->amplitude_1m_v, s.attenuation->absorption_np_per_m,
                      1e6 * s.attenuation->rise_time_s};
    states_.resize(solution_.trajectories.size());
    for (std::size_t i = 0; i < states_.size(); ++i) {
      double unwrapped = 0.0;
      for (const Node& node : solution_.trajectories[i].nodes) {
        unwrapped += wrap_angle(node.T_map_vehicle.heading_rad() - unwrapped);
        states_[i].push_back({node.T_map_vehicle.translation_m.x(), node.T_map_vehicle.translation_m.y(),
                              unwrapped, 1e6 * node.cycle_offset_s});
      }
    }
  }

  void add_trajectory(std::size_t i) {
    const Trajectory& t = solution_.trajectories[i];
    for (const Segment& segment : t.segments) {
      if (!t.nodes[segment.first_node].placed) continue;
      for (std::size_t k = segment.first_arrival; k < segment.last_arrival; ++k)
        if (t.arrivals[k].rejection == Rejection::kUsed) add_arrival(i, t.arrivals[k]);
      for (std::size_t k = segment.first_odometry; k < segment.last_odometry; ++k) {
        auto& s = states_[i];
        ceres_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<OdometryResidual, 3, 4, 4>(new OdometryResidual{t.odometry[k]}),
            nullptr, s[t.odometry[k].node].data(), s[t.odometry[k].node + 1].data());
      }
      for (std::size_t k = segment.first_pose; k < segment.last_pose; ++k) add_pose(i, t.poses[k]);
    }
  }

  double* next_state(std::size_t i, std::size_t node, double alpha) {
    if (alpha > 0) return states_[i][node + 1].data();
    idle_.push_back(std::make_unique<State>(State{}));  // a block of its own: Ceres wants distinct ones
    ceres_.AddParameterBlock(idle_.back()->data(), 4);
    ceres_.SetParameterBlockConstant(idle_.back()->data());
    return idle_.back()->data();
  }

  void add_arrival(std::size_t i, const ArrivalObservation& a) {
    auto* functor =
        new ArrivalResidual{a, solution_.state.attenuation ? solution_.state.attenuation->threshold_v : 0.0,
                            solution_.state.attenuation.has_value()};
    ceres_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ArrivalResidual, 2, 3, 1, 1, 1, 1, 3, 3, 4, 4>(functor), nullptr,
        beacons_[a.beacon.index()].data(), &beacon_delays_[a.beacon.index()],
        &receiver_delays_[a.receiver.index()], &site_delay_, &speed_, receivers_[a.receiver.index()].data(),
        attenuation_.data(), states_[i][a.node].data(), next_state(i, a.node, a.alpha));
  }

  void add_pose(std::size_t i, const PoseObservation& p) {
    double* before = states_[i][p.node].data();
    const double heading = before[2] + wrap_angle(p.T_map_vehicle.heading_rad() - before[2]);
    ceres_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PoseResidual, 3, 4, 4>(new PoseResidual{p, heading}), nullptr, before,
        next_state(i, p.node, p.alpha));
  }

  template <int kSize>
  void prior(double* block, int index, double mean, double sigma) {
    if (sigma > 0 && std::isfinite(sigma))
      ceres_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PriorResidual, 1, kSize>(new PriorResidual{mean, sigma, index}),
          nullptr, block);
  }

  void add_priors() {
    const SharedState mean = prior_state(site_);
    const double delay_sigma = 1e6 * site_.timing.delay_sigma_s;
    for (std::size_t b = 0; b < beacons_.size(); ++b) {
      for (int i = 0; i < 3; ++i)
        if (site_.beacons[b].position_m[static_cast<std::size_t>(i)])
          prior<3>(beacons_[b].data(), i, *site_.beacons[b].position_m[static_cast<std::size_t>(i)],
                   site_.beacons[b].sigma_m[static_cast<std::size_t>(i)].value_or(INFINITY));
      if (site_.timing.delay_per.beacon)
        prior<1>(&beacon_delays_[b], 0, 1e6 * mean.beacon_delay_s[b], delay_sigma);
    }
    for (std::size_t r = 0; r < receivers_.size(); ++r) {
      for (int i = 0; i < 3; ++i)
        prior<3>(receivers_[r].data(), i, site_.receivers[r].position_m[i], site_.receivers[r].sigma_m[i]);
      if (site_.timing.delay_per.receiver)
        prior<1>(&receiver_delays_[r], 0, 1e6 * mean.receiver_delay_s[r], delay_sigma);
    }
    if (site_.timing.delay_per.site) prior<1>(&site_delay_, 0, 1e6 * mean.site_delay_s, delay_sigma);
    prior<1>(&speed_, 0, 0.0, site_.speed_sigma_mps);
    if (site_.attenuation) {
      prior<3>(attenuation_.data(), 0, site_.attenuation->amplitude_1m_v.value,
               site_.attenuation->amplitude_1m_v.sigma);
      prior<3>(attenuation_.data(), 1, site_.attenuation->absorption_np_per_m.value,
               site_.attenuation->absorption_np_per_m.sigma);
      prior<3>(attenuation_.data(), 2, 1e6 * site_.attenuation->rise_time_s.value,
               1e6 * site_.attenuation->rise_time_s.sigma);
    }
    for (const ControlDistance& d : site_.distances)
      ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<TapeResidual, 1, 3, 3>(new TapeResidual{d}),
                              nullptr, beacons_[d.from.index()].data(), beacons_[d.to.index()].data());
  }

  void hold(double* block) {
    if (ceres_.HasParameterBlock(block)) ceres_.SetParameterBlockConstant(block);
  }
  void free_one(double* block, const std::string& name, double si) {
    if (ceres_.HasParameterBlock(block)) free_.push_back({block, 0, name, si});
  }
  /// Fixed coordinates of a block stay constant; the free ones are listed by name.
  void free_three(double* block, const std::array<bool, 3>& fixed, const std::array<std::string, 3>& names,
                  const std::array<double, 3>& si) {
    if (!ceres_.HasParameterBlock(block)) return;
    std::vector<int> held;
    for (int i = 0; i < 3; ++i) {
      if (fixed[static_cast<std::size_t>(i)]) {
        held.push_back(i);
      } else {
        free_.push_back({block, i, names[static_cast<std::size_t>(i)], si[static_cast<std::size_t>(i)]});
      }
    }
    if (held.size() == 3) {
      ceres_.SetParameterBlockConstant(block);
    } else if (!held.empty()) {
      ceres_.SetManifold(block, new ceres::SubsetManifold(3, held));
    }
  }

  void hold_fixed() {
    const Timing& timing = site_.timing;
    const bool delays = timing.delay_sigma_s > 0;
    for (std::size_t b = 0; b < beacons_.size(); ++b) {
      std::array<bool, 3> fixed;
      for (std::size_t i = 0; i < 3; ++i)
        fixed[i] = site_.beacons[b].position_m[i] && site_.beacons[b].sigma_m[i].value_or(1.0) == 0.0;
      const std::string prefix = "beacon/" + site_.beacons[b].name;
      free_three(beacons_[b].data(), fixed, {prefix + "/x_m", prefix + "/y_m", prefix + "/z_m"}, {1, 1, 1});
      delays&& timing.delay_per.beacon ? free_one(&beacon_delays_[b], prefix + "/delay_s", 1e-6)
                                       : hold(&beacon_delays_[b]);
    }
    for (std::size_t r = 0; r < receivers_.size(); ++r) {
      const SiteReceiver& receiver = site_.receivers[r];
      const std::string prefix =
          "receiver/" + site_.vehicles[receiver.vehicle.index()].name + "/" + receiver.name;
      free_three(receivers_[r].data(),
                 {receiver.sigma_m[0] == 0, receiver.sigma_m[1] == 0, receiver.sigma_m[2] == 0},
                 {prefix + "/x_m", prefix + "/y_m", prefix + "/z_m"}, {1, 1, 1});
      delays&& timing.delay_per.receiver ? free_one(&receiver_delays_[r], prefix + "/delay_s", 1e-6)
                                         : hold(&receiver_delays_[r]);
    }
    delays&& timing.delay_per.site ? free_one(&site_delay_, "site/delay_s", 1e-6) : hold(&site_delay_);
    site_.speed_sigma_mps > 0 ? free_one(&speed_, "medium/speed_mps", 1.0) : hold(&speed_);
    if (site_.attenuation) {
      const AttenuationPrior& a = *site_.attenuation;
      free_three(attenuation_.data(),
                 {a.amplitude_1m_v.sigma == 0, a.absorption_np_per_m.sigma == 0, a.rise_time_s.sigma == 0},
                 {"attenuation/amplitude_1m_v", "attenuation/absorption_np_per_m", "attenuation/rise_time_s"},
                 {1, 1, 1e-6});
    } else {
      hold(attenuation_.data());
    }
    const bool offset = timing.clock == octant::Clock::kCycleOffset;
    for (auto& states : states_)
      for (State& state : states)
        if (!offset && ceres_.HasParameterBlock(state.data()))
          ceres_.SetManifold(state.data(), new ceres::SubsetManifold(4, {3}));
  }

  void collect(RefereeResult& result) {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    ceres::Covariance covariance(options);
    std::vector<const double*> blocks;
    for (const Free& f : free_)
      if (blocks.empty() || blocks.back() != f.block) blocks.push_back(f.block);
    const auto n = static_cast<Eigen::Index>(free_.size());
    result.values.resize(n);
    result.covariance.setZero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Free& f = free_[static_cast<std::size_t>(i)];
      result.parameters.push_back(f.name);
      result.values[i] = f.block[f.index] * f.si;
    }
    if (!covariance.Compute(blocks, &ceres_)) {
      result.converged = false;
      return;
    }
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) {
        const Free &a = free_[static_cast<std::size_t>(i)], &b = free_[static_cast<std::size_t>(j)];
        double block[9] = {};
        covariance.GetCovarianceBlock(a.block, b.block, block);
        result.covariance(i, j) = block[a.index * ceres_.ParameterBlockSize(b.block) + b.index] * a.si * b.si;
      }
  }

  struct Free {
    double* block;
    int index;
    std::string name;
    double si;
  };
  const calib::Problem& problem_;
  const Site& site_;
  const calib::Solution& solution_;
  ceres::Problem ceres_;
  std::vector<std::array<double, 3>> beacons_, receivers_;
  std::vector<double> beacon_delays_, receiver_delays_;
  double site_delay_ = 0.0, speed_ = 0.0;
  std::array<double, 3> attenuation_ = {1.0, 0.0, 0.0};
  std::vector<std::vector<State>> states_;
  std::vector<std::unique_ptr<State>> idle_;
  std::vector<Free> free_;
};

}  // namespace

RefereeResult referee(const calib::Problem& problem, const calib::Solution& solution) {
  return Referee(problem, solution).run();
}

}  // namespace octant::test
