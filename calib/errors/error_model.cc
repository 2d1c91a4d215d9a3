// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_model.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "calib/errors/error_components.h"
#include "calib/errors/error_draws.h"
#include "calib/errors/error_sample.h"
#include "calib/errors/non_negative.h"
#include "calib/errors/statistics.h"
#include "calib/problem/ranges.h"
#include "models/support/parallel.h"
#include "models/support/unit_diagonal.h"

namespace octant::calib {
namespace {

constexpr std::size_t kTestedRows = 3'000;  ///< sample of a long log of stops for the test of whiteness
/// Probability, for all sums together, from which residuals pass as white, and below which they do not. Real
/// errors are hardly ever white, and a short log shows this only weakly. Ignored correlation makes sigmas
/// several times too small, and correlation estimated from few residuals makes them several times too large.
/// Between the two limits the covariance changes gradually.
constexpr double kPassAsWhite = 1e-2, kFailAsWhite = 1e-4;
constexpr std::size_t kTestPanels = 3;   ///< sixteen draws each, of white noise in the test
constexpr std::size_t kModelPanels = 6;  ///< draws of the fitted errors
constexpr double kRidge =
    0.05;  ///< regularisation of the correlation of the sums, estimated from some hundred draws
constexpr double kLeastShare = 0.02;  ///< share of a component that residuals must show
constexpr double kFewestFreedoms = 3.0;

using Lines = std::vector<DrawLine>;

/// Result of simulated errors for each draw: sums of squares of all components, rows; squares of all
/// residuals.
struct DrawnSums {
  Eigen::MatrixXd sums;
  Eigen::RowVectorXd squares;
};

class Estimator {
 public:
  Estimator(const ErrorSample& sample, int threads)
      : sample_(sample), draws_(sample), components_(sample), threads_(threads) {}

  /// Weight of the errors beyond white noise: 0 if residuals pass as white, 1 if they do not.
  [[nodiscard]] double weight() {
    const Eigen::Index tests = components_.size() - components_.whites();
    if (tests == 0) return 0.0;
    tested_ = simulated(kTestPanels, [&](std::size_t panel, Lines& errors) {
                return white_noise(panel, errors, true);
              }).sums;
    const Eigen::VectorXd found = sums_of_residuals();
    double chance = 1.0;
    for (Eigen::Index m = components_.whites(); m < size() && chance > kFailAsWhite; ++m)
      chance = std::min(chance, static_cast<double>(tests) * chance_of(m, found));  // Bonferroni
    return std::clamp(std::log(chance / kPassAsWhite) / std::log(kFailAsWhite / kPassAsWhite), 0.0, 1.0);
  }

  /// Variances of the components, white noise first; after weight().
  void fit() {
    expect();
    // Priors, poses and odometry contribute to the residuals with their given sigmas.
    const Eigen::VectorXd word =
        simulated(kTestPanels,
                  [&](std::size_t panel, Lines& errors) { return white_noise(panel, errors, false); })
            .sums.rowwise()
            .mean();
    const Eigen::VectorXd found = sums_of_residuals() - word;
    Eigen::MatrixXd drawn = tested_, weighted;  // at first as white errors scatter the sums
    for (const bool fitted : {false, true}) {
      if (fitted)
        drawn = simulated(kModelPanels, [&](std::size_t panel, Lines& errors) {
                  return fitted_errors(panel, errors);
                }).sums;
      drawn.colwise() -= word;
      const Eigen::MatrixXd W = weights_of(drawn);
      weighted = W * expected_;
      theta_ = non_negative_least_squares(weighted, W * found);
      drawn = (W * drawn).eval();
    }
    scatter_.resize(size(), drawn.cols());
    for_each_parallel(static_cast<std::size_t>(drawn.cols()), threads_, [&](std::size_t k) {
      const auto i = static_cast<Eigen::Index>(k);
      scatter_.col(i) = non_negative_least_squares(weighted, drawn.col(i));
    });
  }

  /// @param weight  of it, compared with the assumed white noise
  [[nodiscard]] ErrorModel model(double weight) const {
    ErrorModel out;
    out.correlated = true;
    for (Eigen::Index m = 0; m < size(); ++m) {
      const ErrorComponent& c = components_[m];
      if (c.is_white()) {
        (c.bearings ? out.white_bearing : out.white_tof) = 1.0 + weight * (theta_[m] - 1.0);
      } else if (theta_[m] > 0) {
        out.parts.push_back(c.part);
        out.parts.back().variance = weight * theta_[m];
      }
    }
    out.covariance = (1 - weight) * sample_.L * sample_.L.transpose() + weight * covariance(out.freedoms);
    if (sample_.pattern.size() > 0) out.pattern_variance = 1.0 - weight + weight * pattern_variance();
    return out;
  }

 private:
  [[nodiscard]] Eigen::Index size() const { return components_.size(); }

  /// Probability that white noise leaves such a large sum of squares, which is approximately a gamma variable
  /// with its simulated mean and variance; as chi-square: x / scale with nu degrees of freedom.
  [[nodiscard]] double chance_of(Eigen::Index m, const Eigen::VectorXd& found) const {
    const double mean = tested_.row(m).mean(), variance = (tested_.row(m).array() - mean).square().mean();
    const bool bearings = components_[m].bearings;
    if (!(variance > 0) || mean < kLeastShare * static_cast<double>(components_.count(bearings)))
      return 1.0;  // absorbed by the parameters
    const Eigen::Index white = components_.white_of(bearings);
    const double level = found[white] / tested_.row(white).mean();  // actual level of the noise
    const double nu = 2 * mean * mean / variance;
    return found[m] > level * mean ? chi_square_p(nu * found[m] / (level * mean), nu) : 1.0;
  }

  /// Draws of errors with the given sigmas.
  /// @param all  false: only priors, poses and odometry, with the same draws
  Lines white_noise(std::size_t panel, Lines& errors, bool all) const {
    DrawBits random(1000 + panel);
    for (DrawLine& line : errors) random.normal(line);
    for (const bool bearings : {false, true})
      if (!all)
        for (const std::uint32_t row : components_.rows_of(bearings)) errors[row] = {};
    return draws_.of_priors(2000 + panel);
  }

  /// Draws with the estimated variances, and with the given sigmas for everything else.
  Lines fitted_errors(std::size_t panel, Lines& errors) const {
    DrawBits random(3000 + panel);
    for (std::size_t i = 0; i < errors.size(); ++i)
      if (sample_.rows[i].kind == ErrorSample::Kind::kOther) random.normal(errors[i]);
    for (Eigen::Index m = 0; m < size(); ++m)
      if (theta_[m] > 0)
        components_.add_normal(m, std::sqrt(theta_[m]), panel + static_cast<std::size_t>(m), random, errors);
    return draws_.of_priors(4000 + panel);
  }

  /// Scratch memory of a thread, panel after panel.
  struct Scratch {
    Lines lines;
    ErrorDraws::Scratch adjusting;
    ErrorComponents::Scratch summing;
  };
  /// Calls work(panel, scratch) for each panel.
  template <class Work>
  void for_each_panel(std::size_t panels, Work&& work) const {
    const std::size_t workers = std::min(panels, static_cast<std::size_t>(std::max(threads_, 1)));
    for_each_parallel(workers, threads_, [&](std::size_t first) {
      Scratch scratch;
      for (std::size_t panel = first; panel < panels; panel += workers) work(panel, scratch);
    });
  }

  /// Residuals of simulated errors, panel by panel; a panel fits into the cache of a processor.
  /// @param fill  (panel, errors): errors of the observations, which are 0; returns those of priors
  template <class Fill>
  [[nodiscard]] DrawnSums simulated(std::size_t panels, Fill&& fill) const {
    constexpr auto kWidth = static_cast<Eigen::Index>(kDrawsAbreast);
    const Eigen::Index draws = static_cast<Eigen::Index>(panels) * kWidth;
    DrawnSums out{Eigen::MatrixXd(size(), draws), Eigen::RowVectorXd::Zero(draws)};
    for_each_panel(panels, [&](std::size_t panel, Scratch& scratch) {
      const Eigen::Index first = static_cast<Eigen::Index>(panel) * kWidth;
      Lines& errors = scratch.lines;
      errors.assign(sample_.rows.size(), {});
      const Lines of_priors = fill(panel, errors);
      draws_.adjust(errors, of_priors, scratch.adjusting);
      add_squares(errors.data(), errors.size(), out.squares.data() + first);
      out.sums.middleCols(first, kWidth) = components_.sums_of(errors, scratch.summing);
    });
    return out;
  }

  /// One value for each row as the first of the draws.
  static Lines in_lines(const Eigen::VectorXd& values) {
    Lines lines(static_cast<std::size_t>(values.size()));
    for (std::size_t i = 0; i < lines.size(); ++i)
      lines[i].of[0] = static_cast<float>(values[static_cast<Eigen::Index>(i)]);
    return lines;
  }

  [[nodiscard]] Eigen::VectorXd sums_of_residuals() const {
    Scratch scratch;
    return components_.sums_of(in_lines(sample_.residual), scratch.summing).col(0);
  }

  /// With b = M p of a pattern p, its size b'r / b'b has the variance sum_l theta_l |Z_l'b|^2 / (b'b)^2.
  [[nodiscard]] double pattern_variance() const {
    Scratch scratch;
    Lines pattern = in_lines(sample_.pattern);
    draws_.adjust(pattern, {}, scratch.adjusting);
    Eigen::RowVectorXd squares = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(kDrawsAbreast));
    add_squares(pattern.data(), pattern.size(), squares.data());
    if (!(squares[0] > 0)) return 1.0;
    const Eigen::RowVectorXd influence =
        components_.sums_of(pattern, scratch.summing).col(0).transpose() / squares[0];
    const double held = std::max(0.0, 1.0 - influence.head(components_.whites()).sum()),
                 variance = held + influence.dot(theta_), nu = freedoms_of(influence, held);
    return std::isfinite(nu) ? variance * nu / (nu - 2) : variance;
  }

  /// Mean sums of squares under each component of unit variance; components that residuals do not show are
  /// dropped. Draws of coarse cells scatter less than those of fine ones, so that of tr(Z_m'M Z_l Z_l'M Z_m)
  /// and the same by draws of the other the former counts for more.
  void expect() {
    constexpr std::size_t kDrawnNumbers = 150'000, kFewestDraws = 9,
                          kMostDraws = 24;  // multiples of three partitions
    const std::size_t draws =
                          std::clamp(kDrawnNumbers / sample_.rows.size() / 3 * 3, kFewestDraws, kMostDraws),
                      all = draws * static_cast<std::size_t>(size());
    const DrawnSums drawn = simulated((all + kDrawsAbreast - 1) / kDrawsAbreast, [&](std::size_t panel,
                                                                                     Lines& errors) {
      DrawBits random(5000 + panel);
      for (std::size_t k = 0, column = panel * kDrawsAbreast; k < kDrawsAbreast && column < all;
           ++k, ++column)
        components_.set_signs(static_cast<Eigen::Index>(column / draws), column % draws, k, random, errors);
      return Lines();
    });
    const auto width = static_cast<Eigen::Index>(draws);
    std::vector<Eigen::Index> kept;
    Eigen::VectorXd cells(size());
    Eigen::MatrixXd mean(size(), size());
    for (Eigen::Index m = 0; m < size(); ++m) {
      mean.col(m) = drawn.sums.middleCols(m * width, width).rowwise().mean();
      cells[m] = static_cast<double>(components_.cells_of(m));
      const double left = drawn.squares.segment(m * width, width).mean() /
                          static_cast<double>(components_.count(components_[m].bearings));
      // Otherwise parameters absorb it
      if (components_[m].is_white() || left >= kLeastShare) kept.push_back(m);
    }
    const Eigen::ArrayXXd finer =
        (cells.cwiseInverse() * cells.transpose()).array().square();  // column to row
    const Eigen::MatrixXd both = (mean.array() + finer * mean.transpose().array()) / (1.0 + finer);
    expected_ = both(kept, kept);
    tested_ = tested_(kept, Eigen::all).eval();
    components_.keep(kept);
  }

  /// W with W'W the inverse of the covariance of the sums.
  [[nodiscard]] static Eigen::MatrixXd weights_of(const Eigen::MatrixXd& drawn) {
    const Eigen::MatrixXd centred = drawn.colwise() - drawn.rowwise().mean();
    const Eigen::MatrixXd V = centred * centred.transpose() / static_cast<double>(drawn.cols() - 1);
    UnitDiagonal<Eigen::MatrixXd> unit(V);
    unit.scaled.diagonal().array() += kRidge;
    Eigen::MatrixXd W = unit.inverse_scale.asDiagonal();
    Eigen::LLT<Eigen::MatrixXd>(unit.scaled).matrixL().solveInPlace(W);
    return W;
  }

  /// Contribution of a unit of each component's variance to those of the parameters: |Z'F L'|^2.
  [[nodiscard]] Eigen::MatrixXd influence_on_parameters() const {
    constexpr auto kWidth = static_cast<Eigen::Index>(kDrawsAbreast);
    const Eigen::Index p = sample_.L.rows();
    Eigen::MatrixXd influence(p, size());
    for_each_panel(static_cast<std::size_t>((p + kWidth - 1) / kWidth),
                   [&](std::size_t panel, Scratch& scratch) {
                     const Eigen::Index first = static_cast<Eigen::Index>(panel) * kWidth,
                                        width = std::min(kWidth, p - first);
                     draws_.influence_times(sample_.L.middleRows(first, width).transpose(), scratch.lines);
                     influence.middleRows(first, width) =
                         components_.sums_of(scratch.lines, scratch.summing).leftCols(width).transpose();
                   });
    return influence;
  }

  /// Degrees of freedom of a variance, by its scatter.
  /// @param influence  contribution of a unit of each component's variance  @param held  of all other errors
  [[nodiscard]] double freedoms_of(const Eigen::RowVectorXd& influence, double held) const {
    const Eigen::RowVectorXd variances = (influence * scatter_).array() + std::max(0.0, held);
    const double mean = variances.mean(), spread = (variances.array() - mean).square().mean();
    if (!(mean > 0) || !(spread > 0)) return INFINITY;
    return std::max(kFewestFreedoms, 2 * mean * mean / spread);
  }

  /// The sandwich, with the growth of each parameter's variance due to the uncertainty of theta.
  [[nodiscard]] Eigen::MatrixXd covariance(double& freedoms) const {
    const Eigen::Index rank = sample_.F.cols(), p = sample_.L.rows();
    const double per_sample = 1.0 / std::max(sample_.share, 1e-9);
    std::vector<Eigen::MatrixXd> parts(static_cast<std::size_t>(size()));
    for_each_parallel(parts.size(), threads_, [&](std::size_t k) {
      const auto m = static_cast<Eigen::Index>(k);
      const double more = components_[m].is_white() ? theta_[m] - 1.0 : theta_[m];
      if (more != 0.0) parts[k] = more * components_.squares_of_influence(m, draws_);
    });
    Eigen::MatrixXd S = Eigen::MatrixXd::Identity(rank, rank);
    for (const Eigen::MatrixXd& part : parts)
      if (part.size() > 0) S += per_sample * part;
    Eigen::MatrixXd C = sample_.L * S * sample_.L.transpose();
    const Eigen::MatrixXd influence = per_sample * influence_on_parameters();
    const Eigen::VectorXd held =
        sample_.L.rowwise().squaredNorm() - influence.leftCols(components_.whites()).rowwise().sum();
    Eigen::VectorXd growth = Eigen::VectorXd::Ones(p);
    std::vector<double> behind;
    for (Eigen::Index i = 0; i < p; ++i) {
      const double nu = freedoms_of(influence.row(i), held[i]);
      if (!std::isfinite(nu)) continue;
      growth[i] = std::sqrt(nu / (nu - 2));
      behind.push_back(nu);
    }
    if (!behind.empty()) freedoms = median(std::move(behind));
    C = (growth.asDiagonal() * C * growth.asDiagonal()).eval();
    return 0.5 * (C + C.transpose());
  }

  const ErrorSample& sample_;
  ErrorDraws draws_;
  ErrorComponents components_;
  int threads_;
  Eigen::MatrixXd tested_;    ///< sums x draws of white noise
  Eigen::MatrixXd expected_;  ///< sums x components
  Eigen::VectorXd theta_;
  Eigen::MatrixXd scatter_;  ///< theta of draws of the model
};

}  // namespace

double ErrorModel::sigma_of(bool constant) const {
  double variance = 0.0;
  for (const ErrorPart& p : parts)
    if (!p.bearings && (p.axis == ErrorAxis::kConstant) == constant) variance += p.variance;
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

ErrorModel error_model_of(const ErrorSample& sample, int threads) {
  if (sample.rows.size() < kFewestObservations) return {};
  Estimator estimator(sample, threads);
  const double weight = estimator.weight();
  if (weight == 0.0) return {};
  estimator.fit();
  return estimator.model(weight);
}

ErrorModel error_model_of(const ParameterLayout& layout, const std::vector<Trajectory>& trajectories,
                          const SharedState& state, const Covariance& C, double share_of_log, int threads) {
  if (C.matrix() == nullptr || C.size() == 0 || !C.all_finite()) return {};
  ErrorSample sample = error_sample(layout, trajectories, state, C, kTestedRows);
  if (sample.share < 1.0) {
    if (sample.rows.size() < kFewestObservations || Estimator(sample, threads).weight() == 0.0) return {};
    sample = error_sample(layout, trajectories, state, C, kMostRows);
  }
  sample.share *= share_of_log;
  return error_model_of(sample, threads);
}

}  // namespace octant::calib
