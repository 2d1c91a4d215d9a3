// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/statement.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "calib/adjust/information.h"
#include "calib/adjust/priors.h"
#include "calib/problem/log_totals.h"

namespace octant::calib {

std::vector<int> columns_of(const Statement& s, const ParameterLayout& layout) {
  std::vector<int> columns;
  const auto add = [&](int c) {
    if (c >= 0) columns.push_back(c);
  };
  switch (s.what) {
    case What::kControlPoint:
      for (const int c : layout.beacon[s.index]) add(c);
      break;
    case What::kPlace:
      for (const int c : layout.beacon[s.index])
        if (c >= 0 && std::isfinite(layout.parameter(c).prior_sigma)) add(c);
      break;
    case What::kBeaconDelay: add(layout.column_of(parameters::beacon_delay(s.index))); break;
    case What::kReceiverDelay: add(layout.column_of(parameters::receiver_delay(s.index))); break;
    case What::kSiteDelay: add(layout.column_of(parameters::site_delay())); break;
    case What::kNoDelays:
    case What::kOneDelay:
    case What::kDelays:
      for (std::size_t b = 0; b < layout.beacon.size(); ++b)
        add(layout.column_of(parameters::beacon_delay(b)));
      break;
    case What::kSpeed: add(layout.speed[s.index]); break;
    case What::kHeldSpeed:
      for (const int c : layout.speed) add(c);
      break;
    case What::kReceiver:
      for (const int c : layout.receiver[s.index]) add(c);
      break;
    case What::kAttenuation: add(layout.column_of(parameters::attenuation(s.index))); break;
    case What::kDistance:
    case What::kHeights:
    case What::kLabels: break;
  }
  return columns;
}

namespace {

/// Limits for suspects, before any new adjustment: significance, and share of rejected arrivals of a control
/// point.
constexpr double kSuspectStatementSigmas = 4.0;
constexpr double kMostlyLeftOut = 0.3;
constexpr std::size_t kMostSuspects = 8;

/// Returns true if the parameter has a prior.
bool has_prior(const Parameter& p) { return std::isfinite(p.prior_sigma); }

/// Deviations of a fit from what is assumed, by its normal equations.
class SuspectSearch {
 public:
  SuspectSearch(const StatedSite& stated, const Fit& fit, const std::vector<Statement>& released, int threads)
      : stated_(stated), fit_(fit), released_(released), threads_(threads), all_(stated.all()) {}

  [[nodiscard]] std::vector<Suspect> run() const {
    std::vector<Statement> held;
    for (const Statement& s : all_)
      if (!is_released(s, released_) && is_held(s)) held.push_back(s);
    std::vector<Statement> loose = released_;
    loose.insert(loose.end(), held.begin(), held.end());
    Problem problem = fit_.problem;
    const ParameterLayout wide = stated_.layout_without(loose, fit_.state(), problem);
    std::vector<Trajectory> trajectories = fit_.trajectories;
    const Eigen::VectorXd x = wide.vector_of(fit_.state());
    const SharedState state = wide.state_of(x);
    const Information information = information_at(problem, wide, trajectories, x, {.threads = threads_});
    const double noise2 = std::max(1e-12, fit_.noise_factor * fit_.noise_factor);
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
      if (is_released(s, released_)) continue;
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

 private:
  /// lambda' C^+ lambda as a normal deviate. Directions that the data do not determine do not count.
  static double released_sigmas(const Eigen::MatrixXd& C_lambda, const Eigen::VectorXd& lambda) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(C_lambda);
    Difference d;
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
    const PriorRow row = distance_row(stated_.site().distances[index], layout, state);
    Eigen::VectorXd a = Eigen::VectorXd::Zero(C.rows());
    for (const auto& [column, value] : row.entries)
      if (const int c = place[static_cast<std::size_t>(column)]; c >= 0) a[c] += value;
    const double variance = 1.0 - a.dot(C * a);
    return variance > 0.01 ? std::abs(row.residual) / std::sqrt(variance) : 0.0;
  }

  /// Returns true for a control point most of whose arrivals were rejected, so that its innovation is not
  /// informative.
  [[nodiscard]] bool is_mostly_left_out(const Statement& s) const {
    if (!is_place(s)) return false;
    const RejectionCounts counts =
        rejections_by_beacon(fit_.trajectories, fit_.beacon_usable.size())[s.index];
    const std::size_t placed = counts.all() - counts.of(Rejection::kNoPose);
    return placed >= 10 &&
           static_cast<double>(counts.outliers()) > kMostlyLeftOut * static_cast<double>(placed);
  }

  const StatedSite& stated_;
  const Fit& fit_;
  const std::vector<Statement>& released_;
  int threads_;
  std::vector<Statement> all_;
};

}  // namespace

double Difference::squares() const {
  const double t2 = v.size() == 0 ? 0.0 : v.dot(covariance.ldlt().solve(v));
  return std::isfinite(freedoms) ? freedoms * std::log1p(std::max(0.0, t2) / freedoms) : t2;
}

double Difference::sigmas() const {
  const double n = static_cast<double>(v.size()), s = squares();
  if (!(s > 0) || !std::isfinite(s)) return 0.0;
  return n == 1 ? std::sqrt(s) : std::max(0.0, std::sqrt(s) - std::sqrt(n - 1));
}

bool is_released(const Statement& s, const std::vector<Statement>& released) {
  return std::ranges::any_of(released, [&](const Statement& r) {
    return r == s || (is_place(s) && r.what == What::kLabels && (r.index == s.index || r.other == s.index));
  });
}

std::vector<Suspect> StatedSite::suspects(const Fit& fit, const std::vector<Statement>& released,
                                          int threads) const {
  return SuspectSearch(*this, fit, released, threads).run();
}

bool has_heights(const Site& site) {
  return std::ranges::any_of(site.beacons,
                             [](const SiteBeacon& b) { return b.position_m[2].value_or(0.0) != 0.0; });
}

std::optional<Statement> StatedSite::exchange_of(const Statement& s, const Eigen::Vector3d& found_m) const {
  constexpr double kNear = 0.1;  // share of the distance of the two positions
  const Eigen::Index axes = site().motion == Motion::kPlanar ? 2 : 3;
  if (!is_place(s) || !site().beacons[s.index].place_m()) return {};
  const Eigen::Vector3d own_m = *site().beacons[s.index].place_m();
  for (const Statement& other : all()) {
    const auto place_m = site().beacons[other.index].place_m();
    if (is_place(other) && place_m &&
        (found_m - *place_m).head(axes).norm() < kNear * (own_m - *place_m).head(axes).norm())
      return Statement{What::kLabels, std::min(s.index, other.index), std::max(s.index, other.index)};
  }
  return {};
}

void turn_heights(Site& site) {
  for (SiteBeacon& b : site.beacons)
    if (b.position_m[2]) b.position_m[2] = -*b.position_m[2];
}

SharedState StatedSite::with_alternative(const Statement& s, SharedState state) const {
  if (s.what == What::kLabels) std::swap(state.beacon_p_map_m[s.index], state.beacon_p_map_m[s.other]);
  // From its last position a beacon might not pass the plane of the receivers.
  for (std::size_t b = 0; b < site().beacons.size() && s.what == What::kHeights; ++b)
    if (const auto& z_m = site().beacons[b].position_m[2]) state.beacon_p_map_m[b].z() = -*z_m;
  return state;
}

std::vector<Statement> StatedSite::all() const {
  const Site& s = site();
  const auto is_free = [this](const ParameterId& id) { return layout_.column_of(id) >= 0; };
  std::vector<Statement> stated;
  for (std::size_t b = 0; b < s.beacons.size(); ++b) {
    if (s.beacons[b].is_control_point() && beacon_usable_[b]) stated.push_back({What::kControlPoint, b});
    if (!columns_of({What::kPlace, b}, layout_).empty()) stated.push_back({What::kPlace, b});
    if (is_free(parameters::beacon_delay(b))) stated.push_back({What::kBeaconDelay, b});
  }
  for (std::size_t r = 0; r < s.receivers.size(); ++r) {
    if (is_free(parameters::receiver_delay(r))) stated.push_back({What::kReceiverDelay, r});
    if (std::max({layout_.receiver[r][0], layout_.receiver[r][1], layout_.receiver[r][2]}) >= 0)
      stated.push_back({What::kReceiver, r});
  }
  if (is_free(parameters::site_delay())) stated.push_back({What::kSiteDelay, 0});
  const bool has_delay = largest_delay_sigma_s(s) > 0;
  if (!has_delay && s.timing.clock == Clock::kSynchronised && s.tof_sigma_given)
    stated.push_back({What::kNoDelays, 0});
  for (std::size_t run = 0; run < layout_.speed.size(); ++run) stated.push_back({What::kSpeed, run});
  for (std::size_t i = 0; i < kAttenuationUnknowns; ++i)
    if (is_free(parameters::attenuation(i))) stated.push_back({What::kAttenuation, i});
  for (std::size_t d = 0; d < s.distances.size(); ++d) stated.push_back({What::kDistance, d});
  return stated;
}

std::vector<Statement> StatedSite::common_causes() const {
  std::vector<Statement> causes;
  const Timing& timing = site().timing;
  const bool has_delays = timing.clock == Clock::kSynchronised && largest_delay_sigma_s(site()) > 0;
  if (has_delays && timing.delay_per.beacon) causes.push_back({What::kDelays, 0});
  if (has_delays && timing.delay_per.site && !timing.delay_per.beacon) causes.push_back({What::kOneDelay, 0});
  if (layout_.speed.empty()) causes.push_back({What::kHeldSpeed, 0});
  return causes;
}

/// Sigma of a released parameter: so wide that only the data determine it, but finite, so that parameters
/// that they do not determine keep their value.
double StatedSite::wide_sigma(const Statement& s) const {
  switch (s.what) {
    case What::kSpeed:
    case What::kHeldSpeed: return 0.3;
    case What::kReceiver: return 1.0;
    case What::kAttenuation: return 10.0;
    default: return problem_.typical_range_m;
  }
}

/// Maximum number of parameters for dense matrices in refits; the tests of assumptions form these anyway.
constexpr int kDenseRefit = 1000;
/// Any positive value, because the prior is widened afterwards.
constexpr double kReleasedSpeed_mps = 30.0;

namespace {

/// Two beacons at each other's positions, both with the larger sigma, because each line of the site file may
/// be that of either beacon.
void exchange(SiteBeacon& a, SiteBeacon& b) {
  std::swap(a.position_m, b.position_m);
  for (std::size_t i = 0; i < 3; ++i) a.sigma_m[i] = b.sigma_m[i] = std::max(a.sigma_m[i], b.sigma_m[i]);
}

}  // namespace

ParameterLayout StatedSite::layout_without(const std::vector<Statement>& released, const SharedState& state,
                                           Problem& problem) const {
  problem.site = site();
  std::vector<std::size_t> distances;
  Timing& timing = problem.site.timing;
  for (const Statement& s : released) {
    if (s.what == What::kControlPoint) problem.site.beacons[s.index].sigma_m = {};
    if (s.what == What::kHeldSpeed) problem.site.speed_sigma_mps = kReleasedSpeed_mps;
    if (s.what == What::kDistance) distances.push_back(s.index);
    if (s.what == What::kOneDelay) timing.delay_per.beacon = true;
    if (s.what == What::kLabels) exchange(problem.site.beacons[s.index], problem.site.beacons[s.other]);
    if (s.what == What::kHeights) turn_heights(problem.site);
    if (s.what != What::kNoDelays) continue;
    timing.delay_per = {.beacon = true};
    timing.delay_sigma_s = 1.0;
    for (SiteBeacon& b : problem.site.beacons) b.delay_sigma_s.reset();
  }
  std::sort(distances.rbegin(), distances.rend());
  for (const std::size_t d : distances)
    problem.site.distances.erase(problem.site.distances.begin() + static_cast<std::ptrdiff_t>(d));
  ParameterLayout layout = make_layout(problem, state, beacon_usable_);
  layout.dense_limit = std::max(layout_.dense_limit, kDenseRefit);
  // Priors of the calibration's layout, in which labels were corrected, unless an alternative replaces them.
  for (std::size_t b = 0; b < layout.beacon.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i)
      if (const int old = layout_.beacon[b][i], c = layout.beacon[b][i];
          old >= 0 && c >= 0 && problem.site.beacons[b].position_m[i] == site().beacons[b].position_m[i])
        layout.parameter(c) = layout_.parameter(old);
  for (const Statement& s : released)
    for (const int c : columns_of(s, layout)) {
      Parameter& p = layout.parameter(c);
      p.prior_mean = s.what == What::kControlPoint ? *problem.site.beacons[s.index].position_m[p.id.component]
                                                   : value(s, layout, c);
      p.prior_sigma = wide_sigma(s);
    }
  return layout;
}

double StatedSite::value(const Statement& s, const ParameterLayout& layout, int column) const {
  const Parameter& p = layout.parameter(column);
  // The delay's prior mean then applies to the beacons.
  if (s.what == What::kOneDelay) return beacon_delay_prior(site(), p.id.owner).value / p.si_per_unit;
  // If receivers or the site have the delay, the delays of the beacons are added to it.
  if (s.what == What::kNoDelays)
    return site().timing.delay_per.beacon ? beacon_delay_prior(site(), p.id.owner).value / p.si_per_unit
                                          : 0.0;
  return p.prior_mean;
}

double StatedSite::sigma(const Statement& s, const ParameterLayout& layout, int column) const {
  const ParameterId& id = layout.parameter(column).id;
  if (is_held(s)) return 0.0;
  for (const Parameter& p : layout_.parameters)
    if (p.id == id) return p.prior_sigma;
  return 0.0;
}

}  // namespace octant::calib
