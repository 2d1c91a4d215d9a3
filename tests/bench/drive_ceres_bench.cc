// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Ceres on the drive of drive_bench.cc, with analytic derivatives: a residual block an observation, or one an
// interval between two states with all its arrivals and its odometry; states eliminated by odd and even ones
// (Schur) or all at once (sparse normal equations, ordered by SuiteSparse).
#include <algorithm>
#include <memory>

#include <ceres/ceres.h>

#include "tests/bench/plain_drive.h"

namespace octant::test {
namespace {

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

/// All that lies between two states: arrivals, then odometry.
class IntervalCost : public ceres::CostFunction {
 public:
  /// @param blocks  takes the parameters in the order in which they are asked for
  IntervalCost(PlainDrive& d, std::size_t first, std::size_t last, const PlainStep& step,
               std::vector<double*>& blocks)
      : step_(step) {
    const auto at = [&](double* block, int size) {
      const auto found = std::find(blocks.begin(), blocks.end(), block);
      if (found == blocks.end()) {
        blocks.push_back(block);
        mutable_parameter_block_sizes()->push_back(size);
        return static_cast<int>(blocks.size()) - 1;
      }
      return static_cast<int>(found - blocks.begin());
    };
    mutable_parameter_block_sizes()->assign(blocks.size(), 3);  // the two states
    for (std::size_t i = first; i < last; ++i) {
      const PlainArrival& a = d.arrivals[i];
      heard_.push_back({a, at(d.beacons[a.beacon].data(), 3), at(&d.delays_us[a.beacon], 1),
                        at(d.receivers[a.receiver].data(), 3), at(&d.speed_offset, 1)});
    }
    set_num_residuals(static_cast<int>(last - first) + 3);
  }

  bool Evaluate(double const* const* p, double* residual, double** J) const override {
    for (std::size_t b = 0; J != nullptr && b < parameter_block_sizes().size(); ++b)
      if (J[b] != nullptr) std::fill(J[b], J[b] + num_residuals() * parameter_block_sizes()[b], 0.0);
    for (std::size_t i = 0; i < heard_.size(); ++i) {
      const Heard& h = heard_[i];
      const double before = 1.0 - h.a.alpha, after = h.a.alpha;
      const double T[3] = {before * p[0][0] + after * p[1][0], before * p[0][1] + after * p[1][1],
                           before * p[0][2] + after * p[1][2]};
      const Sighting s(h.a, p[h.beacon], *p[h.delay], p[h.receiver], *p[h.speed], T);
      residual[i] = s.residual;
      if (J == nullptr) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        if (J[h.beacon] != nullptr) J[h.beacon][3 * i + k] = s.by_beacon[k];
        if (J[h.receiver] != nullptr) J[h.receiver][3 * i + k] = s.by_receiver[k];
        if (J[0] != nullptr) J[0][3 * i + k] = before * s.by_pose[k];
        if (J[1] != nullptr) J[1][3 * i + k] = after * s.by_pose[k];
      }
      if (J[h.delay] != nullptr) J[h.delay][i] = s.by_delay;
      if (J[h.speed] != nullptr) J[h.speed][i] = s.by_speed;
    }
    const std::size_t n = heard_.size();
    odometry(step_, p[0], p[1], residual + n, J != nullptr && J[0] != nullptr ? J[0] + 3 * n : nullptr,
             J != nullptr && J[1] != nullptr ? J[1] + 3 * n : nullptr);
    return true;
  }

 private:
  struct Heard {
    PlainArrival a;
    int beacon, delay, receiver, speed;  ///< which block
  };
  std::vector<Heard> heard_;
  PlainStep step_;
};

enum class CeresWay { kSchur, kNormalEquations, kIntervals };

void add_observations(PlainDrive& d, CeresWay way, ceres::Problem& problem) {
  if (way == CeresWay::kIntervals) {
    std::size_t first = 0;
    for (std::size_t k = 0; k < d.steps.size(); ++k) {
      std::size_t last = first;
      while (last < d.arrivals.size() && d.arrivals[last].node == k) ++last;
      std::vector<double*> blocks = {d.poses[k].data(), d.poses[k + 1].data()};
      auto* cost = new IntervalCost(d, first, last, d.steps[k], blocks);
      problem.AddResidualBlock(cost, nullptr, blocks);
      first = last;
    }
    return;
  }
  for (const PlainArrival& a : d.arrivals)
    problem.AddResidualBlock(new ArrivalCost(a), nullptr, d.beacons[a.beacon].data(), &d.delays_us[a.beacon],
                             d.receivers[a.receiver].data(), &d.speed_offset, d.poses[a.node].data(),
                             d.poses[a.node + 1].data());
  for (std::size_t k = 0; k < d.steps.size(); ++k)
    problem.AddResidualBlock(new StepCost(d.steps[k]), nullptr, d.poses[k].data(), d.poses[k + 1].data());
}

void drive_ceres(benchmark::State& state, CeresWay way) {
  const DriveStart& start = drive_start(static_cast<int>(state.range(0)));
  double cost = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    PlainDrive d(start);
    ceres::Problem problem;
    add_observations(d, way, problem);
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
    const bool schur = way == CeresWay::kSchur;
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

constexpr auto kCeresUnit = benchmark::kMillisecond;
BENCHMARK_CAPTURE(drive_ceres, schur, CeresWay::kSchur)
    ->Args({2400, 1})
    ->Args({2400, 2})
    ->Unit(kCeresUnit)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Iterations(1);
BENCHMARK_CAPTURE(drive_ceres, normal_equations, CeresWay::kNormalEquations)
    ->Args({2400, 1})
    ->Unit(kCeresUnit)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Iterations(1);
BENCHMARK_CAPTURE(drive_ceres, intervals, CeresWay::kIntervals)
    ->Args({2400, 1})
    ->Unit(kCeresUnit)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Iterations(1);

}  // namespace
}  // namespace octant::test
