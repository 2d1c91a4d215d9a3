// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "calib/errors/error_sample.h"
#include "calib/errors/statistics.h"
#include "calib/problem/ranges.h"
#include "models/simulator/random.h"
#include "models/support/parallel.h"

namespace octant::calib {
namespace {

constexpr std::size_t kTestedRows = 3'000;  ///< of a long log of stops, to see whether it is white at all
constexpr std::size_t kMostRows = 40'000;
constexpr std::size_t kFewestObservations =
    30;  ///< observations of a kind below which nothing is told of its errors
constexpr double kWhitenessSignificance =
    1e-4;                                  ///< of the test whether residuals are white, all sums together
constexpr Eigen::Index kDraws = 48;        ///< of white noise in the test
constexpr Eigen::Index kModelDraws = 120;  ///< of the fitted errors
constexpr int kReweightings = 2;
constexpr double kRidge = 0.05;       ///< of the correlation of the sums, which some hundred draws tell
constexpr double kLeastShare = 0.02;  ///< share of a component that residuals must show
constexpr double kFewestFreedoms = 3.0;
constexpr std::uint64_t kSeed = 20261122;

/// Sums of values over the cells of a partition, one column each.
Eigen::MatrixXd cell_sums(const std::vector<std::int32_t>& cell, std::int32_t count,
                          const Eigen::MatrixXd& values) {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(count, values.cols());
  for (std::size_t i = 0; i < cell.size(); ++i)
    if (cell[i] >= 0) sums.row(cell[i]) += values.row(static_cast<Eigen::Index>(i));
  return sums;
}

/// |Z'r|^2 averaged over the partitions of a component, of each column of r.
Eigen::RowVectorXd squares_of(const ErrorCells& c, const Eigen::MatrixXd& r) {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(r.cols());
  for (std::size_t k = 0; k < c.partitions.size(); ++k)
    sum += cell_sums(c.partitions[k], c.counts[k], r).colwise().squaredNorm();
  return sum / static_cast<double>(c.partitions.size());
}

/// White noise of one kind of observation is the component whose cells are the observations.
struct Component {
  const ErrorCells* cells = nullptr;  ///< null: white
  bool bearings = false;
};

class Estimator {
 public:
  Estimator(const ErrorSample& sample, int threads)
      : sample_(sample), cells_(error_cells(sample)), threads_(threads) {
    for (const bool bearings : {false, true})
      if (count(bearings) > 0) components_.push_back({nullptr, bearings});
    whites_ = components_.size();
    for (const ErrorCells& c : cells_)
      if (count(c.part.bearings) >= kFewestObservations) components_.push_back({&c, c.part.bearings});
  }

  /// Whether some sum of residuals is beyond what white noise leaves.
  [[nodiscard]] bool beyond_white() {
    const std::size_t tests = components_.size() - whites_;
    if (tests == 0) return false;
    Eigen::VectorXd white_noise = Eigen::VectorXd::Zero(size());
    white_noise.head(static_cast<Eigen::Index>(whites_)).setOnes();
    const Eigen::MatrixXd drawn = statistics_of(residuals_drawn(white_noise, kDraws, 0, true));
    const Eigen::VectorXd found = statistics_of(sample_.residual);
    for (Eigen::Index m = static_cast<Eigen::Index>(whites_); m < size(); ++m) {
      // A sum of squares is about a gamma variable of its simulated mean and variance; as chi-square: x /
      // scale on nu degrees.
      const double mean = drawn.row(m).mean(), variance = (drawn.row(m).array() - mean).square().mean();
      const bool bearings = components_[static_cast<std::size_t>(m)].bearings;
      if (!(variance > 0) || mean < kLeastShare * static_cast<double>(count(bearings)))
        continue;  // absorbed by the parameters
      const Eigen::Index white = white_of(bearings);
      const double level = found[white] / drawn.row(white).mean();  // the noise as it is
      const double nu = 2 * mean * mean / variance;
      if (found[m] > level * mean && chi_square_p(nu * found[m] / (level * mean), nu) <
                                         kWhitenessSignificance / static_cast<double>(tests))
        return true;
    }
    return false;
  }

  /// Variances of the components; of white noise first.
  void fit() {
    expect();
    // What priors, poses and odometry leave in the residuals is taken at its word.
    const Eigen::VectorXd word =
        statistics_of(residuals_drawn(Eigen::VectorXd::Zero(size()), kModelDraws, 1, true)).rowwise().mean();
    const Eigen::VectorXd found = statistics_of(sample_.residual) - word;
    theta_ = Eigen::VectorXd::Zero(size());
    for (std::size_t w = 0; w < whites_; ++w) {
      const auto i = static_cast<Eigen::Index>(w);
      theta_[i] = std::max(0.1, found[i] / expected_(i, i));
    }
    Eigen::MatrixXd weighted, drawn;
    for (int round = 0; round < kReweightings; ++round) {
      drawn = statistics_of(residuals_drawn(theta_, kModelDraws, 2 + static_cast<std::uint64_t>(round), true))
                  .colwise() -
              word;
      const Eigen::MatrixXd W = weights_of(drawn);
      weighted = W * expected_;
      theta_ = non_negative_least_squares(weighted, W * found);
      drawn = W * drawn;
    }
    scatter_.resize(size(), drawn.cols());
    for_each_parallel(static_cast<std::size_t>(drawn.cols()), threads_, [&](std::size_t k) {
      const auto i = static_cast<Eigen::Index>(k);
      scatter_.col(i) = non_negative_least_squares(weighted, drawn.col(i));
    });
  }

  [[nodiscard]] ErrorModel model() const {
    ErrorModel out;
    out.correlated = true;
    for (std::size_t w = 0; w < whites_; ++w)
      (components_[w].bearings ? out.white_bearing : out.white_tof) = theta_[static_cast<Eigen::Index>(w)];
    for (std::size_t m = whites_; m < components_.size(); ++m)
      if (const double variance = theta_[static_cast<Eigen::Index>(m)]; variance > 0) {
        out.parts.push_back(components_[m].cells->part);
        out.parts.back().variance = variance;
      }
    out.covariance = covariance(out.freedoms);
    return out;
  }

 private:
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(components_.size()); }
  static ErrorSample::Kind kind_of(bool bearings) {
    return bearings ? ErrorSample::Kind::kBearing : ErrorSample::Kind::kArrival;
  }
  [[nodiscard]] std::size_t count(bool bearings) const {
    return static_cast<std::size_t>(
        std::count_if(sample_.rows.begin(), sample_.rows.end(),
                      [&](const ErrorSample::Row& r) { return r.kind == kind_of(bearings); }));
  }
  [[nodiscard]] Eigen::Index white_of(bool bearings) const { return whites_ > 1 && bearings ? 1 : 0; }
  /// Adds draws of one component of unit variance times sigma.
  void add_draws(const Component& component, double sigma, std::uint64_t stream,
                 Eigen::MatrixXd& errors) const {
    Random random(kSeed, stream);
    if (component.cells == nullptr) {
      add_white(kind_of(component.bearings), sigma, random, errors);
      return;
    }
    const ErrorCells& c = *component.cells;
    std::vector<double> value;
    for (Eigen::Index k = 0; k < errors.cols(); ++k) {
      const std::size_t partition = static_cast<std::size_t>(k) % c.partitions.size();
      value.resize(static_cast<std::size_t>(c.counts[partition]));
      for (double& v : value) v = sigma * random.normal();
      const std::vector<std::int32_t>& cell = c.partitions[partition];
      for (std::size_t i = 0; i < cell.size(); ++i)
        if (cell[i] >= 0) errors(static_cast<Eigen::Index>(i), k) += value[static_cast<std::size_t>(cell[i])];
    }
  }

  void add_white(ErrorSample::Kind kind, double sigma, Random& random, Eigen::MatrixXd& errors) const {
    for (Eigen::Index k = 0; k < errors.cols(); ++k)
      for (std::size_t i = 0; i < sample_.rows.size(); ++i)
        if (sample_.rows[i].kind == kind) errors(static_cast<Eigen::Index>(i), k) += sigma * random.normal();
  }

  /// Residuals of simulated errors.
  /// @param stated  priors, poses and odometry err too, as stated
  [[nodiscard]] Eigen::MatrixXd residuals_drawn(const Eigen::VectorXd& theta, Eigen::Index draws,
                                                std::uint64_t stream, bool stated) const {
    Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(sample_.residual.size(), draws);
    Eigen::MatrixXd of_priors = Eigen::MatrixXd::Zero(sample_.F.cols(), draws);
    for (Eigen::Index m = 0; m < size(); ++m)
      if (theta[m] > 0)
        add_draws(components_[static_cast<std::size_t>(m)], std::sqrt(theta[m]),
                  1000 * stream + static_cast<std::uint64_t>(m), errors);
    if (stated) {
      Random random(kSeed, 1000 * stream + 999);
      add_white(ErrorSample::Kind::kOther, 1.0, random, errors);
      Eigen::MatrixXd normal(sample_.prior_root.cols(), draws);
      for (Eigen::Index k = 0; k < draws; ++k)
        for (Eigen::Index i = 0; i < normal.rows(); ++i) normal(i, k) = random.normal();
      of_priors = sample_.prior_root * normal;
    }
    return sample_.residuals_of(errors, of_priors);
  }

  /// Sums of squares of all components, rows, of each column of residuals.
  [[nodiscard]] Eigen::MatrixXd statistics_of(const Eigen::MatrixXd& r) const {
    Eigen::MatrixXd q(size(), r.cols());
    for_each_parallel(components_.size(), threads_, [&](std::size_t m) {
      const Component& component = components_[m];
      if (component.cells != nullptr) {
        q.row(static_cast<Eigen::Index>(m)) = squares_of(*component.cells, r);
        return;
      }
      Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(r.cols());
      for (std::size_t i = 0; i < sample_.rows.size(); ++i)
        if (sample_.rows[i].kind == kind_of(component.bearings))
          sum += r.row(static_cast<Eigen::Index>(i)).cwiseAbs2();
      q.row(static_cast<Eigen::Index>(m)) = sum;
    });
    return q;
  }

  /// Mean sums of squares under each component of unit variance; components that residuals do not show are
  /// dropped.
  void expect() {
    constexpr Eigen::Index kMostDraws = 48, kFewestDraws = 9;
    const Eigen::Index draws = std::clamp<Eigen::Index>(
        300'000 / std::max<Eigen::Index>(sample_.residual.size(), 1), kFewestDraws, kMostDraws);
    std::vector<Component> told;
    std::vector<Eigen::VectorXd> columns;
    std::vector<Eigen::Index> kept;
    for (Eigen::Index m = 0; m < size(); ++m) {
      const Component& component = components_[static_cast<std::size_t>(m)];
      const Eigen::MatrixXd residuals = residuals_drawn(Eigen::VectorXd::Unit(size(), m), draws, 10, false);
      const double put_in = static_cast<double>(count(component.bearings)) * static_cast<double>(draws);
      if (component.cells != nullptr && residuals.squaredNorm() < kLeastShare * put_in)
        continue;  // absorbed by the parameters
      kept.push_back(m);
      columns.push_back(statistics_of(residuals).rowwise().mean());
      told.push_back(component);
    }
    expected_.resize(static_cast<Eigen::Index>(kept.size()), static_cast<Eigen::Index>(kept.size()));
    for (std::size_t j = 0; j < kept.size(); ++j)
      for (std::size_t i = 0; i < kept.size(); ++i)
        expected_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = columns[j][kept[i]];
    components_ = std::move(told);
  }

  /// W with W'W the inverse of the covariance of the sums.
  [[nodiscard]] static Eigen::MatrixXd weights_of(const Eigen::MatrixXd& drawn) {
    const Eigen::MatrixXd centred = drawn.colwise() - drawn.rowwise().mean();
    const Eigen::MatrixXd V = centred * centred.transpose() / static_cast<double>(drawn.cols() - 1);
    const Eigen::VectorXd inverse = V.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd R = inverse.asDiagonal() * V * inverse.asDiagonal();
    R.diagonal().array() += kRidge;
    Eigen::MatrixXd W = inverse.asDiagonal();
    Eigen::LLT<Eigen::MatrixXd>(R).matrixL().solveInPlace(W);
    return W;
  }

  /// The sandwich, and each parameter's growth by what is not known of the variances.
  [[nodiscard]] Eigen::MatrixXd covariance(double& freedoms) const {
    const Eigen::Index rank = sample_.F.cols(), p = sample_.L.rows();
    const double per_sample = 1.0 / std::max(sample_.share, 1e-9);
    Eigen::MatrixXd S = Eigen::MatrixXd::Identity(rank, rank);
    Eigen::MatrixXd told =
        Eigen::MatrixXd::Zero(p, size());  // what a unit of each variance adds to those of the parameters
    for (Eigen::Index m = 0; m < size(); ++m) {
      const Component& component = components_[static_cast<std::size_t>(m)];
      Eigen::MatrixXd part = Eigen::MatrixXd::Zero(rank, rank);
      if (component.cells == nullptr) {
        for (std::size_t i = 0; i < sample_.rows.size(); ++i)
          if (sample_.rows[i].kind == kind_of(component.bearings))
            part.selfadjointView<Eigen::Lower>().rankUpdate(
                sample_.F.row(static_cast<Eigen::Index>(i)).transpose());
        part = Eigen::MatrixXd(part.selfadjointView<Eigen::Lower>());
      } else {
        const ErrorCells& c = *component.cells;
        for (std::size_t k = 0; k < c.partitions.size(); ++k) {
          const Eigen::MatrixXd sums = cell_sums(c.partitions[k], c.counts[k], sample_.F);
          part.noalias() += sums.transpose() * sums / static_cast<double>(c.partitions.size());
        }
      }
      part *= per_sample;
      told.col(m) = (sample_.L * part).cwiseProduct(sample_.L).rowwise().sum();
      S += (component.cells == nullptr ? theta_[m] - 1.0 : theta_[m]) * part;
    }
    Eigen::MatrixXd C = sample_.L * S * sample_.L.transpose();
    const Eigen::VectorXd held =
        sample_.L.rowwise().squaredNorm() - told.leftCols(static_cast<Eigen::Index>(whites_)).rowwise().sum();
    Eigen::VectorXd growth = Eigen::VectorXd::Ones(p);
    std::vector<double> behind;
    for (Eigen::Index i = 0; i < p; ++i) {
      const Eigen::RowVectorXd variances = (told.row(i) * scatter_).array() + std::max(0.0, held[i]);
      const double mean = variances.mean(), spread = (variances.array() - mean).square().mean();
      if (!(mean > 0) || !(spread > 0)) continue;
      const double nu = std::max(kFewestFreedoms, 2 * mean * mean / spread);
      growth[i] = std::sqrt(nu / (nu - 2));
      behind.push_back(nu);
    }
    if (!behind.empty()) freedoms = median(std::move(behind));
    C = (growth.asDiagonal() * C * growth.asDiagonal()).eval();
    return 0.5 * (C + C.transpose());
  }

  const ErrorSample& sample_;
  std::vector<ErrorCells> cells_;
  int threads_;
  std::vector<Component> components_;
  std::size_t whites_ = 0;
  Eigen::MatrixXd expected_;  ///< sums x components
  Eigen::VectorXd theta_;
  Eigen::MatrixXd scatter_;  ///< theta of draws of the model
};

}  // namespace

Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::Index n = A.cols();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<bool> passive(static_cast<std::size_t>(n), false);
  const Eigen::MatrixXd G = A.transpose() * A;
  const Eigen::VectorXd h = A.transpose() * b;
  const double tolerance = 1e-10 * std::max(1e-300, h.cwiseAbs().maxCoeff());
  for (Eigen::Index round = 0; round < 3 * n + 10; ++round) {
    const Eigen::VectorXd w = h - G * x;
    Eigen::Index best = -1;
    for (Eigen::Index i = 0; i < n; ++i)
      if (!passive[static_cast<std::size_t>(i)] && w[i] > tolerance && (best < 0 || w[i] > w[best])) best = i;
    if (best < 0) break;
    passive[static_cast<std::size_t>(best)] = true;
    while (true) {
      std::vector<Eigen::Index> in;
      for (Eigen::Index i = 0; i < n; ++i)
        if (passive[static_cast<std::size_t>(i)]) in.push_back(i);
      if (in.empty()) break;
      Eigen::MatrixXd columns(A.rows(), static_cast<Eigen::Index>(in.size()));
      for (std::size_t k = 0; k < in.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = A.col(in[k]);
      const Eigen::VectorXd z = columns.colPivHouseholderQr().solve(b);
      double step = 1.0;
      for (std::size_t k = 0; k < in.size(); ++k)
        if (const double to = z[static_cast<Eigen::Index>(k)]; to <= 0)
          step = std::min(step, x[in[k]] / std::max(x[in[k]] - to, 1e-300));
      for (std::size_t k = 0; k < in.size(); ++k)
        x[in[k]] += step * (z[static_cast<Eigen::Index>(k)] - x[in[k]]);
      if (step >= 1.0) break;
      for (const Eigen::Index i : in)
        if (x[i] <= 1e-14 * std::max(1e-300, x.maxCoeff())) {
          x[i] = 0.0;
          passive[static_cast<std::size_t>(i)] = false;
        }
    }
  }
  return x;
}

double ErrorModel::correlated_sigma() const {
  double variance = 0.0;
  for (const ErrorPart& p : parts)
    if (!p.bearings && p.axis != ErrorAxis::kConstant) variance += p.variance;
  return std::sqrt(variance);
}

double ErrorModel::correlation_time_s(double speed_mps, double typical_range_m) const {
  double sum = 0.0, weighted = 0.0;
  for (const ErrorPart& p : parts) {
    if (p.bearings || p.axis == ErrorAxis::kConstant) continue;
    const bool angle = p.axis == ErrorAxis::kDirection || p.axis == ErrorAxis::kAspect;
    const double length_m = angle ? p.extent * typical_range_m : p.extent;
    const double time_s = p.axis == ErrorAxis::kTime ? p.extent : length_m / std::max(speed_mps, 1e-3);
    sum += p.variance;
    weighted += p.variance * time_s;
  }
  return sum > 0 ? weighted / sum : 0.0;
}

double ErrorModel::pair_sigma() const {
  double variance = 0.0;
  for (const ErrorPart& p : parts)
    if (!p.bearings && p.axis == ErrorAxis::kConstant) variance += p.variance;
  return std::sqrt(variance);
}

ErrorModel error_model_of(const ParameterLayout& layout, const std::vector<Trajectory>& trajectories,
                          const SharedState& state, const Covariance& C, double share_of_log, int threads) {
  if (C.matrix() == nullptr || C.size() == 0 || !C.all_finite()) return {};
  ErrorSample sample = error_sample(layout, trajectories, state, C, kTestedRows);
  if (sample.rows.size() < kFewestObservations || !Estimator(sample, threads).beyond_white()) return {};
  if (sample.share < 1.0) sample = error_sample(layout, trajectories, state, C, kMostRows);
  sample.share *= share_of_log;
  Estimator estimator(sample, threads);
  estimator.fit();
  return estimator.model();
}

}  // namespace octant::calib
