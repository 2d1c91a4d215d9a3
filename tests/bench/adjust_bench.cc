// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// One adjustment by plain squares from the same start: the tiles, and Ceres with a residual an arrival and
// automatic derivatives, as most people write it (sparse normal equations) and as it does best here (Schur
// complement, vehicle states first). `cost` is the optimum that each found. 40 beacons, some 17 arrivals a
// stop, as the `large` worlds of ../shared/check; with OCTANT_LARGE_WORLD=FOLDER (a site.yaml and a run in
// it) such a world itself.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include "calib/adjust/adjust.h"
#include "calib/adjust/tile_sum.h"
#include "calib/calibrate.h"
#include "calib/start/held_states.h"
#include "calib/start/start.h"
#include "io/run/run_folder.h"
#include "io/site/site_yaml.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

/// Relative change of the cost at which all stop, Ceres' own default.
constexpr double kTolerance = 1e-6;

/// A hall like the `large` worlds of ../shared/check: 60 x 40 m, a beacon every 7.5 m, all but three known to
/// 0.3 m.
Scenario forty_beacons(int epochs) {
  Scenario s = hall_scenario();
  s.hall_m = {60.0, 40.0};
  s.site.beacons.clear();
  for (int i = 0; i < 40; ++i) {
    const int row = i / 8;
    const double x = 4.0 + 7.4 * (i % 8), y = 4.0 + 8.0 * row;
    s.site.beacons.push_back(
        beacon("B" + std::to_string(i),
               {x + 0.9 * std::sin(3.0 * i), y + 0.9 * std::cos(5.0 * i), 3.0 + 0.4 * std::sin(7.0 * i)},
               i == 0 || i == 7 || i == 32 ? 0.0 : 0.3));
  }
  s.path.epochs = epochs;
  s.heldout_path.epochs = 1;
  s.range_m = 12.0;
  return s;
}

/// Where all begin.
enum class From {
  kNear,  ///< the solved problem with all beacons a centimetre off, some sigmas of an arrival
  kSite,  ///< values of the site file, each stop located by a search among its beacons
};

struct Start {
  calib::Problem problem;
  std::vector<Trajectory> trajectories;
  calib::ParameterLayout layout;
  Eigen::VectorXd x;
  double best_cost = 0.0;  ///< cost of these arrivals under least squares
};

/// A hall with this number of stops; without one, the world whose folder the environment names.
calib::Problem problem_with(int epochs) {
  if (epochs > 0) {
    const World world = must(simulate(forty_beacons(epochs), 1));
    return must(calib::make_problem(world.site, {world.run}));
  }
  const char* const named = std::getenv("OCTANT_LARGE_WORLD");
  if (named == nullptr) throw std::runtime_error("OCTANT_LARGE_WORLD names no folder");
  const std::string folder = named;
  const Site site = must(io::read_site(folder + "/site.yaml"));
  return must(calib::make_problem(site, {must(io::read_run(folder + "/run", names_of(site), site.timing))}));
}

/// Leaves out the arrivals of stops that the search among rough beacons turned about, of a hundred thousand a
/// few: plain squares do not turn them back, or some of them, and then the optima are not the same.
void leave_out_misplaced(Trajectory& t, Trajectory& solved) {
  constexpr double kTurnedRad = 0.5;
  for (const Segment& s : t.segments) {
    const double off_rad = t.nodes[s.first_node].T_map_vehicle.heading_rad() -
                           solved.nodes[s.first_node].T_map_vehicle.heading_rad();
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
      const bool placed = t.nodes[s.first_node].placed && std::abs(wrap_angle(off_rad)) < kTurnedRad;
      const bool used = solved.arrivals[i].rejection == Rejection::kUsed;
      t.arrivals[i].rejection = solved.arrivals[i].rejection =
          used && placed ? Rejection::kUsed : Rejection::kNoPose;
    }
  }
}

const Start& start_of(int epochs, From from) {
  static std::map<std::pair<int, From>, Start> kept;
  if (const auto found = kept.find({epochs, from}); found != kept.end()) return found->second;
  Start s{problem_with(epochs), {}, {}, {}};
  calib::SolveOptions options;
  options.threads = 2;
  calib::Solution solution = calib::solve(s.problem, options);
  SharedState state = solution.state;
  s.layout = calib::make_layout(s.problem, state);
  Eigen::VectorXd best = s.layout.vector_of(state);
  if (from == From::kNear) {
    s.trajectories = solution.trajectories;
    for (std::size_t b = 0; b < state.beacon_p_map_m.size(); ++b)
      if (!s.problem.site.beacons[b].is_control_point())
        state.beacon_p_map_m[b] += 0.01 * Eigen::Vector3d(std::sin(2.0 * static_cast<double>(b)),
                                                          std::cos(3.0 * static_cast<double>(b)), 0.5);
    for (double& v : state.speed_offset_mps) v += 0.1;
  } else {
    calib::Start start = calib::initial_values(s.problem, 2);
    s.trajectories = std::move(start.trajectories);
    leave_out_misplaced(s.trajectories[0], solution.trajectories[0]);
    state = start.state;
  }
  s.x = s.layout.vector_of(state);
  calib::AdjustOptions to_the_end;
  to_the_end.workers.threads = 2;
  to_the_end.function_tolerance = 1e-13;
  s.best_cost = calib::adjust(s.problem, s.layout, solution.trajectories, best, to_the_end).cost;
  return kept.emplace(std::pair{epochs, from}, std::move(s)).first->second;
}

From from_of(const benchmark::State& state) { return state.range(2) == 0 ? From::kNear : From::kSite; }

void report(benchmark::State& state, const Start& start, double cost) {
  std::size_t arrivals = 0;
  for (const Trajectory& t : start.trajectories)
    for (const ArrivalObservation& a : t.arrivals) arrivals += a.rejection == Rejection::kUsed ? 1 : 0;
  state.counters["arrivals"] = static_cast<double>(arrivals);
  state.counters["cost"] = cost;
  state.counters["above_best"] = cost / start.best_cost - 1.0;
  state.counters["per_arrival"] =
      benchmark::Counter(static_cast<double>(arrivals),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Like `calibrate` with a long log: first an evenly spread part of the stops, with constrained headings
/// until the beacons are approximately right.
void adjust_part(const Start& start, const std::vector<Trajectory>& trajectories, Eigen::VectorXd& x,
                 calib::AdjustOptions options) {
  constexpr std::size_t kStops = 1200;
  const std::size_t stride = std::max<std::size_t>(1, trajectories[0].segments.size() / kStops);
  std::vector<Trajectory> part = {some_segments(trajectories[0], stride)};
  {
    options.function_tolerance = 1e-4;
    const calib::HeldStates held = calib::HeldStates::headings(&part);
    calib::adjust(start.problem, start.layout, part, x, options);
  }
  options.function_tolerance = kTolerance;
  calib::adjust(start.problem, start.layout, part, x, options);
}

void adjust_tiles(benchmark::State& state) {
  const Start& start = start_of(static_cast<int>(state.range(0)), from_of(state));
  calib::AdjustOptions options;
  options.workers.threads = static_cast<int>(state.range(1));
  options.function_tolerance = kTolerance;
  double cost = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    std::vector<Trajectory> trajectories = start.trajectories;
    Eigen::VectorXd x = start.x;
    state.ResumeTiming();
    adjust_part(start, trajectories, x, options);
    const calib::AdjustResult result = calib::adjust(start.problem, start.layout, trajectories, x, options);
    cost = result.cost;
    state.counters["iterations"] = result.iterations;
  }
  report(state, start, cost);
}

/// The parts of an evaluation, the states beginning where the adjustment's do: what an arrival costs in
/// nanoseconds.
void tiles_part(benchmark::State& state, int part) {
  const Start& start = start_of(static_cast<int>(state.range(0)), From::kNear);
  std::vector<Trajectory> trajectories = start.trajectories;
  const SharedState at = start.layout.state_of(start.x);
  const calib::Workers workers{static_cast<int>(state.range(1)), nullptr};
  std::optional<calib::TileSum> tiles;
  calib::ReducedSystem sum;
  tiles.emplace(trajectories, start.layout, workers);
  double cost = tiles->solve_states(at, {});
  for (auto _ : state) {
    if (part == 0) tiles.emplace(trajectories, start.layout, workers);
    if (part == 1) cost = tiles->solve_states(at, {});
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
    residual[0] = (tof_s - ceres::sqrt(dx * dx + dy * dy + dz * dz) / (model_speed_mps + *speed_offset) -
                   1e-6 * *delay_us) /
                  sigma_s;
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
    const Trajectory& t = start.trajectories[0];
    for (const Node& node : t.nodes)
      poses_.push_back({node.T_map_vehicle.translation_m.x(), node.T_map_vehicle.translation_m.y(),
                        node.T_map_vehicle.heading_rad()});
    auto* order = new ceres::ParameterBlockOrdering;
    for (const ArrivalObservation& a : t.arrivals) {
      if (a.rejection != Rejection::kUsed) continue;
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<ArrivalError, 1, 3, 1, 1, 3, 3>(
                                    new ArrivalError{a.tof_s, a.sigma_s, a.model_speed_mps}),
                                nullptr, beacons_[a.beacon.index()].data(), &delays_us_[a.beacon.index()],
                                &speed_offset_, receivers_[a.receiver.index()].data(), poses_[a.node].data());
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
        add_prior<3>(receivers_[r].data(), i, site_.receivers[r].position_m[i],
                     site_.receivers[r].sigma_m[i]);
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
    options_.function_tolerance = kTolerance;
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
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Prior, 1, kSize>(new Prior{index, mean, sigma}), nullptr, block);
  }

  const Site& site_;
  ceres::Problem problem_;
  ceres::Solver::Options options_;
  std::vector<std::array<double, 3>> beacons_, receivers_, poses_;
  std::vector<double> delays_us_;
  double speed_offset_ = 0.0;
};

void adjust_per_arrival(benchmark::State& state, bool states_first) {
  const Start& start = start_of(static_cast<int>(state.range(0)), from_of(state));
  double cost = 0.0;
  for (auto _ : state) {
    state.PauseTiming();  // what people also wait for, but not the solver's work
    const auto began = std::chrono::steady_clock::now();
    std::optional<PerArrival> problem;
    problem.emplace(start, states_first);
    state.counters["building_s"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
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
BENCHMARK_CAPTURE(tiles_part, solve_states, 1)->Args({100000, 1})->Unit(kUnit)->UseRealTime();
BENCHMARK_CAPTURE(tiles_part, reduce, 2)->Args({100000, 1})->Unit(kUnit)->UseRealTime();
/// Epochs, threads, from where.
void sizes(benchmark::internal::Benchmark* b) {
  if (std::getenv("OCTANT_LARGE_WORLD") != nullptr) b->Args({0, 1, 0})->Args({0, 1, 1})->Args({0, 2, 1});
  b->Args({5000, 1, 0})
      ->Args({20000, 1, 1})
      ->Args({100000, 1, 0})
      ->Args({100000, 1, 1})
      ->Args({100000, 2, 1})
      ->Unit(kUnit)
      ->UseRealTime();
}
BENCHMARK(adjust_tiles)->Apply(sizes);
BENCHMARK_CAPTURE(adjust_per_arrival, schur, true)->Apply(sizes)->Iterations(1);
BENCHMARK_CAPTURE(adjust_per_arrival, normal_equations, false)->Apply(sizes)->Iterations(1);

}  // namespace
}  // namespace octant::test
