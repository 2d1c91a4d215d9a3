// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_model.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "calib/errors/error_sample.h"
#include "calib/errors/non_negative.h"
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
constexpr Eigen::Index kDrawsAtOnce = 24;
constexpr int kReweightings = 2;
constexpr double kRidge = 0.05;       ///< of the correlation of the sums, which some hundred draws tell
constexpr double kLeastShare = 0.02;  ///< share of a component that residuals must show
constexpr double kFewestFreedoms = 3.0;
constexpr std::uint64_t kSeed = 20261122;

/// Cells of the observations that have a part in a component, one after the other, of one partition.
struct CellList {
  std::vector<std::int32_t> cell;
  std::int32_t count = 0;
};

/// Sums of values over the cells of a partition, a row for each.
/// @param values  of the observations of the list
void sum_cells(const CellList& list, const ByRow& values, ByRow& sums) {
  const Eigen::Index columns = values.cols();
  sums.setZero(list.count, columns);
  const double* from = values.data();
  for (const std::int32_t cell : list.cell) {
    double* to = sums.data() + cell * columns;
    for (Eigen::Index k = 0; k < columns; ++k) to[k] += from[k];
    from += columns;
  }
}

/// White noise of one kind of observation is the component whose cells are the observations.
struct Component {
  const ErrorPart* part = nullptr;  ///< null: white
  std::vector<CellList> partitions;
  bool bearings = false;
};

/// |Z'r|^2 of a component, averaged over its partitions, of each column of r. @param sums  room
Eigen::RowVectorXd squares_of(const Component& c, const ByRow& r, ByRow& sums) {
  if (c.part == nullptr) return r.cwiseAbs2().colwise().sum();
  Eigen::RowVectorXd squares = Eigen::RowVectorXd::Zero(r.cols());
  for (const CellList& list : c.partitions) {
    sum_cells(list, r, sums);
    squares += sums.cwiseAbs2().colwise().sum();
  }
  return squares / static_cast<double>(c.partitions.size());
}

/// What simulated errors leave: sums of squares of all components, rows, of each draw; squares of all
/// residuals.
struct Drawn {
  Eigen::MatrixXd sums;
  double squares = 0.0;
};

class Estimator {
 public:
  Estimator(const ErrorSample& sample, int threads)
      : sample_(sample), cells_(error_cells(sample)), threads_(threads) {
    for (std::size_t i = 0; i < sample.rows.size(); ++i)
      rows_of_[static_cast<std::size_t>(sample.rows[i].kind)].push_back(static_cast<Eigen::Index>(i));
    for (const bool bearings : {false, true})
      if (count(bearings) > 0) components_.push_back({nullptr, {}, bearings});
    whites_ = components_.size();
    for (const ErrorCells& c : cells_)
      if (count(c.part.bearings) >= kFewestObservations) components_.push_back(component_of(c));
  }

  /// Whether some sum of residuals is beyond what white noise leaves.
  [[nodiscard]] bool beyond_white() {
    const std::size_t tests = components_.size() - whites_;
    if (tests == 0) return false;
    Eigen::VectorXd white_noise = Eigen::VectorXd::Zero(size());
    white_noise.head(static_cast<Eigen::Index>(whites_)).setOnes();
    const Eigen::MatrixXd drawn = simulated(white_noise, kDraws, 0, true).sums;
    const Eigen::VectorXd found = sums_of(sample_.residual);
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
        simulated(Eigen::VectorXd::Zero(size()), kModelDraws, 1, true).sums.rowwise().mean();
    const Eigen::VectorXd found = sums_of(sample_.residual) - word;
    theta_ = Eigen::VectorXd::Zero(size());
    for (std::size_t w = 0; w < whites_; ++w) {
      const auto i = static_cast<Eigen::Index>(w);
      theta_[i] = std::max(0.1, found[i] / expected_(i, i));
    }
    Eigen::MatrixXd weighted, drawn;
    for (int round = 0; round < kReweightings; ++round) {
      drawn =
          simulated(theta_, kModelDraws, 2 + static_cast<std::uint64_t>(round), true).sums.colwise() - word;
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
        out.parts.push_back(*components_[m].part);
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
  [[nodiscard]] const std::vector<Eigen::Index>& rows_of(ErrorSample::Kind kind) const {
    return rows_of_[static_cast<std::size_t>(kind)];
  }
  [[nodiscard]] std::size_t count(bool bearings) const { return rows_of(kind_of(bearings)).size(); }
  [[nodiscard]] Component component_of(const ErrorCells& c) const {
    Component out{&c.part, {}, c.part.bearings};
    for (std::size_t k = 0; k < c.partitions.size(); ++k) {
      out.partitions.push_back({{}, c.counts[k]});
      for (const Eigen::Index i : rows_of(kind_of(out.bearings)))
        out.partitions.back().cell.push_back(c.partitions[k][static_cast<std::size_t>(i)]);
    }
    return out;
  }
  [[nodiscard]] Eigen::Index white_of(bool bearings) const { return whites_ > 1 && bearings ? 1 : 0; }
  /// Adds draws of one component of unit variance times sigma. @param errors  blocks of draws
  void add_draws(const Component& component, double sigma, std::uint64_t stream,
                 std::vector<ByRow>& errors) const {
    Random random(kSeed, stream);
    const ErrorSample::Kind kind = kind_of(component.bearings);
    if (component.part == nullptr) {
      add_white(kind, sigma, random, errors);
      return;
    }
    std::vector<double> value;
    std::size_t draw = 0;
    for (ByRow& block : errors)
      for (Eigen::Index k = 0; k < block.cols(); ++k, ++draw) {
        const CellList& list = component.partitions[draw % component.partitions.size()];
        value.resize(static_cast<std::size_t>(list.count));
        for (double& v : value) v = sigma * random.normal();
        std::size_t at = 0;
        for (const Eigen::Index i : rows_of(kind))
          block(i, k) += value[static_cast<std::size_t>(list.cell[at++])];
      }
  }

  void add_white(ErrorSample::Kind kind, double sigma, Random& random, std::vector<ByRow>& errors) const {
    for (ByRow& block : errors)
      for (Eigen::Index k = 0; k < block.cols(); ++k)
        for (const Eigen::Index i : rows_of(kind)) block(i, k) += sigma * random.normal();
  }

  /// Residuals of simulated errors, draws in blocks that a processor's cache holds.
  /// @param stated  priors, poses and odometry err too, as stated
  [[nodiscard]] Drawn simulated(const Eigen::VectorXd& theta, Eigen::Index draws, std::uint64_t stream,
                                bool stated) const {
    std::vector<ByRow> errors;
    for (Eigen::Index first = 0; first < draws; first += kDrawsAtOnce)
      errors.push_back(ByRow::Zero(sample_.residual.size(), std::min(kDrawsAtOnce, draws - first)));
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
    Drawn out{Eigen::MatrixXd(size(), draws), 0.0};
    Eigen::VectorXd squares(static_cast<Eigen::Index>(errors.size()));
    for_each_parallel(errors.size(), threads_, [&](std::size_t block) {
      const auto b = static_cast<Eigen::Index>(block);
      const Eigen::Index first = b * kDrawsAtOnce, width = errors[block].cols();
      const ByRow residuals = sample_.residuals_of(errors[block], of_priors.middleCols(first, width));
      errors[block].resize(0, 0);
      squares[b] = residuals.squaredNorm();
      out.sums.middleCols(first, width) = sums_of(residuals);
    });
    out.squares = squares.sum();
    return out;
  }

  /// Sums of squares of all components, rows, of each column of residuals.
  [[nodiscard]] Eigen::MatrixXd sums_of(const ByRow& r) const {
    Eigen::MatrixXd q(size(), r.cols());
    ByRow sums;
    for (const bool bearings : {false, true}) {
      const ByRow mine = r(rows_of(kind_of(bearings)), Eigen::all);
      for (std::size_t m = 0; m < components_.size(); ++m)
        if (components_[m].bearings == bearings)
          q.row(static_cast<Eigen::Index>(m)) = squares_of(components_[m], mine, sums);
    }
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
      const Drawn drawn = simulated(Eigen::VectorXd::Unit(size(), m), draws, 10, false);
      const double put_in = static_cast<double>(count(component.bearings)) * static_cast<double>(draws);
      if (component.part != nullptr && drawn.squares < kLeastShare * put_in)
        continue;  // absorbed by the parameters
      kept.push_back(m);
      columns.push_back(drawn.sums.rowwise().mean());
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
    const std::array<ByRow, 2> of_kind = {sample_.F(rows_of(ErrorSample::Kind::kArrival), Eigen::all),
                                          sample_.F(rows_of(ErrorSample::Kind::kBearing), Eigen::all)};
    ByRow sums;
    Eigen::MatrixXd told =
        Eigen::MatrixXd::Zero(p, size());  // what a unit of each variance adds to those of the parameters
    for (Eigen::Index m = 0; m < size(); ++m) {
      const Component& component = components_[static_cast<std::size_t>(m)];
      Eigen::MatrixXd part = Eigen::MatrixXd::Zero(rank, rank);
      const ByRow& mine = of_kind[component.bearings ? 1 : 0];
      const auto add_squares = [&part](const ByRow& rows, double weight) {
        part.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose(), weight);
      };
      if (component.part == nullptr) add_squares(mine, 1.0);
      for (const CellList& list : component.partitions) {
        sum_cells(list, mine, sums);
        add_squares(sums, 1.0 / static_cast<double>(component.partitions.size()));
      }
      part = Eigen::MatrixXd(part.selfadjointView<Eigen::Lower>());
      part *= per_sample;
      told.col(m) = (sample_.L * part).cwiseProduct(sample_.L).rowwise().sum();
      S += (component.part == nullptr ? theta_[m] - 1.0 : theta_[m]) * part;
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
  std::array<std::vector<Eigen::Index>, 3> rows_of_;  ///< by kind
  std::vector<Component> components_;
  std::size_t whites_ = 0;
  Eigen::MatrixXd expected_;  ///< sums x components
  Eigen::VectorXd theta_;
  Eigen::MatrixXd scatter_;  ///< theta of draws of the model
};

}  // namespace

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
