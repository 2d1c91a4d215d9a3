// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/statements.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "calib/adjust/priors.h"
#include "calib/adjust/tile_sum.h"
#include "calib/statements/refit.h"
#include "calib/verdict/observability.h"
#include "calib/verdict/validity.h"
#include "models/changes/chi_square.h"

namespace octant::calib {
namespace {

/// Chance of a false contradiction at a site, over all that is tested there.
constexpr double kFalseAlarms = 0.002;
/// Models are not exact: what is seen at fewer sigmas is no contradiction, however many observations there
/// are.
constexpr double kFewestSigmas = 5.0;
/// A deviation below this share of the site's tolerance is of no consequence.
constexpr double kMatters = 0.2;
/// Before anything is adjusted again.
constexpr double kSuspectStatementSigmas = 4.0;
constexpr double kMostlyLeftOut = 0.3;
constexpr std::size_t kMostSuspects = 8, kMostCulprits = 4;

enum class What {
  kControlPoint,
  kBeaconDelay,
  kReceiverDelay,
  kSiteDelay,
  kNoDelays,
  kSpeed,
  kReceiver,
  kAttenuation,
  kDistance
};

struct Statement {
  What what = What::kSpeed;
  std::size_t index = 0;  ///< of the beacon, receiver, run, coefficient or distance
  bool operator==(const Statement&) const = default;
};

/// A difference of what was stated and what was found.
struct Difference {
  Eigen::VectorXd v;  ///< found less stated, internal units
  Eigen::MatrixXd covariance;
  double length_m = 0.0;  ///< at the beacons or at the robot
  /// Squares of the difference in its own covariance.
  [[nodiscard]] double squares() const { return v.size() == 0 ? 0.0 : v.dot(covariance.ldlt().solve(v)); }
  /// Normal deviate of the same chance of squares() by chi-square (Wilson and Hilferty 1931, far in the
  /// tail).
  [[nodiscard]] double sigmas() const {
    const double n = static_cast<double>(v.size()), s = squares();
    if (!(s > 0) || !std::isfinite(s)) return 0.0;
    return n == 1 ? std::sqrt(s) : std::max(0.0, std::sqrt(s) - std::sqrt(n - 1));
  }
};

double chance(double squares, Eigen::Index degrees) {
  return squares > 0 && degrees > 0 ? chi_square_tail(squares, static_cast<int>(degrees)) : 1.0;
}

/// Whether a statement's columns are those of a prior, or of what is held.
bool has_prior(const Parameter& p) { return std::isfinite(p.prior_sigma); }

class StatementTest {
 public:
  StatementTest(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                const std::vector<Trajectory>& trajectories)
      : whole_(problem),
        options_(options),
        stated_(estimate.layout),
        now_(fit_of(problem, options, estimate, trajectories)) {
    list();
  }

  StatementFindings run() {
    if (!now_.x.allFinite()) return {};
    std::vector<Contradiction> found;
    std::vector<Culprit> culprits;
    while (culprits.size() < kMostCulprits) {
      auto culprit = next_culprit();
      if (!culprit) break;
      now_ = std::move(culprit->fit);
      released_.push_back(culprit->statement);
      culprits.push_back(std::move(*culprit));
    }
    // Told by the last adjustment, in which all of them are released.
    for (const Culprit& c : culprits) found.push_back(told(c));
    join_exchanged(culprits, found);
    return {std::move(found), std::move(now_)};
  }

 private:
  struct Culprit {
    Statement statement;
    Fit fit;
    double sigmas = 0.0;
  };

  // What is stated
  // ----------------------------------------------------------------------------------------------------

  [[nodiscard]] const Site& site() const { return whole_.site; }

  void list() {
    const Site& s = site();
    for (std::size_t b = 0; b < s.beacons.size(); ++b) {
      if (s.beacons[b].is_control_point() && now_.beacon_usable[b]) all_.push_back({What::kControlPoint, b});
      if (stated_.beacon_delay[b] >= 0) all_.push_back({What::kBeaconDelay, b});
    }
    for (std::size_t r = 0; r < s.receivers.size(); ++r) {
      if (stated_.receiver_delay[r] >= 0) all_.push_back({What::kReceiverDelay, r});
      if (std::max({stated_.receiver[r][0], stated_.receiver[r][1], stated_.receiver[r][2]}) >= 0)
        all_.push_back({What::kReceiver, r});
    }
    if (stated_.site_delay >= 0) all_.push_back({What::kSiteDelay, 0});
    const bool has_delay = largest_delay_sigma_s(s) > 0;
    if (!has_delay && s.timing.clock == Clock::kSynchronised && s.tof_sigma_given)
      all_.push_back({What::kNoDelays, 0});
    for (std::size_t run = 0; run < stated_.speed.size(); ++run) all_.push_back({What::kSpeed, run});
    for (std::size_t i = 0; i < stated_.attenuation.size(); ++i)
      if (stated_.attenuation[i] >= 0) all_.push_back({What::kAttenuation, i});
    for (std::size_t d = 0; d < s.distances.size(); ++d) all_.push_back({What::kDistance, d});
  }

  /// Columns of a statement in a layout in which it may move.
  [[nodiscard]] static std::vector<int> columns_of(const Statement& s, const ParameterLayout& layout) {
    std::vector<int> columns;
    const auto add = [&](int c) {
      if (c >= 0) columns.push_back(c);
    };
    switch (s.what) {
      case What::kControlPoint:
        for (const int c : layout.beacon[s.index]) add(c);
        break;
      case What::kBeaconDelay: add(layout.beacon_delay[s.index]); break;
      case What::kReceiverDelay: add(layout.receiver_delay[s.index]); break;
      case What::kSiteDelay: add(layout.site_delay); break;
      case What::kNoDelays:
        for (const int c : layout.beacon_delay) add(c);
        break;
      case What::kSpeed: add(layout.speed[s.index]); break;
      case What::kReceiver:
        for (const int c : layout.receiver[s.index]) add(c);
        break;
      case What::kAttenuation: add(layout.attenuation[s.index]); break;
      case What::kDistance: break;
    }
    return columns;
  }

  /// So wide that the data alone tell, and finite so that what they do not tell stays where it was.
  [[nodiscard]] double wide_sigma(const Statement& s) const {
    switch (s.what) {
      case What::kSpeed: return 0.3;
      case What::kReceiver: return 1.0;
      case What::kAttenuation: return 10.0;
      default: return whole_.typical_range_m;
    }
  }

  /// A layout in which some statements are not believed.
  [[nodiscard]] ParameterLayout layout_without(const std::vector<Statement>& released,
                                               const SharedState& state, Problem& problem) const {
    problem.site = site();
    for (const Statement& s : released) {
      if (s.what == What::kControlPoint) problem.site.beacons[s.index].sigma_m = {};
      if (s.what == What::kNoDelays) {
        problem.site.timing.delay_per = {.beacon = true};
        problem.site.timing.delay_sigma_s = 1.0;
        for (SiteBeacon& b : problem.site.beacons) b.delay_sigma_s.reset();
      }
    }
    std::vector<std::size_t> distances;
    for (const Statement& s : released)
      if (s.what == What::kDistance) distances.push_back(s.index);
    std::sort(distances.rbegin(), distances.rend());
    for (const std::size_t d : distances)
      problem.site.distances.erase(problem.site.distances.begin() + static_cast<std::ptrdiff_t>(d));
    std::vector<bool> held(now_.beacon_usable.size());
    for (std::size_t b = 0; b < held.size(); ++b) held[b] = !now_.beacon_usable[b];
    ParameterLayout layout = make_layout(problem, state, held);
    layout.dense_limit = stated_.dense_limit;
    // Priors as the labels were mended.
    for (std::size_t b = 0; b < layout.beacon.size(); ++b)
      for (std::size_t i = 0; i < 3; ++i)
        if (const int old = stated_.beacon[b][i], c = layout.beacon[b][i]; old >= 0 && c >= 0)
          layout.parameters[static_cast<std::size_t>(c)] = stated_.parameters[static_cast<std::size_t>(old)];
    for (const Statement& s : released)
      for (const int c : columns_of(s, layout)) {
        Parameter& p = layout.parameters[static_cast<std::size_t>(c)];
        p.prior_mean = stated_value(s, layout, c);
        p.prior_sigma = wide_sigma(s);
      }
    return layout;
  }

  /// As the site file has it, internal unit.
  [[nodiscard]] double stated_value(const Statement& s, const ParameterLayout& layout, int column) const {
    const SharedState prior = prior_state(site());
    if (s.what == What::kControlPoint) {
      for (std::size_t i = 0; i < 3; ++i)
        if (layout.beacon[s.index][i] == column) return *site().beacons[s.index].position_m[i];
    }
    if (s.what == What::kNoDelays && site().timing.delay_per.none()) return 0.0;
    return layout.parameters[static_cast<std::size_t>(column)].prior_mean;
  }
  [[nodiscard]] double stated_delay_s() const {
    return site().timing.delay_per.none() ? 0.0 : site().timing.delay_s;
  }

  /// Sigma by which the site file states it; 0: held.
  [[nodiscard]] double stated_sigma(const Statement& s, const ParameterLayout& layout, int column) const {
    const ParameterId& id = layout.parameters[static_cast<std::size_t>(column)].id;
    if (s.what == What::kControlPoint || s.what == What::kNoDelays) return 0.0;
    for (const Parameter& p : stated_.parameters)
      if (p.id == id) return p.prior_sigma;
    return 0.0;
  }

  // Without a new solve
  // -----------------------------------------------------------------------------------------------

  struct Suspect {
    Statement statement;
    double sigmas = 0.0;
  };

  [[nodiscard]] std::vector<Suspect> suspects() const {
    std::vector<Statement> held;
    for (const Statement& s : all_)
      if (!is_released(s) && (s.what == What::kControlPoint || s.what == What::kNoDelays)) held.push_back(s);
    std::vector<Statement> loose = released_;
    loose.insert(loose.end(), held.begin(), held.end());
    Problem problem = now_.problem;
    const ParameterLayout wide = layout_without(loose, now_.state(), problem);
    std::vector<Trajectory> trajectories = now_.trajectories;
    TileSum tiles(trajectories, wide, {options_.threads, nullptr});
    const Eigen::VectorXd x = wide.vector_of(now_.state());
    const SharedState state = wide.state_of(x);
    static_cast<void>(tiles.settle(state, {}));
    ReducedSystem data;
    tiles.reduce(state, {}, data);
    const double noise2 = std::max(1e-12, now_.noise_factor * now_.noise_factor);
    std::vector<int> free;
    std::vector<bool> is_held(static_cast<std::size_t>(wide.size()), false);
    for (const Statement& s : held)
      for (const int c : columns_of(s, wide)) is_held[static_cast<std::size_t>(c)] = true;
    for (int c = 0; c < wide.size(); ++c)
      if (!is_held[static_cast<std::size_t>(c)]) free.push_back(c);
    const Eigen::MatrixXd prior = prior_information(problem, wide, x);
    const Eigen::MatrixXd C = inverse_of_information((data.H / noise2 + prior)(free, free));
    std::vector<int> place(static_cast<std::size_t>(wide.size()), -1);
    for (std::size_t i = 0; i < free.size(); ++i)
      place[static_cast<std::size_t>(free[i])] = static_cast<int>(i);
    std::vector<Suspect> found;
    for (const Statement& s : all_) {
      if (is_released(s)) continue;
      Suspect suspect{s, 0.0};
      const std::vector<int> columns = columns_of(s, wide);
      const bool was_held = s.what == What::kControlPoint || s.what == What::kNoDelays;
      if (s.what == What::kDistance) {
        suspect.sigmas = distance_sigmas(s.index, wide, state, C, place);
      } else if (was_held) {
        const Eigen::MatrixXd H_sf = data.H(columns, free) / noise2;
        suspect.sigmas = released_sigmas(data.H(columns, columns) / noise2 - H_sf * C * H_sf.transpose(),
                                         data.gradient(columns) / noise2);
      } else {
        suspect.sigmas = prior_sigmas(columns, wide, x, C, place);
      }
      if (is_mostly_left_out(s)) suspect.sigmas = std::max(suspect.sigmas, 1e3);
      if (suspect.sigmas > kSuspectStatementSigmas) found.push_back(suspect);
    }
    std::sort(found.begin(), found.end(),
              [](const Suspect& a, const Suspect& b) { return a.sigmas > b.sigmas; });
    if (found.size() > kMostSuspects) found.resize(kMostSuspects);
    return found;
  }

  /// lambda' C^+ lambda as a normal deviate; directions of which the data tell nothing do not count.
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
      const Parameter& p = layout.parameters[static_cast<std::size_t>(columns[i])];
      if (!has_prior(p)) return 0.0;
      const auto row = static_cast<Eigen::Index>(i);
      d.v[row] = x[columns[i]] - p.prior_mean;
      for (std::size_t j = 0; j < columns.size(); ++j)
        d.covariance(row, static_cast<Eigen::Index>(j)) =
            (i == j ? p.prior_sigma * p.prior_sigma : 0.0) -
            C(place[static_cast<std::size_t>(columns[i])], place[static_cast<std::size_t>(columns[j])]);
    }
    // What the data improve by less than a hundredth is the prior itself.
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
    const ControlDistance& d = site().distances[index];
    const Eigen::Vector3d v = state.beacon_p_map_m[d.from.index()] - state.beacon_p_map_m[d.to.index()];
    Eigen::VectorXd a = Eigen::VectorXd::Zero(C.rows());
    for (std::size_t i = 0; i < 3; ++i) {
      const double k = v[static_cast<Eigen::Index>(i)] / std::max(v.norm(), 1e-9);
      if (const int c = layout.beacon[d.from.index()][i]; c >= 0 && place[static_cast<std::size_t>(c)] >= 0)
        a[place[static_cast<std::size_t>(c)]] += k;
      if (const int c = layout.beacon[d.to.index()][i]; c >= 0 && place[static_cast<std::size_t>(c)] >= 0)
        a[place[static_cast<std::size_t>(c)]] -= k;
    }
    const double variance = d.sigma_m * d.sigma_m - a.dot(C * a);
    return variance > 0.01 * d.sigma_m * d.sigma_m ? std::abs(v.norm() - d.distance_m) / std::sqrt(variance)
                                                   : 0.0;
  }

  /// A control point most of whose arrivals were left out has no say any more: its innovation tells nothing.
  [[nodiscard]] bool is_mostly_left_out(const Statement& s) const {
    if (s.what != What::kControlPoint) return false;
    std::size_t placed = 0, out = 0;
    for (const Trajectory& t : now_.trajectories)
      for (const ArrivalObservation& a : t.arrivals) {
        if (a.beacon.index() != s.index || !t.nodes[a.node].placed) continue;
        ++placed;
        out += a.rejection == Rejection::kLate || a.rejection == Rejection::kEarly;
      }
    return placed >= 10 && static_cast<double>(out) > kMostlyLeftOut * static_cast<double>(placed);
  }

  [[nodiscard]] bool is_released(const Statement& s) const {
    return std::find(released_.begin(), released_.end(), s) != released_.end();
  }

  // With one
  // -----------------------------------------------------------------------------------------------------------

  [[nodiscard]] std::optional<Culprit> next_culprit() const {
    std::optional<Culprit> best;
    for (const Suspect& suspect : suspects()) {
      Culprit c{suspect.statement, released(suspect.statement), 0.0};
      if (!c.fit.ok || !(c.fit.cost < now_.cost)) continue;
      if (best && !(c.fit.cost < best->fit.cost)) continue;
      const Difference d = difference(suspect.statement, c.fit);
      if (!is_contradicted(d)) continue;
      c.sigmas = d.sigmas();
      best = std::move(c);
    }
    return best;
  }

  [[nodiscard]] Fit released(const Statement& s) const {
    Fit fit = now_;
    std::vector<Statement> loose = released_;
    loose.push_back(s);
    fit.layout = layout_without(loose, now_.state(), fit.problem);
    fit.x = fit.layout.vector_of(now_.state());
    adjust_anew(options_, fit);
    return fit;
  }

  [[nodiscard]] bool is_contradicted(const Difference& d) const {
    const double level = kFalseAlarms / static_cast<double>(std::max<std::size_t>(all_.size(), 1));
    return chance(d.squares(), d.v.size()) < level && d.sigmas() > kFewestSigmas &&
           d.length_m > kMatters * tolerance_m(whole_);
  }

  /// What a fit in which the statement is not believed finds of it.
  [[nodiscard]] Difference difference(const Statement& s, const Fit& fit) const {
    const Eigen::MatrixXd C = honest_covariance(options_, fit);
    Difference d;
    if (s.what == What::kDistance) return distance_difference(s, fit, C);
    std::vector<int> columns = columns_of(s, fit.layout);
    // Receivers' heights are told by the inclination of the paths alone, where errors that depend on the
    // angle go; no fix in the plane feels them.
    if (s.what == What::kReceiver && site().motion == Motion::kPlanar)
      std::erase(columns, fit.layout.receiver[s.index][2]);
    d.v.resize(static_cast<Eigen::Index>(columns.size()));
    d.covariance = C(columns, columns);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      d.v[row] = fit.x[columns[i]] - stated_value(s, fit.layout, columns[i]);
      d.covariance(row, row) += std::pow(stated_sigma(s, fit.layout, columns[i]), 2);
    }
    d.length_m = s.what == What::kSpeed         ? d.v.norm() * whole_.typical_range_m
                 : s.what == What::kAttenuation ? attenuation_length(s, fit, d)
                 : s.what == What::kNoDelays    ? d.v.cwiseAbs().maxCoeff()
                                                : d.v.norm();
    return d;
  }

  [[nodiscard]] Difference distance_difference(const Statement& s, const Fit& fit,
                                               const Eigen::MatrixXd& C) const {
    const ControlDistance& told = site().distances[s.index];
    const SharedState state = fit.state();
    const Eigen::Vector3d between =
        state.beacon_p_map_m[told.from.index()] - state.beacon_p_map_m[told.to.index()];
    Eigen::VectorXd a = Eigen::VectorXd::Zero(C.rows());
    for (std::size_t i = 0; i < 3; ++i) {
      const double k = between[static_cast<Eigen::Index>(i)] / std::max(between.norm(), 1e-9);
      if (const int c = fit.layout.beacon[told.from.index()][i]; c >= 0) a[c] += k;
      if (const int c = fit.layout.beacon[told.to.index()][i]; c >= 0) a[c] -= k;
    }
    Difference d;
    d.v = Eigen::VectorXd::Constant(1, between.norm() - told.distance_m);
    d.covariance = Eigen::MatrixXd::Constant(1, 1, a.dot(C * a) + told.sigma_m * told.sigma_m);
    d.length_m = std::abs(d.v[0]);
    return d;
  }

  /// By how much the beacons move where a coefficient of the attenuation is not believed.
  [[nodiscard]] double attenuation_length(const Statement&, const Fit& fit, const Difference&) const {
    const SharedState then = now_.state(), here = fit.state();
    double largest = 0.0;
    for (std::size_t b = 0; b < here.beacon_p_map_m.size(); ++b)
      if (fit.beacon_usable[b])
        largest = std::max(largest, (here.beacon_p_map_m[b] - then.beacon_p_map_m[b]).norm());
    return largest;
  }

  // In words
  // -----------------------------------------------------------------------------------------------------------

  static std::string point(const Eigen::Vector3d& p) {
    return fmt::format("({:.3f}, {:.3f}, {:.3f}) m", p.x(), p.y(), p.z());
  }
  static std::string length(double m) {
    return std::abs(m) < 1.0 ? fmt::format("{:.1f} mm", 1e3 * m) : fmt::format("{:.3f} m", m);
  }
  static std::string time(double s) {
    return std::abs(s) < 1e-6 ? fmt::format("{:.2f} ns", 1e9 * s) : fmt::format("{:.1f} us", 1e6 * s);
  }
  [[nodiscard]] std::string receiver_name(std::size_t r) const {
    return site().vehicles[site().receivers[r].vehicle.index()].name + "/" + site().receivers[r].name;
  }

  [[nodiscard]] Contradiction told(const Culprit& culprit) const {
    const Statement& s = culprit.statement;
    const SharedState state = now_.state();
    Contradiction c;
    c.sigmas = culprit.sigmas;
    switch (s.what) {
      case What::kControlPoint: tell_control_point(s, state, c); break;
      case What::kBeaconDelay:
        tell_delay(site().beacons[s.index].name, beacon_delay_prior(site(), s.index),
                   state.beacon_delay_s[s.index], c);
        break;
      case What::kReceiverDelay:
        tell_delay(receiver_name(s.index), timing_prior(), state.receiver_delay_s[s.index], c);
        break;
      case What::kSiteDelay: tell_delay("the site", timing_prior(), state.site_delay_s, c); break;
      case What::kNoDelays: tell_delays(state, c); break;
      case What::kSpeed: tell_speed(s, c); break;
      case What::kReceiver: tell_receiver(s, state, c); break;
      case What::kAttenuation: tell_attenuation(s, c); break;
      case What::kDistance: tell_distance(s, state, c); break;
    }
    return c;
  }

  void tell_control_point(const Statement& s, const SharedState& state, Contradiction& c) const {
    const SiteBeacon& b = site().beacons[s.index];
    const Eigen::Vector3d stated(*b.position_m[0], *b.position_m[1], *b.position_m[2]),
        found = state.beacon_p_map_m[s.index];
    c.kind = ContradictionKind::kControlPoint;
    c.subject = b.name;
    c.stated = fmt::format("at {}, held fixed", point(stated));
    c.found = fmt::format("at {}, {} away", point(found), length((found - stated).norm()));
    c.remedy = fmt::format(
        "survey control point {} again, check its label and its line in the site file; or give it a sigma_m, "
        "so that the others place it",
        b.name);
  }

  [[nodiscard]] Prior timing_prior() const { return {site().timing.delay_s, site().timing.delay_sigma_s}; }

  void tell_delay(const std::string& whose, const Prior& stated, double found_s, Contradiction& c) const {
    c.kind = ContradictionKind::kDelay;
    c.subject = whose;
    c.stated = fmt::format("{}, sigma {}", time(stated.value), time(stated.sigma));
    c.found = time(found_s);
    c.remedy = fmt::format(
        "look at the electronics of {} and at what stands before it, or state a larger delay_sigma_s "
        "(timing, or the beacon)",
        whose);
  }

  void tell_delays(const SharedState& state, Contradiction& c) const {
    double least = INFINITY, most = -INFINITY;
    for (std::size_t b = 0; b < state.beacon_delay_s.size(); ++b) {
      if (!now_.beacon_usable[b]) continue;
      least = std::min(least, state.beacon_delay_s[b]);
      most = std::max(most, state.beacon_delay_s[b]);
    }
    c.kind = ContradictionKind::kDelay;
    c.subject = "all beacons";
    const bool own = std::any_of(site().beacons.begin(), site().beacons.end(),
                                 [](const SiteBeacon& b) { return b.delay_s.has_value(); });
    c.stated = own                       ? std::string("delays of the beacons, held fixed (delay_sigma_s: 0)")
               : stated_delay_s() == 0.0 ? std::string("no delay (timing.delay_per: none)")
                                         : "a delay of exactly " + time(stated_delay_s());
    c.found = fmt::format("delays from {} to {}", time(least), time(most));
    c.remedy = "state the delay in the site file: timing.delay_per: beacon, with delay_s and delay_sigma_s";
  }

  void tell_speed(const Statement& s, Contradiction& c) const {
    const Medium& medium = site().medium;
    double offset = now_.state().speed_offset(s.index), model = 0.0, degC = 0.0;
    std::size_t count = 0;
    for (const Trajectory& t : now_.trajectories) {
      if (stated_.speed.size() > 1 && t.run != s.index) continue;
      for (const ArrivalObservation& a : t.arrivals) {
        model += a.model_speed_mps;
        ++count;
        const MeasurementLog& run = whole_.runs[t.run];
        degC += a.arrival < run.arrivals.size() ? temperature_of(run.arrivals[a.arrival], run, site())
                                                : medium.temperature_degC;
      }
    }
    const double n = static_cast<double>(std::max<std::size_t>(count, 1));
    model /= n;
    degC /= n;
    const bool has_temperature = medium.model != MediumModel::kConstant;
    c.kind = ContradictionKind::kSpeed;
    c.subject = stated_.speed.size() > 1 ? fmt::format("in run {}", s.index + 1) : "";
    c.stated = fmt::format("{:.2f} m/s, sigma {:.2g} m/s", model, site().speed_sigma_mps) +
               (has_temperature ? fmt::format(", at {:.1f} degC", degC) : "");
    c.found = fmt::format("{:.2f} m/s", model + offset);
    c.remedy = "check medium.speed_mps, or state a larger medium.sigma_mps";
    if (!has_temperature) return;
    c.remedy =
        "check the thermometer: the temperature in the site file, in run.yaml and in the recording (degrees "
        "Celsius); or state a larger medium.sigma_mps";
    if (const auto would_be = temperature_at(medium, model + offset))
      c.found += fmt::format(", as at {:.1f} degC", *would_be);
    const double celsius = (degC - 32) / 1.8;
    if (celsius < -50 || celsius > 60) return;
    const double slack = 3 * std::max(site().speed_sigma_mps, 0.5);
    if (std::abs(speed_mps(medium, celsius) - model - offset) > slack) return;
    c.found += fmt::format(": the temperature is in degrees Fahrenheit ({:.1f} degF are {:.1f} degC)", degC,
                           celsius);
    c.remedy = "write the temperature in degrees Celsius: the thermometer's is in Fahrenheit";
  }

  static std::optional<double> temperature_at(const Medium& medium, double speed) {
    double low = -60, high = 60;
    if (!(speed_mps(medium, low) < speed && speed < speed_mps(medium, high))) return {};
    for (int i = 0; i < 40; ++i)
      (speed_mps(medium, 0.5 * (low + high)) < speed ? low : high) = 0.5 * (low + high);
    return 0.5 * (low + high);
  }

  void tell_receiver(const Statement& s, const SharedState& state, Contradiction& c) const {
    const SiteReceiver& r = site().receivers[s.index];
    c.kind = ContradictionKind::kReceiver;
    c.subject = receiver_name(s.index);
    c.stated =
        fmt::format("at {} on the vehicle, sigma {}", point(r.position_m), length(r.sigma_m.maxCoeff()));
    c.found = fmt::format("at {}, {} away", point(state.receiver_p_vehicle_m[s.index]),
                          length((state.receiver_p_vehicle_m[s.index] - r.position_m).norm()));
    c.remedy = fmt::format(
        "measure the place of receiver {} on the vehicle again and write it into the site file", r.name);
  }

  void tell_attenuation(const Statement& s, Contradiction& c) const {
    const int column = now_.layout.attenuation[s.index];
    const Parameter& p = stated_.parameters[static_cast<std::size_t>(stated_.attenuation[s.index])];
    c.kind = ContradictionKind::kAttenuation;
    c.subject = parameter_name(p.id, names_of(site()));
    c.stated =
        fmt::format("{:.4g}, sigma {:.2g}", p.prior_mean * p.si_per_unit, p.prior_sigma * p.si_per_unit);
    c.found = fmt::format("{:.4g}", now_.x[column] * p.si_per_unit);
    c.remedy = fmt::format("check {} in the site file, or state a larger sigma", c.subject);
  }

  void tell_distance(const Statement& s, const SharedState& state, Contradiction& c) const {
    const ControlDistance& d = site().distances[s.index];
    c.kind = ContradictionKind::kDistance;
    c.subject = site().beacons[d.from.index()].name + ", " + site().beacons[d.to.index()].name;
    c.stated = fmt::format("{:.4f} m, sigma {}", d.distance_m, length(d.sigma_m));
    c.found = fmt::format("{:.4f} m",
                          (state.beacon_p_map_m[d.from.index()] - state.beacon_p_map_m[d.to.index()]).norm());
    c.remedy = fmt::format("tape the distance from {} to {} again", site().beacons[d.from.index()].name,
                           site().beacons[d.to.index()].name);
  }

  /// Two control points that were found at each other's places.
  void join_exchanged(const std::vector<Culprit>& culprits, std::vector<Contradiction>& found) const {
    const SharedState state = now_.state();
    const auto place = [&](std::size_t b) {
      return Eigen::Vector3d(*site().beacons[b].position_m[0], *site().beacons[b].position_m[1],
                             *site().beacons[b].position_m[2]);
    };
    for (std::size_t i = 0; i < culprits.size(); ++i)
      for (std::size_t j = i + 1; j < culprits.size(); ++j) {
        if (culprits[i].statement.what != What::kControlPoint ||
            culprits[j].statement.what != What::kControlPoint)
          continue;
        const std::size_t a = culprits[i].statement.index, b = culprits[j].statement.index;
        const double near = 0.1 * (place(a) - place(b)).norm();
        if ((state.beacon_p_map_m[a] - place(b)).norm() > near ||
            (state.beacon_p_map_m[b] - place(a)).norm() > near)
          continue;
        Contradiction& c = found[i];
        c.kind = ContradictionKind::kExchanged;
        c.subject = site().beacons[a].name + ", " + site().beacons[b].name;
        c.stated = fmt::format("at {} and {}", point(place(a)), point(place(b)));
        c.found = "at each other's places";
        c.remedy = fmt::format(
            "exchange the positions of control points {} and {} in the site file, or their labels on the "
            "wall",
            site().beacons[a].name, site().beacons[b].name);
        found.erase(found.begin() + static_cast<std::ptrdiff_t>(j));
        return;
      }
  }

  const Problem& whole_;
  const SolveOptions& options_;
  const ParameterLayout& stated_;
  Fit now_;  ///< all that was released stays so
  std::vector<Statement> all_, released_;
};

}  // namespace

StatementFindings test_statements(const Problem& problem, const SolveOptions& options,
                                  const Estimate& estimate, const std::vector<Trajectory>& trajectories) {
  if (!is_dense(estimate.layout) || estimate.x.size() == 0) return {};
  return StatementTest(problem, options, estimate, trajectories).run();
}

}  // namespace octant::calib
