// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/statements.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/adjust/priors.h"
#include "calib/problem/ranges.h"
#include "calib/problem/trilaterate.h"
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
/// Half squares by which a common cause must explain more than the best single assumption, because it has
/// more parameters.
constexpr double kPlainlyBetter = 16.0;
/// Maximum number of parameters. The matrices are dense: about ten of 32 MB.
constexpr Eigen::Index kMostParameters = 2000;
constexpr std::size_t kMostCulprits = 4;
/// Least significance of an error that many observations have in common; some dozens are tested.
constexpr double kErrorSigmas = 6.0;
/// Largest share of the cost that may remain if such an error is a contradiction.
constexpr double kLeavesLess = 0.5;
/// Share of the cost below which the most significant error leaves no misfit for other suspects.
constexpr double kLeavesLittle = 0.1;
/// Ratio of the residuals to the stated noise above which they are a misfit.
constexpr double kMoreThanStated = 1.2;
constexpr std::size_t kMostErrors = 4;
/// Difference of log-likelihoods below which errors are equally likely.
constexpr double kEquallyLikely = 5.0;

double chance(double squares, Eigen::Index degrees) {
  return squares > 0 && degrees > 0 ? chi_square_tail(squares, static_cast<int>(degrees)) : 1.0;
}

class StatementTest {
 public:
  StatementTest(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                const std::vector<Trajectory>& trajectories)
      : whole_(problem),
        options_(options),
        now_(fit_of(problem, options, estimate, trajectories)),
        stated_(problem, estimate.layout, now_.beacon_usable),
        all_(stated_.all()),
        is_misfit_(estimate.noise_factor * now_.noise_factor > kMoreThanStated) {}

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

  // Tests with a new adjustment

  [[nodiscard]] std::optional<Culprit> next_culprit() const {
    const std::vector<Suspect> suspects = stated_.suspects(now_, released_, options_.threads);
    std::optional<Culprit> best;
    if (!errors_.empty()) consider(errors_.front(), best);
    if (best && best->fit.cost < kLeavesLittle * now_.cost) return best;
    for (const Suspect& suspect : suspects)
      if (const auto place_m = place_by_ranges(suspect.statement))
        consider_exchange(suspect.statement, *place_m, best);
    const bool has_signs = has_heights(site()) && !is_released({What::kHeights}, released_);
    if (!suspects.empty() && has_signs && !(best && is_explained_by(*best))) consider({What::kHeights}, best);
    for (const Suspect& suspect : suspects) {
      if (options_.is_stopped() || (best && is_explained_by(*best))) break;
      consider(suspect.statement, best);
    }
    if (best && is_explained_by(*best)) return best;
    // A wrong common delay or speed distorts everything: no single release explains it, or that of a correct
    // control point does in part.
    if (!suspects.empty() && !(best && best->error))
      for (const Statement& cause : stated_.common_causes())
        if (!is_released(cause, released_)) consider(cause, best, kPlainlyBetter);
    for (std::size_t i = 1; i < std::min(errors_.size(), kMostErrors); ++i) consider(errors_[i], best);
    return best;
  }

  // Errors common to many observations

  /// Keeps an error as the best explanation if its correction makes the recording significantly likelier, by
  /// a relevant length, and costs less. An equally likely error is kept as an alternative.
  void consider(const CommonError& error, std::optional<Culprit>& best) const {
    std::optional<ErrorFit> without = fit_without(options_, now_, error);
    if (!without || without->error.sigmas < kErrorSigmas) return;
    // A lag that shifts ranges by centimetres can move beacons by metres if they are seen from one side. The
    // rule is limited to lags because any error can move a beacon that is hardly determined.
    const double length_m = error.kind == CommonError::Kind::kLag
                                ? std::max(without->error.length_m, largest_shift_m(without->fit))
                                : without->error.length_m;
    if (length_m < kMatters * tolerance_m(whole_)) return;
    if (best && best->error &&
        std::abs(best->fit.cost - without->fit.cost) < kEquallyLikely * without->variance) {
      best->or_else = without->error;
    } else if (!best || without->fit.cost < best->fit.cost) {
      best = Culprit{{}, std::move(without->fit), without->error.sigmas, without->error, {}};
    }
  }

  /// Reports an error: as a contradiction if it explains most of a misfit or is of a kind that is never
  /// normal, otherwise as a warning. Residuals within the stated noise are no misfit, because a slow change
  /// of the medium may be a part of that noise. No site file states the pattern of receivers.
  void say(const Culprit& c, StatementFindings& found) const {
    Contradiction what = contradiction_of(*c.error, site(), whole_.runs);
    if (c.or_else) what.found += ", or else " + contradiction_of(*c.or_else, site(), whole_.runs).found;
    const CommonError::Kind kind = c.error->kind;
    const bool is_stated =
        is_of_odometry(*c.error) || kind == CommonError::Kind::kJump || kind == CommonError::Kind::kShift;
    if (kind != CommonError::Kind::kPattern &&
        ((is_misfit_ && c.fit.cost < kLeavesLess * now_.cost) || (is_stated && !c.or_else))) {
      found.contradictions.push_back(std::move(what));
    } else {
      found.warnings.push_back(octant::in_words(what) + "; " + what.remedy);
    }
    found.errors.push_back(*c.error);
  }

  /// Keeps an assumption as the best explanation if its release costs less by some amount, and the fit then
  /// contradicts it. A beacon that is found at the position of another one may be exchanged with it.
  void consider(const Statement& s, std::optional<Culprit>& best, double less = 0.0) const {
    Culprit c{s, released(s), 0.0, {}, {}};
    if (!c.fit.ok) return;
    const Eigen::Vector3d found_m =
        is_place(s) ? c.fit.state().beacon_p_map_m[s.index] : Eigen::Vector3d::Zero();
    if (c.fit.cost < (best ? best->fit.cost : now_.cost) - less) {
      const Difference d = difference(s, c.fit);
      c.sigmas = d.sigmas();
      if (is_contradicted(d)) best = std::move(c);
    }
    if (is_place(s)) consider_exchange(s, found_m, best);
  }

  void consider_exchange(const Statement& s, const Eigen::Vector3d& found_m,
                         std::optional<Culprit>& best) const {
    const std::optional<Statement> exchange = stated_.exchange_of(s, found_m);
    if (exchange && !is_released(*exchange, released_) && !(best && best->statement == *exchange))
      consider(*exchange, best);
  }

  /// Position of a beacon by all its arrivals, for the current states of the vehicle.
  [[nodiscard]] std::optional<Eigen::Vector3d> place_by_ranges(const Statement& s) const {
    if (!is_place(s)) return {};
    constexpr double kScale = 0.01;  // share of the typical range
    TrilaterationOptions options;
    options.scale_m = kScale * whole_.typical_range_m;
    const Trilateration place =
        trilaterate(ranges_to(now_.trajectories, now_.state(), BeaconId(s.index)), options);
    return place.ok ? std::optional(place.p_map_m) : std::nullopt;
  }

  /// Returns true if an assumption that has one alternative, and thus no free parameter, explains most of the
  /// misfit. That is no coincidence.
  [[nodiscard]] bool is_explained_by(const Culprit& c) const {
    return !c.error && has_alternative(c.statement) && c.fit.cost < kLeavesLess * now_.cost;
  }

  [[nodiscard]] Fit released(const Statement& s) const {
    Fit fit = now_;
    std::vector<Statement> loose = released_;
    loose.push_back(s);
    const SharedState start = stated_.with_alternative(s, now_.state());
    fit.layout = stated_.layout_without(loose, start, fit.problem);
    fit.x = fit.layout.vector_of(start);
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
    if (has_alternative(s)) return difference_of_alternative(s, fit);
    const auto [C, freedoms] = honest_covariance(options_, fit);
    if (s.what == What::kDistance) return distance_difference(s, fit, C, freedoms);
    Difference d;
    d.freedoms = freedoms;
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
                 : s.what == What::kAttenuation                       ? largest_shift_m(fit)
                 : s.what == What::kNoDelays                          ? d.v.cwiseAbs().maxCoeff()
                 : s.what == What::kOneDelay                          ? d.v.maxCoeff() - d.v.minCoeff()
                 : s.what == What::kDelays                            ? d.v.cwiseAbs().maxCoeff()
                                                                      : d.v.norm();
    return d;
  }

  /// Gain in log-likelihood as a squared deviation. The length is the shift of the beacons.
  [[nodiscard]] Difference difference_of_alternative(const Statement& s, const Fit& fit) const {
    Difference d;
    d.v = Eigen::VectorXd::Constant(
        1, std::sqrt(std::max(0.0, 2 * (now_.cost - fit.cost) / noise_variance(fit, options_.threads))));
    d.covariance = Eigen::MatrixXd::Identity(1, 1);
    const SharedState before = now_.state(), after = stated_.with_alternative(s, before);
    for (std::size_t b = 0; b < after.beacon_p_map_m.size(); ++b)
      d.length_m = std::max(d.length_m, (after.beacon_p_map_m[b] - before.beacon_p_map_m[b]).norm());
    return d;
  }

  [[nodiscard]] Difference distance_difference(const Statement& s, const Fit& fit, const Eigen::MatrixXd& C,
                                               double freedoms) const {
    const ControlDistance& taped = site().distances[s.index];
    const PriorRow row = distance_row(taped, fit.layout, fit.state());
    Eigen::VectorXd a = Eigen::VectorXd::Zero(C.rows());
    for (const auto& [column, value] : row.entries) a[column] += value;
    Difference d;
    d.freedoms = freedoms;
    d.v = Eigen::VectorXd::Constant(1, taped.sigma_m * row.residual);
    d.covariance = Eigen::MatrixXd::Constant(1, 1, taped.sigma_m * taped.sigma_m * (a.dot(C * a) + 1.0));
    d.length_m = std::abs(d.v[0]);
    return d;
  }

  /// Largest shift of a beacon from the current fit to another one.
  [[nodiscard]] double largest_shift_m(const Fit& fit) const {
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
  bool is_misfit_;                   ///< residuals of the original fit exceed the stated noise
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
