// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// One fix of about 16 arrivals in the hall: the least-squares localizer without an initial value, with
// covariance and protection level. For comparison, methods that estimate only the pose and start at the true
// one: Gauss-Newton in plain Eigen, and Ceres (analytic, dense). `percentiles` measures each of 10^6 fixes
// separately.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <vector>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>
#include <Eigen/Cholesky>

#include "models/localizers/least_squares/epoch_fix.h"
#include "models/trajectory/planar.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace {

struct FixWorld {
  World world;
  std::vector<std::pair<std::size_t, std::size_t>> epochs;  ///< arrivals [first, last)
};

const FixWorld& fix_world(bool echoes) {
  static const auto make = [](double echo_fraction) {
    Scenario s = hall_scenario();
    s.heldout_path.epochs = 500;
    s.echo_fraction = echo_fraction;
    FixWorld w{must(simulate(s, 1)), {}};
    const auto& arrivals = w.world.heldout.arrivals;
    for (std::size_t first = 0, last = 0; first < arrivals.size(); first = last) {
      while (last < arrivals.size() && arrivals[last].epoch == arrivals[first].epoch) ++last;
      if (last - first >= 12 && last - first <= 24) w.epochs.emplace_back(first, last);
    }
    return w;
  };
  static const FixWorld clean = make(0.0), some = make(0.05);
  return echoes ? some : clean;
}

std::span<const Arrival> arrivals_of(const FixWorld& w, std::size_t k) {
  const auto [first, last] = w.epochs[k % w.epochs.size()];
  return std::span(w.world.heldout.arrivals).subspan(first, last - first);
}

void fix_octant(benchmark::State& state, bool echoes) {
  const FixWorld& w = fix_world(echoes);
  LeastSquaresLocalizer localizer(w.world.truth);
  Fix fix;
  std::size_t k = 0, ok = 0;
  for (auto _ : state) {
    localizer.locate(Observations{arrivals_of(w, k++), {}}, fix);
    ok += fix.ok();
  }
  state.counters["ok"] = static_cast<double>(ok) / static_cast<double>(k);
}
BENCHMARK_CAPTURE(fix_octant, clean, false);
BENCHMARK_CAPTURE(fix_octant, echoes_5_percent, true);

/// Time of the thread, so that other processes do not count; the time of the clock itself does.
double processor_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// By the clock on the wall, which a busy machine shows in the last thousandth, and of the processor.
void fix_percentiles(benchmark::State& state, bool echoes) {
  constexpr std::size_t kFixes = 1'000'000;
  const FixWorld& w = fix_world(echoes);
  LeastSquaresLocalizer localizer(w.world.truth);
  Fix fix;
  std::vector<float> us(kFixes), cpu_us(kFixes);
  for (auto _ : state)
    for (std::size_t k = 0; k < kFixes; ++k) {
      const double cpu_began = processor_us();
      const auto began = std::chrono::steady_clock::now();
      localizer.locate(Observations{arrivals_of(w, k), {}}, fix);
      us[k] = std::chrono::duration<float, std::micro>(std::chrono::steady_clock::now() - began).count();
      cpu_us[k] = static_cast<float>(processor_us() - cpu_began);
    }
  std::sort(us.begin(), us.end());
  std::sort(cpu_us.begin(), cpu_us.end());
  state.counters["p50_us"] = us[kFixes / 2];
  state.counters["p99_us"] = us[kFixes - kFixes / 100];
  state.counters["p99.9_us"] = us[kFixes - kFixes / 1000];
  state.counters["cpu_p99_us"] = cpu_us[kFixes - kFixes / 100];
  state.counters["cpu_p99.9_us"] = cpu_us[kFixes - kFixes / 1000];
}
BENCHMARK_CAPTURE(fix_percentiles, clean, false)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fix_percentiles, echoes_5_percent, true)->Iterations(1)->Unit(benchmark::kMillisecond);

/// Where the vehicle truly is, for those that do not search.
PlanarNode start_of(const FixWorld& w, std::span<const Arrival> arrivals) {
  Pose T;
  static_cast<void>(interpolate_poses(w.world.heldout.truth, arrivals.front().time_s, 10.0, T));
  return {T.translation_m.x() + 0.05, T.translation_m.y() - 0.05, PlanarTurn(T.heading_rad() + 0.05)};
}

struct PlainFix {
  Eigen::Vector3d o, p;
  double tof_s, delay_s, speed_mps, sigma_s;
  void row(const double* x, double& r, double* J) const {
    const double c = std::cos(x[2]), s = std::sin(x[2]);
    const double lx = c * o.x() - s * o.y(), ly = s * o.x() + c * o.y();
    const Eigen::Vector3d v(x[0] + lx - p.x(), x[1] + ly - p.y(), o.z() - p.z());
    const double d = v.norm(), k = -1.0 / (speed_mps * sigma_s * d);
    r = (tof_s - delay_s - d / speed_mps) / sigma_s;
    if (J == nullptr) return;
    J[0] = k * v.x();
    J[1] = k * v.y();
    J[2] = k * (v.y() * lx - v.x() * ly);
  }
};

std::vector<PlainFix> plain_of(const FixWorld& w, std::span<const Arrival> arrivals) {
  const Deployment& d = w.world.truth;
  std::vector<PlainFix> out;
  for (const Arrival& a : arrivals)
    out.push_back({d.receivers[a.receiver.index()].position_m, d.beacons[a.beacon.index()].position_m,
                   a.tof_s, d.beacons[a.beacon.index()].delay_s + d.receivers[a.receiver.index()].delay_s,
                   d.speed_mps(d.medium.temperature_degC), 1e-5});
  return out;
}

void fix_eigen(benchmark::State& state) {
  const FixWorld& w = fix_world(false);
  std::size_t k = 0;
  for (auto _ : state) {
    const auto arrivals = arrivals_of(w, k++);
    const std::vector<PlainFix> rows = plain_of(w, arrivals);
    const PlanarNode at = start_of(w, arrivals);
    Eigen::Vector3d x(at.x_m, at.y_m, at.heading.angle_rad());
    for (int i = 0; i < 20; ++i) {
      Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
      Eigen::Vector3d g = Eigen::Vector3d::Zero(), J;
      for (const PlainFix& row : rows) {
        double r = 0.0;
        row.row(x.data(), r, J.data());
        H += J * J.transpose();
        g += r * J;
      }
      const Eigen::Vector3d step = -H.ldlt().solve(g);
      x += step;
      if (-g.dot(step) < 1e-8) break;
    }
    benchmark::DoNotOptimize(x);
  }
}
BENCHMARK(fix_eigen);

class FixCost : public ceres::CostFunction {
 public:
  explicit FixCost(const std::vector<PlainFix>* rows) : rows_(rows) {
    mutable_parameter_block_sizes()->push_back(3);
    set_num_residuals(static_cast<int>(rows->size()));
  }
  bool Evaluate(double const* const* x, double* residuals, double** J) const override {
    for (std::size_t i = 0; i < rows_->size(); ++i)
      (*rows_)[i].row(x[0], residuals[i], J != nullptr && J[0] != nullptr ? J[0] + 3 * i : nullptr);
    return true;
  }

 private:
  const std::vector<PlainFix>* rows_;
};

void fix_ceres(benchmark::State& state) {
  const FixWorld& w = fix_world(false);
  std::size_t k = 0;
  for (auto _ : state) {
    const auto arrivals = arrivals_of(w, k++);
    const std::vector<PlainFix> rows = plain_of(w, arrivals);
    const PlanarNode at = start_of(w, arrivals);
    double x[3] = {at.x_m, at.y_m, at.heading.angle_rad()};
    ceres::Problem problem;
    problem.AddResidualBlock(new FixCost(&rows), nullptr, x);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    benchmark::DoNotOptimize(x);
  }
}
BENCHMARK(fix_ceres);

}  // namespace
}  // namespace octant::test
