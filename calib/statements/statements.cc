// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/statements.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "calib/adjust/information.h"
#include "calib/adjust/priors.h"
#include "calib/problem/log_totals.h"
#include "calib/statements/error_fit.h"
#include "calib/statements/refit.h"
#include "calib/statements/statement.h"
#include "calib/statements/statement_words.h"
#include "models/changes/chi_square.h"

namespace octant::calib {
namespace {

/// Probability of a false contradiction at a site, over all tests.
constexpr double kFalseAlarms = 0.002;
/// Least significance of a contradiction. Models are not exact, so smaller deviations do not count for any
/// number of observations.
constexpr double kFewestSigmas = 5.0;
/// Share of the site's tolerance below which a deviation is irrelevant.
constexpr double kMatters = 0.2;
/// Limits for suspects, before any new adjustment: significance, and share of rejected arrivals of a control
/// point.
constexpr double kSuspectStatementSigmas = 4.0;
constexpr double kMostlyLeftOut = 0.3;
/// Half squares by which a common cause must explain more than the best single assumption, because it has
/// more parameters.
constexpr double kPlainlyBetter = 16.0;
/// Maximum number of parameters. The matrices are dense: about ten of 32 MB.
constexpr Eigen::Index kMostParameters = 2000;
constexpr std::size_t kMostSuspects = 8, kMostCulprits = 4;
/// Least significance of an error that many observations have in common; some dozens are tested.
constexpr double kErrorSigmas = 6.0;
/// Largest share of the cost that may remain if such an error is a contradiction.
constexpr double kLeavesLess = 0.5;
constexpr std::size_t kMostErrors = 4;
/// Difference of log-likelihoods below which errors are equally likely.
constexpr double kEquallyLikely = 5.0;

/// Difference between the site file and a fit.
struct Difference {
  Eigen::VectorXd v;  ///< value of the fit minus value of the site file, internal units
  Eigen::MatrixXd covariance;
  double length_m = 0.0;  ///< effect at the beacons or the robot
  /// Squared difference, normalised by its covariance.
  [[nodiscard]] double squares() const { return v.size() == 0 ? 0.0 : v.dot(covariance.ldlt().solve(v)); }
  /// Normal deviate with the chi-square probability of squares() (Wilson and Hilferty 1931, far in the tail).
  [[nodiscard]] double sigmas() const {
    const double n = static_cast<double>(v.size()), s = squares();
    if (!(s > 0) || !std::isfinite(s)) return 0.0;
    return n == 1 ? std::sqrt(s) : std::max(0.0, std::sqrt(s) - std::sqrt(n - 1));
  }
};

double chance(double squares, Eigen::Index degrees) {
  return squares > 0 && degrees > 0 ? chi_square_tail(squares, static_cast<int>(degrees)) : 1.0;
}

/// Returns true if the parameter has a prior.
bool has_prior(const Parameter& p) { return std::isfinite(p.prior_sigma); }

class StatementTest {
 public:
  StatementTest(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                const std::vector<Trajectory>& trajectories)
      : whole_(problem),
        options_(options),
        now_(fit_of(problem, options, estimate, trajectories)),
        stated_(problem, estimate.layout, now_.beacon_usable),
        all_(stated_.all()) {}

  StatementFindings run() {
    if (!now_.x.allFinite()) return {};
    errors_ = errors_of(options_, now_);
    StatementFindings found;
    found.as_stated = now_;
    std::vector<double> sigmas;
    while (released_.size() + found.errors.size() < kMostCulprits) {
      auto culprit = next_culprit();
      if (!culprit) break;
      if (culprit->error) {
        say(*culprit, found);
      } else {
        released_.push_back(culprit->statement);
        sigmas.push_back(culprit->sigmas);
      }
      now_ = std::move(culprit->fit);
      if (culprit->error) noise_ *= adjust_to_noise(options_, now_);
    }
    now_.noise_factor *= noise_;
    // Uses the last adjustment, which releases all of them.
    for (Contradiction& c : in_words(stated_, now_, released_, sigmas))
      found.contradictions.push_back(std::move(c));
    found.fit = std::move(now_);
    return found;
  }

 private:
  [[nodiscard]] const Site& site() const { return whole_.site; }

  struct Culprit {
    Statement statement;  ///< released assumption, unless `error` is the culprit
    Fit fit;
    double sigmas = 0.0;
    std::optional<CommonError> error = {}, or_else = {};  ///< or_else: an equally likely error
  };

  // Suspects without a new adjustment

  struct Suspect {
    Statement statement;
    double sigmas = 0.0;
  };

  [[nodiscard]] std::vector<Suspect> suspects() const {
    std::vector<Statement> held;
    for (const Statement& s : all_)
      if (!is_released(s) && is_held(s)) held.push_back(s);
    std::vector<Statement> loose = released_;
    loose.insert(loose.end(), held.begin(), held.end());
    Problem problem = now_.problem;
    const ParameterLayout wide = stated_.layout_without(loose, now_.state(), problem);
    std::vector<Trajectory> trajectories = now_.trajectories;
    const Eigen::VectorXd x = wide.vector_of(now_.state());
    const SharedState state = wide.state_of(x);
    const Information information =
        information_at(problem, wide, trajectories, x, {.threads = options_.threads});
    const double noise2 = std::max(1e-12, now_.noise_factor * now_.noise_factor);
    std::vector<int> free;
    std::vector<bool> held_column(static_cast<std::size_t>(wide.size()), false);
    for (const Statement& s : held)
      for (const int c : columns_of(s, wide)) held_column[static_cast<std::size_t>(c)] = true;
    for (int c = 0; c < wide.size(); ++c)
      if (!held_column[static_cast<std::size_t>(c)]) free.push_back(c);
    const Eigen::MatrixXd H = information.data / noise2;
    const Eigen::VectorXd gradient = information.data_gradient / noise2;
    const Eigen::MatrixXd C = inverse_of_information((H + information.prior)(free, free));
    std::vector<int> place(static_cast<std::size_t>(wide.size()), -1);
    for (std::size_t i = 0; i < free.size(); ++i)
      place[static_cast<std::size_t>(free[i])] = static_cast<int>(i);
    std::vector<Suspect> found;
    for (const Statement& s : all_) {
      if (is_released(s)) continue;
      Suspect suspect{s, 0.0};
      const std::vector<int> columns = columns_of(s, wide);
      if (s.what == What::kDistance) {
        suspect.sigmas = distance_sigmas(s.index, wide, state, C, place);
      } else if (is_held(s)) {
        const Eigen::MatrixXd H_sf = H(columns, free);
        suspect.sigmas =
            released_sigmas(H(columns, columns) - H_sf * C * H_sf.transpose(), gradient(columns));
      } else {
        suspect.sigmas = prior_sigmas(columns, wide, x, C, place);
      }
      if (is_mostly_left_out(s)) suspect.sigmas = std::max(suspect.sigmas, 1e3);
      if (suspect.sigmas > kSuspectStatementSigmas) found.push_back(suspect);
    }
    std::ranges::sort(found, std::ranges::greater{}, &Suspect::sigmas);
    if (found.size() > kMostSuspects) found.resize(kMostSuspects);
    return found;
  }

  /// lambda' C^+ lambda as a normal deviate. Directions that the data do not determine do not count.
  static double released_sigmas(const Eigen::MatrixXd& C_lambda, const Eigen::VectorXd& lambda) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(C_lambda);
    Difference d{Eigen::VectorXd::Zero(0), {}, 0.0};
    std::vector<double> parts;
    for (Eigen::Index i = 0; i < lambda.size(); ++i)
      if (eigen.eigenvalues()[i] > 1e-8 * eigen.eigenvalues().maxCoeff())
        parts.push_back(eigen.eigenvectors().col(i).dot(lambda) / std::sqrt(eigen.eigenvalues()[i]));
    d.v = Eigen::Map<Eigen::VectorXd>(parts.data(), static_cast<Eigen::Index>(parts.size()));
    d.covariance = Eigen::MatrixXd::Identity(d.v.size(), d.v.size());
    return d.sigmas();
  }

  static double prior_sigmas(const std::vector<int>& columns, const ParameterLayout& layout,
                             const Eigen::VectorXd& x, const Eigen::MatrixXd& C,
                             const std::vector<int>& place) {
    Difference d;
    d.v.resize(static_cast<Eigen::Index>(columns.size()));
    d.covariance.resize(d.v.size(), d.v.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Parameter& p = layout.parameter(columns[i]);
      if (!has_prior(p)) return 0.0;
      const auto row = static_cast<Eigen::Index>(i);
      d.v[row] = x[columns[i]] - p.prior_mean;
      for (std::size_t j = 0; j < columns.size(); ++j)
        d.covariance(row, static_cast<Eigen::Index>(j)) =
            (i == j ? p.prior_sigma * p.prior_sigma : 0.0) -
            C(place[static_cast<std::size_t>(columns[i])], place[static_cast<std::size_t>(columns[j])]);
    }
    // A direction that the data improve by less than a hundredth is determined by the prior.
    for (Eigen::Index i = 0; i < d.v.size(); ++i) {
      const double prior2 =
          d.covariance(i, i) + C(place[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])],
                                 place[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])]);
      d.covariance(i, i) += 0.01 * prior2;
    }
    return d.sigmas();
  }

  [[nodiscard]] double distance_sigmas(std::size_t index, const ParameterLayout& layout,
                                       const SharedState& state, const Eigen::MatrixXd& C,
                                       const std::vector<int>& place) const {
    const PriorRow row = distance_row(site().distances[index], layout, state);
    Eigen::VectorXd a = Eigen::VectorXd::Zero(C.rows());
    for (const auto& [column, value] : row.entries)
      if (const int c = place[static_cast<std::size_t>(column)]; c >= 0) a[c] += value;
    const double variance = 1.0 - a.dot(C * a);
    return variance > 0.01 ? std::abs(row.residual) / std::sqrt(variance) : 0.0;
  }

  /// Returns true for a control point most of whose arrivals were rejected, so that its innovation is not
  /// informative.
  [[nodiscard]] bool is_mostly_left_out(const Statement& s) const {
    if (s.what != What::kControlPoint && s.what != What::kPlace) return false;
    const RejectionCounts counts =
        rejections_by_beacon(now_.trajectories, now_.beacon_usable.size())[s.index];
    const std::size_t placed = counts.all() - counts.of(Rejection::kNoPose);
    return placed >= 10 &&
           static_cast<double>(counts.outliers()) > kMostlyLeftOut * static_cast<double>(placed);
  }

  [[nodiscard]] bool is_released(const Statement& s) const {
    return std::ranges::find(released_, s) != released_.end();
  }

  // Tests with a new adjustment

  [[nodiscard]] std::optional<Culprit> next_culprit() const {
    std::optional<Culprit> best;
    for (const Suspect& suspect : suspects()) {
      if (options_.is_stopped()) break;
      if (auto c = culprit(suspect.statement, best ? best->fit.cost : now_.cost)) best = std::move(c);
    }
    // A wrong common delay or speed distorts everything, and a correct control point may be blamed for it.
    if (best)
      for (const Statement& cause : stated_.common_causes())
        if (!is_released(cause))
          if (auto c = culprit(cause, best->fit.cost - kPlainlyBetter)) best = std::move(c);
    for (std::size_t i = 0; i < std::min(errors_.size(), kMostErrors); ++i) {
      std::optional<Culprit> c = culprit(errors_[i]);
      if (!c) continue;
      if (best && best->error &&
          std::abs(best->fit.cost - c->fit.cost) <
              kEquallyLikely * noise_variance(c->fit, options_.threads)) {
        best->or_else = c->error;
      } else if (!best || c->fit.cost < best->fit.cost) {
        best = std::move(c);
      }
    }
    return best;
  }

  // Errors common to many observations

  /// Returns an error if its correction makes the recording significantly likelier, and by a relevant length.
  [[nodiscard]] std::optional<Culprit> culprit(const CommonError& error) const {
    std::optional<ErrorFit> without = fit_without(options_, now_, error);
    if (!without || without->error.sigmas < kErrorSigmas ||
        without->error.length_m < kMatters * tolerance_m(whole_))
      return {};
    return Culprit{{}, std::move(without->fit), without->error.sigmas, without->error, {}};
  }

  /// Reports an error: as a contradiction if it explains most of the misfit or is of a kind that is never
  /// normal, otherwise as a warning. No site file states the pattern of receivers.
  void say(const Culprit& c, StatementFindings& found) const {
    Contradiction what = contradiction_of(*c.error, site(), whole_.runs);
    if (c.or_else) what.found += ", or else " + contradiction_of(*c.or_else, site(), whole_.runs).found;
    const CommonError::Kind kind = c.error->kind;
    const bool is_stated =
        is_of_odometry(*c.error) || kind == CommonError::Kind::kJump || kind == CommonError::Kind::kShift;
    if (kind != CommonError::Kind::kPattern &&
        (c.fit.cost < kLeavesLess * now_.cost || (is_stated && !c.or_else))) {
      found.contradictions.push_back(std::move(what));
    } else {
      found.warnings.push_back(octant::in_words(what) + "; " + what.remedy);
    }
    found.errors.push_back(*c.error);
  }

  /// Returns an assumption if its release costs less than the other explanation, and the fit then contradicts
  /// it.
  [[nodiscard]] std::optional<Culprit> culprit(const Statement& s, double other_cost) const {
    Culprit c{s, released(s), 0.0, {}, {}};
    if (!c.fit.ok || !(c.fit.cost < other_cost)) return {};
    const Difference d = difference(s, c.fit);
    if (!is_contradicted(d)) return {};
    c.sigmas = d.sigmas();
    return c;
  }

  [[nodiscard]] Fit released(const Statement& s) const {
    Fit fit = now_;
    std::vector<Statement> loose = released_;
    loose.push_back(s);
    fit.layout = stated_.layout_without(loose, now_.state(), fit.problem);
    fit.x = fit.layout.vector_of(now_.state());
    adjust_anew(options_, fit);
    return fit;
  }

  [[nodiscard]] bool is_contradicted(const Difference& d) const {
    const double level = kFalseAlarms / static_cast<double>(std::max<std::size_t>(all_.size(), 1));
    return chance(d.squares(), d.v.size()) < level && d.sigmas() > kFewestSigmas &&
           d.length_m > kMatters * tolerance_m(whole_);
  }

  /// Difference between the site file and a fit in which the assumption is released.
  [[nodiscard]] Difference difference(const Statement& s, const Fit& fit) const {
    const Eigen::MatrixXd C = honest_covariance(options_, fit);
    Difference d;
    if (s.what == What::kDistance) return distance_difference(s, fit, C);
    std::vector<int> columns = columns_of(s, fit.layout);
    // Only the inclination of the paths determines the heights of receivers, which absorb errors that depend
    // on the angle. They do not affect fixes in the plane.
    if (s.what == What::kReceiver && site().motion == Motion::kPlanar)
      std::erase(columns, fit.layout.receiver[s.index][2]);
    d.v.resize(static_cast<Eigen::Index>(columns.size()));
    d.covariance = C(columns, columns);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      d.v[row] = fit.x[columns[i]] - stated_.value(s, fit.layout, columns[i]);
      d.covariance(row, row) += std::pow(stated_.sigma(s, fit.layout, columns[i]), 2);
    }
    d.length_m = s.what == What::kSpeed || s.what == What::kHeldSpeed ? d.v.norm() * whole_.typical_range_m
                 : s.what == What::kAttenuation                       ? attenuation_length(s, fit, d)
                 : s.what == What::kNoDelays                          ? d.v.cwiseAbs().maxCoeff()
                 : s.what == What::kOneDelay                          ? d.v.maxCoeff() - d.v.minCoeff()
                 : s.what == What::kDelays                            ? d.v.cwiseAbs().maxCoeff()
                                                                      : d.v.norm();
    return d;
  }

  [[nodiscard]] Difference distance_difference(const Statement& s, const Fit& fit,
                                               const Eigen::MatrixXd& C) const {
    const ControlDistance& taped = site().distances[s.index];
    const PriorRow row = distance_row(taped, fit.layout, fit.state());
    Eigen::VectorXd a = Eigen::VectorXd::Zero(C.rows());
    for (const auto& [column, value] : row.entries) a[column] += value;
    Difference d;
    d.v = Eigen::VectorXd::Constant(1, taped.sigma_m * row.residual);
    d.covariance = Eigen::MatrixXd::Constant(1, 1, taped.sigma_m * taped.sigma_m * (a.dot(C * a) + 1.0));
    d.length_m = std::abs(d.v[0]);
    return d;
  }

  /// Largest shift of a beacon if a coefficient of the attenuation is released.
  [[nodiscard]] double attenuation_length(const Statement&, const Fit& fit, const Difference&) const {
    const SharedState then = now_.state(), here = fit.state();
    double largest = 0.0;
    for (std::size_t b = 0; b < here.beacon_p_map_m.size(); ++b)
      if (fit.beacon_usable[b])
        largest = std::max(largest, (here.beacon_p_map_m[b] - then.beacon_p_map_m[b]).norm());
    return largest;
  }

  const Problem& whole_;
  const SolveOptions& options_;
  Fit now_;  ///< with all released assumptions
  StatedSite stated_;
  std::vector<Statement> all_, released_;
  std::vector<CommonError> errors_;  ///< hypotheses from the residuals of the original fit
  double noise_ = 1.0;               ///< current noise of the arrivals relative to the original one
};

}  // namespace

StatementFindings test_statements(const Problem& problem, const SolveOptions& options,
                                  const Estimate& estimate, const std::vector<Trajectory>& trajectories) {
  if (estimate.x.size() == 0 || estimate.x.size() > kMostParameters) return {};
  return StatementTest(problem, options, estimate, trajectories).run();
}

}  // namespace octant::calib
