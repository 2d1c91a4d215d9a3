// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// One adjustment by plain squares from the same start: the tiles, and Ceres with a residual an arrival and automatic derivatives,
// as most people write it (sparse normal equations) and as it does best here (Schur complement, vehicle states first). `cost` is
// the optimum that each found. 40 beacons, some 17 arrivals a stop, as the `large` worlds of ../shared/check.
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include "calib/adjust.h"
#include "calib/calibrate.h"
#include "calib/tile_sum.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

Scenario forty_beacons(int epochs) {
  Scenario s = hall_scenario();
  s.hall_m = {64.0, 40.0};
  s.site.beacons.clear();
  for (int i = 0; i < 40; ++i) {
    const double x = 4.0 + 8.0 * (i % 8), y = 4.0 + 8.0 * (i / 8);
    s.site.beacons.push_back(beacon("B" + std::to_string(i),
                                    {x + 0.9 * std::sin(3.0 * i), y + 0.9 * std::cos(5.0 * i), 3.0 + 0.4 * std::sin(7.0 * i)},
                                    i % 13 == 0 ? 0.0 : 0.3));
  }
  s.path.epochs = epochs;
  s.heldout_path.epochs = 1;
  s.range_m = 11.0;
  return s;
}

/// A solved problem, and the shared parameters off by so much: where both begin. A centimetre is some sigmas of an arrival, five
/// are what a start without any knowledge of places leaves at worst.
struct Start {
  calib::Problem problem;
  calib::Solution solution;
  calib::ParameterLayout layout;
  Eigen::VectorXd x;
};

const Start& start_of(int epochs, int off_mm = 10) {
  static std::map<std::pair<int, int>, Start> kept;
  if (const auto found = kept.find({epochs, off_mm}); found != kept.end()) return found->second;
  const World world = must(simulate(forty_beacons(epochs), 1));
  Start s{must(calib::make_problem(world.site, {world.run})), {}, {}, {}};
  calib::SolveOptions options;
  options.threads = 2;
  s.solution = calib::solve(s.problem, options);
  SharedState off = s.solution.state;
  for (std::size_t b = 0; b < off.beacon_p_map_m.size(); ++b)
    if (!s.problem.site.beacons[b].is_control_point())
      off.beacon_p_map_m[b] +=
          1e-3 * off_mm * Eigen::Vector3d(std::sin(2.0 * static_cast<double>(b)), std::cos(3.0 * static_cast<double>(b)), 0.5);
  for (double& v : off.speed_offset_mps) v += 0.1;
  s.layout = calib::make_layout(s.problem, s.solution.state, std::vector<bool>(off.beacon_p_map_m.size(), false));
  s.x = s.layout.vector_of(off);
  return kept.emplace(std::pair{epochs, off_mm}, std::move(s)).first->second;
}

void report(benchmark::State& state, const Start& start, double cost) {
  std::size_t arrivals = 0;
  for (const Trajectory& t : start.solution.trajectories) arrivals += t.arrivals.size();
  state.counters["arrivals"] = static_cast<double>(arrivals);
  state.counters["cost"] = cost;
  state.counters["per_arrival"] = benchmark::Counter(static_cast<double>(arrivals),
                                                     benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void adjust_tiles(benchmark::State& state) {
  const Start& start = start_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(2)));
  calib::AdjustOptions options;
  options.workers.threads = static_cast<int>(state.range(1));
  options.function_tolerance = 1e-8;
  double cost = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    std::vector<Trajectory> trajectories = start.solution.trajectories;
    Eigen::VectorXd x = start.x;
    state.ResumeTiming();
    const calib::AdjustResult result = calib::adjust(start.problem, start.layout, trajectories, x, options);
    cost = result.cost;
    state.counters["iterations"] = result.iterations;
  }
  report(state, start, cost);
}

/// The parts of an evaluation, the states beginning where the adjustment's do: what an arrival costs in nanoseconds.
void tiles_part(benchmark::State& state, int part) {
  const Start& start = start_of(static_cast<int>(state.range(0)));
  std::vector<Trajectory> trajectories = start.solution.trajectories;
  const SharedState at = start.layout.state_of(start.x);
  const calib::Workers workers{static_cast<int>(state.range(1)), nullptr};
  std::optional<calib::TileSum> tiles;
  calib::ReducedSystem sum;
  tiles.emplace(trajectories, start.layout, workers);
  double cost = tiles->settle(at, {});
  for (auto _ : state) {
    if (part == 0) tiles.emplace(trajectories, start.layout, workers);
    if (part == 1) cost = tiles->settle(at, {});
    if (part == 2) tiles->reduce(at, {}, sum);
  }
  report(state, start, cost);
}

struct ArrivalError {
  double tof_s, sigma_s, model_speed_mps;
  template <class T>
  bool operator()(const T* beacon, const T* delay_us, const T* speed_offset, const T* receiver, const T* pose,
                  T* residual) const {
    const T c = ceres::cos(pose[2]), s = ceres::sin(pose[2]);
    const T dx = pose[0] + c * receiver[0] - s * receiver[1] - beacon[0],
            dy = pose[1] + s * receiver[0] + c * receiver[1] - beacon[1];
    const T dz = receiver[2] - beacon[2];
    residual[0] =
        (tof_s - ceres::sqrt(dx * dx + dy * dy + dz * dz) / (model_speed_mps + *speed_offset) - 1e-6 * *delay_us) / sigma_s;
    return true;
  }
};

struct Prior {
  int index;
  double mean, sigma;
  template <class T>
  bool operator()(const T* block, T* residual) const {
    residual[0] = (block[index] - mean) / sigma;
    return true;
  }
};

/// All shared parameters and states as plain arrays, and the problem of them that people write.
class PerArrival {
 public:
  PerArrival(const Start& start, bool states_first) : site_(start.problem.site) {
    const SharedState state = start.layout.state_of(start.x), prior = prior_state(site_);
    for (const Eigen::Vector3d& p : state.beacon_p_map_m) beacons_.push_back({p.x(), p.y(), p.z()});
    for (const double d : state.beacon_delay_s) delays_us_.push_back(1e6 * d);
    for (const Eigen::Vector3d& o : state.receiver_p_vehicle_m) receivers_.push_back({o.x(), o.y(), o.z()});
    speed_offset_ = state.speed_offset_mps[0];
    const Trajectory& t = start.solution.trajectories[0];
    for (const Node& node : t.nodes)
      poses_.push_back(
          {node.T_map_vehicle.translation_m.x(), node.T_map_vehicle.translation_m.y(), node.T_map_vehicle.heading_rad()});
    auto* order = new ceres::ParameterBlockOrdering;
    for (const ArrivalObservation& a : t.arrivals) {
      if (a.rejection != Rejection::kUsed) continue;
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<ArrivalError, 1, 3, 1, 1, 3, 3>(
                                    new ArrivalError{a.tof_s, a.sigma_s, a.model_speed_mps}),
                                nullptr, beacons_[a.beacon.index()].data(), &delays_us_[a.beacon.index()], &speed_offset_,
                                receivers_[a.receiver.index()].data(), poses_[a.node].data());
    }
    for (std::size_t b = 0; b < beacons_.size(); ++b) {
      const SiteBeacon& beacon = site_.beacons[b];
      if (!problem_.HasParameterBlock(beacons_[b].data())) continue;
      if (beacon.is_control_point()) problem_.SetParameterBlockConstant(beacons_[b].data());
      for (int i = 0; i < 3 && !beacon.is_control_point(); ++i)
        add_prior<3>(beacons_[b].data(), i, *beacon.position_m[static_cast<std::size_t>(i)],
                     *beacon.sigma_m[static_cast<std::size_t>(i)]);
      add_prior<1>(&delays_us_[b], 0, 1e6 * prior.beacon_delay_s[b], 1e6 * site_.timing.delay_sigma_s);
    }
    for (std::size_t r = 0; r < receivers_.size(); ++r)
      for (int i = 0; i < 3; ++i)
        add_prior<3>(receivers_[r].data(), i, site_.receivers[r].position_m[i], site_.receivers[r].sigma_m[i]);
    add_prior<1>(&speed_offset_, 0, 0.0, site_.speed_sigma_mps);
    if (states_first) {
      std::vector<double*> blocks;
      problem_.GetParameterBlocks(&blocks);
      for (double* block : blocks) order->AddElementToGroup(block, 1);
      for (auto& pose : poses_)
        if (problem_.HasParameterBlock(pose.data())) order->AddElementToGroup(pose.data(), 0);
      options_.linear_solver_ordering.reset(order);
      options_.linear_solver_type = ceres::DENSE_SCHUR;
    } else {
      delete order;
      options_.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    }
    options_.function_tolerance = 1e-8;
    options_.logging_type = ceres::SILENT;
  }

  ceres::Solver::Summary solve(int threads) {
    options_.num_threads = threads;
    ceres::Solver::Summary summary;
    ceres::Solve(options_, &problem_, &summary);
    return summary;
  }

 private:
  template <int kSize>
  void add_prior(double* block, int index, double mean, double sigma) {
    if (sigma > 0)
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, 1, kSize>(new Prior{index, mean, sigma}), nullptr, block);
  }

  const Site& site_;
  ceres::Problem problem_;
  ceres::Solver::Options options_;
  std::vector<std::array<double, 3>> beacons_, receivers_, poses_;
  std::vector<double> delays_us_;
  double speed_offset_ = 0.0;
};

void adjust_per_arrival(benchmark::State& state, bool states_first) {
  const Start& start = start_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(2)));
  double cost = 0.0;
  for (auto _ : state) {
    state.PauseTiming();  // what people also wait for, but not the solver's work
    const auto began = std::chrono::steady_clock::now();
    std::optional<PerArrival> problem;
    problem.emplace(start, states_first);
    state.counters["building_s"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    state.ResumeTiming();
    const ceres::Solver::Summary summary = problem->solve(static_cast<int>(state.range(1)));
    cost = summary.final_cost;
    state.counters["iterations"] = static_cast<double>(summary.iterations.size()) - 1;
    state.PauseTiming();
    problem.reset();
    state.ResumeTiming();
  }
  report(state, start, cost);
}

constexpr auto kUnit = benchmark::kMillisecond;
BENCHMARK_CAPTURE(tiles_part, make, 0)->Args({100000, 1})->Unit(kUnit)->UseRealTime();
BENCHMARK_CAPTURE(tiles_part, settle, 1)->Args({100000, 1})->Unit(kUnit)->UseRealTime();
BENCHMARK_CAPTURE(tiles_part, reduce, 2)->Args({100000, 1})->Unit(kUnit)->UseRealTime();
/// Epochs, threads, millimetres off.
void sizes(benchmark::internal::Benchmark* b) {
  b->Args({5000, 1, 10})
      ->Args({20000, 1, 10})
      ->Args({100000, 1, 10})
      ->Args({100000, 1, 50})
      ->Args({100000, 2, 10})
      ->Unit(kUnit)
      ->UseRealTime();
}
BENCHMARK(adjust_tiles)->Apply(sizes);
BENCHMARK_CAPTURE(adjust_per_arrival, schur, true)->Apply(sizes)->Iterations(1);
BENCHMARK_CAPTURE(adjust_per_arrival, normal_equations, false)->Apply(sizes)->Iterations(1);

}  // namespace
}  // namespace octant::test
