// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/clocks/clock_fit.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "calib/problem/ranges.h"
#include "models/support/normal_noise.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {
namespace {

/// Scale of Cauchy's loss while the noise is unknown, in sigmas.
constexpr double kRobustScale = 3.0;
/// Scale of Cauchy's loss at the beginning, in extents of the site.
constexpr double kCoarseShare = 0.05;
constexpr double kLeastRedundancyShare = 0.2;
constexpr int kNoiseRounds = 6;
/// Change of the noise at which it is found.
constexpr double kSameNoise = 0.02;

/// Information of an element without observations [1/m^2].
constexpr double kLeastInformation = 1e-12;

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Columns of the free elements of x.
struct FreeColumns {
  std::vector<int> column;
  int count = 0;
  explicit FreeColumns(const ClockProblem& problem) {
    for (const bool fixed : fixed_elements(problem)) column.push_back(fixed ? -1 : count++);
  }
};

/// Normal equations with the weights of a loss.
class ClockNormals {
 public:
  ClockNormals(const ClockProblem& problem, double scale)
      : p_(problem), free_(problem), loss_{scale, scale} {}

  [[nodiscard]] double cost(const Eigen::VectorXd& x) const {
    double sum = 0.0;
    for (const ClockRow& row : rows_at(p_, x)) static_cast<void>(weigh(row, sum));
    return sum;
  }

  /// @param all  false: the receptions alone
  void linearise(const Eigen::VectorXd& x, bool all = true) {
    g = Eigen::VectorXd::Zero(free_.count);
    cost_ = 0.0;
    std::vector<Eigen::Triplet<double>> entries;
    const std::vector<ClockRow> rows = rows_at(p_, x);
    Eigen::Index r = 0;
    for (const ClockRow& row : rows) {
      const bool counts = all || row.kind == ClockRowKind::kReception;
      const double root = counts ? std::sqrt(weigh(row, cost_)) : 0.0;
      for (int i = 0; i < row.size; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const int column = free_.column[static_cast<std::size_t>(row.at[k])];
        if (column < 0) continue;
        entries.emplace_back(r, column, root * row.by[k]);
        g[column] -= root * root * row.by[k] * row.residual;
      }
      ++r;
    }
    SparseMatrix J(static_cast<Eigen::Index>(rows.size()), free_.count);
    J.setFromTriplets(entries.begin(), entries.end());
    H = SparseMatrix(J.transpose()) * J;
    if (!all) return;
    // Unknown times of transmissions whose receptions are all left out.
    for (Eigen::Index i = 0; i < H.cols(); ++i) H.coeffRef(i, i) += kLeastInformation;
  }

  /// Step with damping; empty if singular.
  [[nodiscard]] Eigen::VectorXd step(double lambda) {
    SparseMatrix damped = H;
    for (Eigen::Index i = 0; i < damped.cols(); ++i) damped.coeffRef(i, i) += lambda * H.coeff(i, i);
    if (!analysed_) solver_.analyzePattern(damped);
    analysed_ = true;
    solver_.factorize(damped);
    if (solver_.info() != Eigen::Success) return {};
    return solver_.solve(g);
  }

  [[nodiscard]] Eigen::VectorXd stepped(const Eigen::VectorXd& x, const Eigen::VectorXd& step) const {
    Eigen::VectorXd y = x;
    for (std::size_t i = 0; i < free_.column.size(); ++i)
      if (free_.column[i] >= 0) y[static_cast<Eigen::Index>(i)] += step[free_.column[i]];
    return y;
  }

  [[nodiscard]] double linearised_cost() const { return cost_; }
  [[nodiscard]] const FreeColumns& free() const { return free_; }

  SparseMatrix H;
  Eigen::VectorXd g;

 private:
  /// Adds the cost of a row and returns its weight.
  [[nodiscard]] double weigh(const ClockRow& row, double& sum) const {
    if (row.kind == ClockRowKind::kReception) {
      if (!p_.receptions[row.index].used) return 0.0;
      return loss_.weigh(row.residual, sum);
    }
    sum += 0.5 * row.residual * row.residual;
    return 1.0;
  }

  const ClockProblem& p_;
  FreeColumns free_;
  RobustLoss loss_;
  double cost_ = 0.0;
  bool analysed_ = false;
  Eigen::SimplicialLDLT<SparseMatrix> solver_;
};

/// Redundancy of the receptions: their number without the sum of their leverages, tr(H^-1 J'J), by
/// Hutchinson's estimator.
double redundancy_of(const ClockProblem& problem, const Eigen::VectorXd& x, double receptions) {
  constexpr int kProbes = 24;
  ClockNormals all(problem, 0.0), part(problem, 0.0);
  all.linearise(x);
  part.linearise(x, false);
  const Eigen::SimplicialLDLT<SparseMatrix> solver(all.H);
  if (solver.info() != Eigen::Success) return 1.0;
  std::mt19937_64 random(1);
  double trace = 0.0;
  Eigen::VectorXd z(all.H.cols());
  for (int probe = 0; probe < kProbes; ++probe) {
    for (double& sign : z) sign = (random() & 1U) != 0U ? 1.0 : -1.0;
    trace += solver.solve(z).dot(part.H * z) / kProbes;
  }
  return std::max(receptions - trace, 1.0);
}

/// Receptions used, unknowns, redundancy, variance factor of the receptions.
void count(const ClockProblem& problem, ClockFit& fit) {
  fit.used = static_cast<std::size_t>(std::ranges::count(problem.receptions, true, &ClockReception::used));
  fit.rejected = problem.receptions.size() - fit.used;
  fit.unknowns = static_cast<std::size_t>(FreeColumns(problem).count);
  double squares = 0.0;
  for (const ClockRow& row : rows_at(problem, fit.x))
    if (row.kind == ClockRowKind::kReception && problem.receptions[row.index].used)
      squares += row.residual * row.residual;
  fit.redundancy = redundancy_of(problem, fit.x, static_cast<double>(fit.used));
  fit.variance_factor = squares / fit.redundancy;
}

/// Marks receptions by their residuals.
/// @return true if a mark has changed
bool mark(ClockProblem& problem, const Eigen::VectorXd& x, double limit) {
  bool changed = false;
  for (const ClockRow& row : rows_at(problem, x)) {
    if (row.kind != ClockRowKind::kReception) continue;
    ClockReception& r = problem.receptions[row.index];
    const bool used = std::abs(row.residual) <= limit;
    changed = changed || used != r.used;
    r.used = used;
  }
  return changed;
}

}  // namespace

double robust_sigma(const ClockProblem& problem, const Eigen::VectorXd& x) {
  // Deviations from the mean of a transmission, whose unknown time they do not contain.
  std::vector<std::vector<double>> of(problem.transmissions);
  double receptions = 0.0;
  for (const ClockRow& row : rows_at(problem, x))
    if (row.kind == ClockRowKind::kReception)
      of[problem.receptions[row.index].transmission].push_back(row.residual), receptions += 1.0;
  std::vector<double> sizes;
  for (const std::vector<double>& residuals : of) {
    const auto n = static_cast<double>(residuals.size());
    double mean = 0.0;
    for (const double r : residuals) mean += r / n;
    for (const double r : residuals)
      sizes.push_back(std::abs(r - mean) * std::sqrt(n / std::max(n - 1.0, 1.0)));
  }
  if (sizes.empty()) return 1.0;
  // The other unknowns absorb a share of the deviations.
  const double free = receptions - static_cast<double>(problem.transmissions),
               unknowns = static_cast<double>(3 * (problem.points.size() + problem.site.beacons.size()));
  const double share = std::max(1.0 - unknowns / std::max(free, 1.0), kLeastRedundancyShare);
  return median(std::move(sizes)) / kMedianOfNormal / std::sqrt(share);
}

ClockFit adjust_clocks(const ClockProblem& problem, Eigen::VectorXd x, double scale, int most_iterations) {
  constexpr double kMostDamping = 1e10, kSameCost = 1e-7;
  ClockNormals normals(problem, scale);
  ClockFit fit;
  double lambda = 1e-4;
  fit.cost = normals.cost(x);
  for (; fit.iterations < most_iterations && !fit.converged; ++fit.iterations) {
    normals.linearise(x);
    bool better = false;
    while (!better && lambda < kMostDamping) {
      const Eigen::VectorXd step = normals.step(lambda);
      const Eigen::VectorXd next = step.size() > 0 ? normals.stepped(x, step) : x;
      const double cost = step.size() > 0 ? normals.cost(next) : INFINITY;
      better = cost < fit.cost;
      lambda *= better ? 0.2 : 8.0;
      if (!better) continue;
      fit.converged = fit.cost - cost < kSameCost * (1.0 + cost);
      fit.cost = cost;
      x = next;
    }
    if (!better) {  // no descent is left at the precision of the numbers
      fit.converged = true;
    }
    lambda = std::max(lambda, 1e-9);
    if (lambda >= kMostDamping) lambda = 1e-4;
  }
  fit.x = std::move(x);
  return fit;
}

ClockFit adjust_and_reject(ClockProblem& problem, Eigen::VectorXd x, double rejection) {
  ClockFit fit;
  for (ClockReception& r : problem.receptions) r.used = true;
  // Points between those of the start begin at a distance.
  x = adjust_clocks(problem, std::move(x),
                    std::max(kRobustScale, kCoarseShare * problem.extent_m / problem.sigma_m), 15)
          .x;
  int iterations = 0;
  for (int round = 0; round < kNoiseRounds; ++round) {  // the noise, robustly
    fit = adjust_clocks(problem, std::move(x), kRobustScale);
    x = fit.x;
    iterations += fit.iterations;
    const double sigma = robust_sigma(problem, x);
    problem.sigma_m *= std::max(sigma, 1e-3);
    if (std::abs(sigma - 1.0) < kSameNoise) break;
  }
  for (int round = 0; round < kNoiseRounds; ++round) {  // by squares, without outliers
    const bool changed = mark(problem, x, rejection);
    fit = adjust_clocks(problem, std::move(x), 0.0);
    count(problem, fit);
    x = fit.x;
    iterations += fit.iterations;
    const double factor = std::sqrt(fit.variance_factor);
    problem.sigma_m *= std::max(factor, 1e-3);
    if (!changed && std::abs(factor - 1.0) < kSameNoise) break;
  }
  fit.iterations = iterations;
  fit.noise_factor = problem.sigma_m / (problem.speed_mps * problem.site.noise.tof_sigma_s);
  return fit;
}

Eigen::MatrixXd covariance_of(const ClockProblem& problem, const ClockFit& fit,
                              const std::vector<int>& elements) {
  ClockNormals normals(problem, 0.0);
  normals.linearise(fit.x);
  Eigen::SimplicialLDLT<SparseMatrix> solver(normals.H);
  const auto n = static_cast<Eigen::Index>(elements.size());
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0.0)) return {};
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
  const auto column = [&](Eigen::Index i) {
    return normals.free().column[static_cast<std::size_t>(elements[static_cast<std::size_t>(i)])];
  };
  for (Eigen::Index j = 0; j < n; ++j) {
    if (column(j) < 0) continue;
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(normals.free().count, column(j));
    const Eigen::VectorXd of_j = solver.solve(unit);
    for (Eigen::Index i = 0; i < n; ++i)
      if (column(i) >= 0) C(i, j) = of_j[column(i)];
  }
  return 0.5 * (C + C.transpose());
}

}  // namespace octant::calib
