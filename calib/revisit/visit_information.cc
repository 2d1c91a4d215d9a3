// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/visit_information.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "calib/adjust/information.h"
#include "calib/errors/error_draws.h"
#include "calib/errors/error_model.h"
#include "calib/errors/error_sample.h"
#include "calib/revisit/revisited_site.h"
#include "models/support/decompositions.h"

namespace octant::calib {
namespace {

constexpr std::size_t kSampledRows = 40'000;
/// Range of the logarithm of the variance ratio over which both models are mixed
constexpr double kAboutAsLarge = 0.5;
constexpr double kUnobservableShare = 1e-9;  ///< share of the larger of prior and visit
constexpr double kVisitRidge = 1e-13;        ///< ridge on information scaled to a unit diagonal

/// Errors of a pair: correlated as exp(-t / time_s), and constant; variances as shares of the whole.
struct StatedErrors {
  double white = 1.0, correlated = 0.0, pair = 0.0, time_s = 0.0;
};

StatedErrors stated_errors(const Deployment& d) {
  const CorrelatedNoise& c = d.correlated_noise;
  const double white = d.noise.tof_sigma_s * d.noise.tof_sigma_s, some = c.sigma_s * c.sigma_s,
               pair = c.pair_sigma_s * c.pair_sigma_s;
  const double all = white + some + pair;
  return {white / all, some / all, pair / all, c.time_s};
}

/// Covariance under errors of that kind: L (I + F' (Omega - I) F) L'.
Eigen::MatrixXd covariance_under(const StatedErrors& errors, const ErrorSample& sample) {
  std::map<std::tuple<std::size_t, int, int>, std::vector<std::size_t>> pairs;
  for (std::size_t i = 0; i < sample.rows.size(); ++i)
    if (const ErrorSample::Row& row = sample.rows[i]; row.kind == ErrorSample::Kind::kArrival)
      pairs[{row.run, row.beacon, row.receiver}].push_back(i);
  const Eigen::Index rank = sample.F.cols();
  // F' (Omega - I) F is G'F and its transpose. G is the correlated part of each row with the earlier rows of
  // its pair.
  std::vector<float> F, G;
  Eigen::RowVectorXf faded(rank), sum(rank), g(rank);
  const auto add = [&](const Eigen::RowVectorXf& row, const Eigen::RowVectorXf& with) {
    F.insert(F.end(), row.data(), row.data() + rank);
    G.insert(G.end(), with.data(), with.data() + rank);
  };
  for (auto& [pair, rows] : pairs) {
    std::ranges::sort(
        rows, [&](std::size_t a, std::size_t b) { return sample.rows[a].time_s < sample.rows[b].time_s; });
    faded.setZero();  // remaining errors of the earlier rows
    sum.setZero();
    double last_s = -INFINITY;
    for (const std::size_t i : rows) {
      const Eigen::RowVectorXf f = sample.F.row(static_cast<Eigen::Index>(i)).cast<float>();
      faded *= static_cast<float>(
          errors.time_s > 0 ? std::exp((last_s - sample.rows[i].time_s) / errors.time_s) : 0.0);
      last_s = sample.rows[i].time_s;
      g = static_cast<float>(0.5 * (errors.white - 1.0 + errors.correlated)) * f +
          static_cast<float>(errors.correlated) * faded;
      add(f, g);
      faded += f;
      sum += f;
    }
    g = static_cast<float>(0.5 * errors.pair) * sum;
    add(sum, g);
  }
  Eigen::MatrixXd S = product_of_rows(F, G, static_cast<std::size_t>(rank));
  S = (S + S.transpose()).eval() / std::max(sample.share, 1e-9);
  S.diagonal().array() += 1.0;
  return sample.L * S * sample.L.transpose();
}

/// Covariance of all parameters with correlated errors; empty if errors are white.
Eigen::MatrixXd correlated_covariance(const Fit& fit, const Eigen::MatrixXd& white, const Deployment& noise,
                                      int threads) {
  const SharedState state = fit.state();
  const Covariance C(white);
  if (!noise.correlated_noise.any()) {
    const ErrorModel shown = error_model_of(fit.layout, fit.trajectories, state, C, 1.0, threads);
    return shown.correlated ? shown.covariance : Eigen::MatrixXd();
  }
  const ErrorSample sample = error_sample(fit.layout, fit.trajectories, state, C, kSampledRows);
  const ErrorModel shown = error_model_of(sample, threads);
  const Eigen::MatrixXd stated = covariance_under(stated_errors(noise), sample);
  if (!shown.correlated) return stated;
  return between_error_models(white, stated, shown.covariance);
}

/// Columns of the free known parameters, and of all others.
struct KnownColumns {
  std::vector<int> known, of_known, others;
};

KnownColumns known_columns_of(const ParameterLayout& layout, const KnownParameters& known) {
  KnownColumns p;
  std::vector<bool> taken(static_cast<std::size_t>(layout.size()), false);
  const std::vector<int> columns = columns_of(layout, known);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (columns[k] < 0) continue;
    p.known.push_back(columns[k]);
    p.of_known.push_back(static_cast<int>(k));
    taken[static_cast<std::size_t>(columns[k])] = true;
  }
  for (int c = 0; c < layout.size(); ++c)
    if (!taken[static_cast<std::size_t>(c)]) p.others.push_back(c);
  return p;
}

/// Gradient of the separate priors of parameters.
Eigen::VectorXd own_prior_gradient(const Fit& fit, const std::vector<int>& columns) {
  Eigen::VectorXd gradient(static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Parameter& p = fit.layout.parameter(columns[k]);
    gradient[static_cast<Eigen::Index>(k)] =
        std::isfinite(p.prior_sigma) ? (fit.x[columns[k]] - p.prior_mean) / (p.prior_sigma * p.prior_sigma)
                                     : 0.0;
  }
  return gradient;
}

/// Replaces N by N M^-1 N and transforms the gradient, in coordinates in which the prior is the unit matrix.
void discount(const Eigen::MatrixXd& honest, Eigen::MatrixXd& N, Eigen::VectorXd& gradient) {
  const SymmetricEigen<Eigen::MatrixXd> eigen(N);
  const Eigen::VectorXd& l = eigen.eigenvalues();
  const Eigen::Index observable = (l.array() > kUnobservableShare * std::max(1.0, l.maxCoeff())).count();
  const Eigen::MatrixXd V = eigen.eigenvectors().rightCols(observable);
  const Eigen::VectorXd observed = l.tail(observable), sum = (observed.array() + 1.0).matrix();
  Eigen::MatrixXd M = sum.asDiagonal() * (V.transpose() * honest * V) * sum.asDiagonal();
  M.diagonal().array() -= 1.0;
  // Correlated errors carry no more information than white ones.
  const Eigen::VectorXd root = observed.cwiseSqrt(), per = root.cwiseInverse();
  const SymmetricEigen<Eigen::MatrixXd> ratio(per.asDiagonal() * (0.5 * (M + M.transpose())) *
                                              per.asDiagonal());
  const Eigen::VectorXd inverse = ratio.eigenvalues().cwiseMax(1.0).cwiseInverse();
  const Eigen::MatrixXd W = V * root.asDiagonal() * ratio.eigenvectors();
  const Eigen::VectorXd y =
      ratio.eigenvectors().transpose() * (per.asDiagonal() * (V.transpose() * gradient));
  N = W * inverse.asDiagonal() * W.transpose();
  gradient = W * inverse.cwiseProduct(y);
}

}  // namespace

Eigen::MatrixXd between_error_models(const Eigen::MatrixXd& white, const Eigen::MatrixXd& stated,
                                     const Eigen::MatrixXd& shown) {
  const Eigen::VectorXd scale = white.diagonal().cwiseInverse();
  const double larger = std::log(shown.diagonal().dot(scale) / stated.diagonal().dot(scale));
  const double share = std::clamp(0.5 + larger / kAboutAsLarge, 0.0, 1.0);
  return share * shown + (1.0 - share) * stated;
}

VisitInformation visit_information(Fit& fit, const KnownParameters& known, const Eigen::MatrixXd& P_si,
                                   const Deployment& noise, int threads, bool known_white) {
  const Information information =
      information_at(fit.problem, fit.layout, fit.trajectories, fit.x, {.threads = threads});
  const Eigen::MatrixXd all = information.data + information.prior;
  const KnownColumns p = known_columns_of(fit.layout, known);
  Eigen::MatrixXd N = information.data(p.known, p.known);
  Eigen::VectorXd pull = -information.data_gradient(p.known);  // N (theta_2 - x)
  if (!p.others.empty()) {
    const Eigen::MatrixXd across = all(p.others, p.known),
                          eliminated = across.transpose() *
                                       inverse_of_information(all(p.others, p.others), kVisitRidge);
    N -= eliminated * across;
    pull += eliminated * (information.data_gradient(p.others) + own_prior_gradient(fit, p.others));
  }
  // Unit prior: x = theta_1 + L u with P = L L'.
  const auto n = static_cast<Eigen::Index>(p.known.size());
  Eigen::VectorXd unit(n);
  for (Eigen::Index k = 0; k < n; ++k)
    unit[k] = fit.layout.parameter(p.known[static_cast<std::size_t>(k)]).si_per_unit;
  const Eigen::MatrixXd inverse_root =
      joint_prior({}, {}, P_si(p.of_known, p.of_known)).root;  // of P in SI: L^-1
  const Eigen::MatrixXd L = Eigen::PartialPivLU<Eigen::MatrixXd>(inverse_root).inverse();
  const Eigen::MatrixXd internal_L = unit.cwiseInverse().asDiagonal() * L;
  Eigen::MatrixXd N_unit = internal_L.transpose() * N * internal_L;
  N_unit = (0.5 * (N_unit + N_unit.transpose())).eval();
  const Eigen::VectorXd u = inverse_root * (unit.cwiseProduct(fit.x(p.known)) - known.value(p.of_known));
  Eigen::VectorXd gradient = internal_L.transpose() * pull + N_unit * u;
  VisitInformation out;
  const Eigen::MatrixXd honest =
      known_white ? Eigen::MatrixXd()
                  : correlated_covariance(fit, inverse_of_information(all, kVisitRidge), noise, threads);
  if (honest.size() > 0) {
    const Eigen::MatrixXd to_unit = inverse_root * unit.asDiagonal();
    discount(to_unit * honest(p.known, p.known) * to_unit.transpose(), N_unit, gradient);
    out.correlated = true;
  }
  out.N = Eigen::MatrixXd::Zero(known.size(), known.size());
  out.gradient = Eigen::VectorXd::Zero(known.size());
  out.N(p.of_known, p.of_known) = inverse_root.transpose() * N_unit * inverse_root;
  out.gradient(p.of_known) = inverse_root.transpose() * gradient;
  return out;
}

Updated updated_by(const Eigen::MatrixXd& P, const Eigen::MatrixXd& N, const Eigen::VectorXd& gradient) {
  // In coordinates in which the prior is the unit matrix: (I + L'N L)^-1 lies between 0 and 1.
  const Eigen::MatrixXd root = joint_prior({}, {}, P).root;
  const Eigen::MatrixXd L = Eigen::PartialPivLU<Eigen::MatrixXd>(root).inverse();
  Eigen::MatrixXd total = L.transpose() * N * L;
  total.diagonal().array() += 1.0;
  const Eigen::MatrixXd C = L * DenseLdlt(total).solve(L.transpose());
  return {C * gradient, 0.5 * (C + C.transpose())};
}

}  // namespace octant::calib
