// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A 40-minute drive with odometry at 20 Hz, adjusted by least squares from one start, until the cost changes
// by less than a part in 10^6. Compares `calibrate`'s adjustment, a special solver for this problem
// (block-tridiagonal Gauss-Newton with a border) and Ceres (drive_ceres_bench.cc). `solve` is the whole
// calibration.
#include <Eigen/Cholesky>

#include "tests/bench/plain_drive.h"

namespace octant::test {
namespace {

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

}  // namespace
}  // namespace octant::test
