// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A 40-minute drive with odometry at 20 Hz, adjusted by plain squares from the same start, all until the cost
// changes by less than a part in 10^6: `calibrate`'s adjustment; Ceres with analytic derivatives, states
// eliminated by odd and even ones (Schur) or all at once (sparse normal equations); and what one would write
// for this problem alone, block-tridiagonal Gauss-Newton with a border. `solve` is the whole calibration.
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "calib/adjust/adjust.h"
#include "calib/calibrate.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

constexpr double kDriveTolerance = 1e-6;

struct DriveStart {
  calib::Problem problem;
  std::vector<Trajectory> trajectories;  ///< states and marks of the solution, kept for all
  calib::ParameterLayout layout;
  Eigen::VectorXd x;  ///< beacons two centimetres off
  double best_cost = 0.0;
};

const DriveStart& drive_start(int seconds) {
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
  s.layout = calib::make_layout(s.problem, state, std::vector<bool>(state.beacon_p_map_m.size(), false));
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

void report_drive(benchmark::State& state, const DriveStart& start, double cost) {
  const auto arrivals = static_cast<double>(start.trajectories[0].arrivals.size());
  state.counters["arrivals"] = arrivals;
  state.counters["states"] = static_cast<double>(start.trajectories[0].nodes.size());
  state.counters["above_best"] = cost / start.best_cost - 1.0;
  state.counters["per_arrival"] = benchmark::Counter(
      arrivals, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

// Octant ----------------------------------------------------------------------------------------------------

void drive_solve(benchmark::State& state) {
  const DriveStart& start = drive_start(static_cast<int>(state.range(0)));
  calib::SolveOptions options;
  options.threads = static_cast<int>(state.range(1));
  for (auto _ : state) benchmark::DoNotOptimize(calib::solve(start.problem, options));
  report_drive(state, start, start.best_cost);
}

void drive_adjust(benchmark::State& state) {
  const DriveStart& start = drive_start(static_cast<int>(state.range(0)));
  calib::AdjustOptions options;
  options.workers.threads = static_cast<int>(state.range(1));
  options.function_tolerance = kDriveTolerance;
  double cost = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    std::vector<Trajectory> trajectories = start.trajectories;
    Eigen::VectorXd x = start.x;
    state.ResumeTiming();
    const calib::AdjustResult result = calib::adjust(start.problem, start.layout, trajectories, x, options);
    cost = result.cost;
    state.counters["iterations"] = result.iterations;
  }
  report_drive(state, start, cost);
}

// The same numbers for the others --------------------------------------------------------------------------

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
void odometry(const PlainStep& s, const double* A, const double* B, double* r, double* JA, double* JB) {
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

// Ceres ----------------------------------------------------------------------------------------------------

class ArrivalCost : public ceres::SizedCostFunction<1, 3, 1, 3, 1, 3, 3> {
 public:
  explicit ArrivalCost(const PlainArrival& a) : a_(a) {}
  bool Evaluate(double const* const* p, double* residual, double** J) const override {
    const double before = 1.0 - a_.alpha, after = a_.alpha;
    const double T[3] = {before * p[4][0] + after * p[5][0], before * p[4][1] + after * p[5][1],
                         before * p[4][2] + after * p[5][2]};
    const Sighting s(a_, p[0], *p[1], p[2], *p[3], T);
    residual[0] = s.residual;
    if (J == nullptr) return true;
    if (J[0] != nullptr) std::copy(s.by_beacon, s.by_beacon + 3, J[0]);
    if (J[1] != nullptr) J[1][0] = s.by_delay;
    if (J[2] != nullptr) std::copy(s.by_receiver, s.by_receiver + 3, J[2]);
    if (J[3] != nullptr) J[3][0] = s.by_speed;
    for (int i = 0; i < 3; ++i) {
      if (J[4] != nullptr) J[4][i] = before * s.by_pose[i];
      if (J[5] != nullptr) J[5][i] = after * s.by_pose[i];
    }
    return true;
  }

 private:
  PlainArrival a_;
};

class StepCost : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  explicit StepCost(const PlainStep& s) : s_(s) {}
  bool Evaluate(double const* const* p, double* residual, double** J) const override {
    odometry(s_, p[0], p[1], residual, J != nullptr ? J[0] : nullptr, J != nullptr ? J[1] : nullptr);
    return true;
  }

 private:
  PlainStep s_;
};

class BlockPrior : public ceres::CostFunction {
 public:
  BlockPrior(std::vector<double> mean, double sigma) : mean_(std::move(mean)), sigma_(sigma) {
    mutable_parameter_block_sizes()->push_back(static_cast<int>(mean_.size()));
    set_num_residuals(static_cast<int>(mean_.size()));
  }
  bool Evaluate(double const* const* p, double* residual, double** J) const override {
    const std::size_t n = mean_.size();
    for (std::size_t i = 0; i < n; ++i) {
      residual[i] = (p[0][i] - mean_[i]) / sigma_;
      if (J == nullptr || J[0] == nullptr) continue;
      for (std::size_t j = 0; j < n; ++j) J[0][i * n + j] = i == j ? 1.0 / sigma_ : 0.0;
    }
    return true;
  }

 private:
  std::vector<double> mean_;
  double sigma_;
};

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

void drive_ceres(benchmark::State& state, bool schur) {
  const DriveStart& start = drive_start(static_cast<int>(state.range(0)));
  double cost = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    PlainDrive d(start);
    ceres::Problem problem;
    for (const PlainArrival& a : d.arrivals)
      problem.AddResidualBlock(new ArrivalCost(a), nullptr, d.beacons[a.beacon].data(),
                               &d.delays_us[a.beacon], d.receivers[a.receiver].data(), &d.speed_offset,
                               d.poses[a.node].data(), d.poses[a.node + 1].data());
    for (std::size_t k = 0; k < d.steps.size(); ++k)
      problem.AddResidualBlock(new StepCost(d.steps[k]), nullptr, d.poses[k].data(), d.poses[k + 1].data());
    const Site& site = start.problem.site;
    for_each_prior(site, d, [&](std::vector<double> mean, double sigma, double* block) {
      problem.AddResidualBlock(new BlockPrior(std::move(mean), sigma), nullptr, block);
    });
    for (std::size_t b = 0; b < d.beacons.size(); ++b)
      if (site.beacons[b].is_control_point()) problem.SetParameterBlockConstant(d.beacons[b].data());
    ceres::Solver::Options options;
    options.num_threads = static_cast<int>(state.range(1));
    options.function_tolerance = kDriveTolerance;
    options.logging_type = ceres::SILENT;
    options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
    options.linear_solver_type = schur ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
    if (schur) {
      auto order = std::make_shared<ceres::ParameterBlockOrdering>();
      std::vector<double*> blocks;
      problem.GetParameterBlocks(&blocks);
      for (double* block : blocks) order->AddElementToGroup(block, 1);
      for (std::size_t k = 0; k < d.poses.size(); k += 2) order->AddElementToGroup(d.poses[k].data(), 0);
      options.linear_solver_ordering = order;
    }
    ceres::Solver::Summary summary;
    state.ResumeTiming();
    ceres::Solve(options, &problem, &summary);
    cost = summary.final_cost;
    state.counters["iterations"] = static_cast<double>(summary.iterations.size()) - 1;
  }
  report_drive(state, start, cost);
}

// Block-tridiagonal with a border ---------------------------------------------------------------------------

/// Gauss-Newton for this problem and no other: states eliminated front to back onto a dense border.
class BorderedChain {
 public:
  BorderedChain(const Site& site, PlainDrive& d) : site_(site), d_(d) {
    for (std::size_t b = 0; b < d.beacons.size(); ++b) {
      beacon_at_.push_back(site.beacons[b].is_control_point() ? -1 : size_);
      if (beacon_at_.back() >= 0) size_ += 3;
      delay_at_.push_back(size_++);
    }
    for (std::size_t r = 0; r < d.receivers.size(); ++r, size_ += 3) receiver_at_.push_back(size_);
    speed_at_ = size_++;
    G_.resize(d.poses.size());
    D_.resize(d.poses.size());
    U_.resize(d.poses.size());
    g_.resize(d.poses.size());
    for (auto& G : G_) G.resize(3, size_);
  }

  /// One step; returns the cost before it.
  double step() {
    const double cost = build();
    Eigen::LLT<Eigen::Matrix3d> llt;
    for (std::size_t k = 0; k < D_.size(); ++k) {
      llt.compute(D_[k]);
      llt.matrixL().solveInPlace(G_[k]);
      llt.matrixL().solveInPlace(g_[k]);
      H_.selfadjointView<Eigen::Lower>().rankUpdate(G_[k].transpose(), -1.0);
      h_.noalias() -= G_[k].transpose() * g_[k];
      D_[k] = llt.matrixL();
      if (k + 1 == D_.size()) break;
      llt.matrixL().solveInPlace(U_[k]);
      D_[k + 1].noalias() -= U_[k].transpose() * U_[k];
      g_[k + 1].noalias() -= U_[k].transpose() * g_[k];
      G_[k + 1].noalias() -= U_[k].transpose() * G_[k];
    }
    const Eigen::VectorXd dx = -H_.selfadjointView<Eigen::Lower>().llt().solve(h_);
    Eigen::Vector3d next = Eigen::Vector3d::Zero();
    for (std::size_t k = D_.size(); k-- > 0;) {
      Eigen::Vector3d v = -g_[k] - G_[k] * dx;
      if (k + 1 < D_.size()) v -= U_[k] * next;
      next = D_[k].triangularView<Eigen::Lower>().transpose().solve(v);
      for (int i = 0; i < 3; ++i) d_.poses[k][static_cast<std::size_t>(i)] += next[i];
    }
    move(dx);
    return cost;
  }

 private:
  double build() {
    H_.setZero(size_, size_);
    h_.setZero(size_);
    for (std::size_t k = 0; k < D_.size(); ++k) {
      D_[k].setZero();
      U_[k].setZero();
      g_[k].setZero();
      G_[k].setZero();
    }
    double cost = 0.0;
    for (const PlainArrival& a : d_.arrivals) {
      const Pose3 T = d_.at(a.node, a.alpha);
      const Sighting s(a, d_.beacons[a.beacon].data(), d_.delays_us[a.beacon],
                       d_.receivers[a.receiver].data(), d_.speed_offset, T.data());
      cost += 0.5 * s.residual * s.residual;
      int at[8];
      double value[8];
      int count = 0;
      for (int i = 0; i < 3 && beacon_at_[a.beacon] >= 0; ++i, ++count) {
        at[count] = beacon_at_[a.beacon] + i;
        value[count] = s.by_beacon[i];
      }
      at[count] = delay_at_[a.beacon];
      value[count++] = s.by_delay;
      for (int i = 0; i < 3; ++i, ++count) {
        at[count] = receiver_at_[a.receiver] + i;
        value[count] = s.by_receiver[i];
      }
      at[count] = speed_at_;
      value[count++] = s.by_speed;
      for (int i = 0; i < count; ++i) {
        h_[at[i]] += value[i] * s.residual;
        for (int j = 0; j <= i; ++j) H_(at[i], at[j]) += value[i] * value[j];
      }
      const Eigen::Vector3d by(s.by_pose[0], s.by_pose[1], s.by_pose[2]);
      const double before = 1.0 - a.alpha, after = a.alpha;
      const Eigen::Matrix3d M = by * by.transpose();
      D_[a.node] += before * before * M;
      U_[a.node] += before * after * M;
      D_[a.node + 1] += after * after * M;
      g_[a.node] += before * s.residual * by;
      g_[a.node + 1] += after * s.residual * by;
      for (int i = 0; i < count; ++i) {
        G_[a.node].col(at[i]) += before * value[i] * by;
        G_[a.node + 1].col(at[i]) += after * value[i] * by;
      }
    }
    for (std::size_t k = 0; k < d_.steps.size(); ++k) {
      Eigen::Vector3d r;
      Eigen::Matrix<double, 3, 3, Eigen::RowMajor> A, B;
      odometry(d_.steps[k], d_.poses[k].data(), d_.poses[k + 1].data(), r.data(), A.data(), B.data());
      cost += 0.5 * r.squaredNorm();
      D_[k].noalias() += A.transpose() * A;
      U_[k].noalias() += A.transpose() * B;
      D_[k + 1].noalias() += B.transpose() * B;
      g_[k].noalias() += A.transpose() * r;
      g_[k + 1].noalias() += B.transpose() * r;
    }
    for_each_prior(site_, d_, [&](const std::vector<double>& mean, double sigma, const double* block) {
      const int at = column_of(block);
      for (std::size_t i = 0; i < mean.size(); ++i) {
        const double r = (block[i] - mean[i]) / sigma;
        cost += 0.5 * r * r;
        h_[at + static_cast<int>(i)] += r / sigma;
        H_(at + static_cast<int>(i), at + static_cast<int>(i)) += 1.0 / (sigma * sigma);
      }
    });
    return cost;
  }

  [[nodiscard]] int column_of(const double* block) const {
    for (std::size_t b = 0; b < d_.beacons.size(); ++b) {
      if (block == d_.beacons[b].data()) return beacon_at_[b];
      if (block == &d_.delays_us[b]) return delay_at_[b];
    }
    for (std::size_t r = 0; r < d_.receivers.size(); ++r)
      if (block == d_.receivers[r].data()) return receiver_at_[r];
    return speed_at_;
  }

  void move(const Eigen::VectorXd& dx) {
    for (std::size_t b = 0; b < d_.beacons.size(); ++b) {
      for (int i = 0; i < 3 && beacon_at_[b] >= 0; ++i)
        d_.beacons[b][static_cast<std::size_t>(i)] += dx[beacon_at_[b] + i];
      d_.delays_us[b] += dx[delay_at_[b]];
    }
    for (std::size_t r = 0; r < d_.receivers.size(); ++r)
      for (int i = 0; i < 3; ++i) d_.receivers[r][static_cast<std::size_t>(i)] += dx[receiver_at_[r] + i];
    d_.speed_offset += dx[speed_at_];
  }

  const Site& site_;
  PlainDrive& d_;
  int size_ = 0, speed_at_ = 0;
  std::vector<int> beacon_at_, delay_at_, receiver_at_;
  std::vector<Eigen::Matrix<double, 3, Eigen::Dynamic>> G_;
  std::vector<Eigen::Matrix3d> D_, U_;
  std::vector<Eigen::Vector3d> g_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd h_;
};

void drive_bordered(benchmark::State& state) {
  const DriveStart& start = drive_start(static_cast<int>(state.range(0)));
  double cost = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    PlainDrive d(start);
    state.ResumeTiming();
    BorderedChain chain(start.problem.site, d);
    int steps = 0;
    for (double before = INFINITY; steps < 50; ++steps, before = cost) {
      cost = chain.step();
      if (std::abs(before - cost) < kDriveTolerance * cost) break;
    }
    state.counters["iterations"] = steps;
  }
  report_drive(state, start, cost);
}

constexpr auto kDriveUnit = benchmark::kMillisecond;
BENCHMARK(drive_solve)
    ->Args({2400, 1})
    ->Args({2400, 2})
    ->Args({24000, 2})
    ->Unit(kDriveUnit)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(drive_adjust)
    ->Args({2400, 1})
    ->Args({2400, 2})
    ->Unit(kDriveUnit)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(drive_bordered)->Args({2400, 1})->Unit(kDriveUnit)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK_CAPTURE(drive_ceres, schur, true)
    ->Args({2400, 1})
    ->Args({2400, 2})
    ->Unit(kDriveUnit)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Iterations(1);
BENCHMARK_CAPTURE(drive_ceres, normal_equations, false)
    ->Args({2400, 1})
    ->Unit(kDriveUnit)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Iterations(1);

}  // namespace
}  // namespace octant::test
