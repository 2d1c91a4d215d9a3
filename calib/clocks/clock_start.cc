// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "calib/clocks/clock_fit.h"

namespace octant::calib {
namespace {

/// Number of starts, and of solutions that agree with the best one after which the search ends.
constexpr int kStarts = 48, kAgreeing = 4;
/// Solutions whose beacons and points are this close, in extents, are the same.
constexpr double kSamePlace = 0.01;
/// Costs c that differ by less than kSameFit (1 + kSameFit c) are the same.
constexpr double kSameFit = 0.1;
/// Places that are tried for a point.
constexpr int kCandidates = 120;
/// Scales of the robust loss, in extents of the site, from coarse to fine; then kFine sigmas.
constexpr std::array<double, 2> kCoarse = {0.3, 0.05};
constexpr double kFine = 3.0;
/// Scale of the loss for the search of single points, in extents.
constexpr double kPlaceShare = 0.02;

class ClockStarter {
 public:
  explicit ClockStarter(const ClockProblem& problem)
      : p_(problem), prior_(prior_values(problem)), receptions_(problem.points.size()) {
    for (std::size_t i = 0; i < p_.receptions.size(); ++i)
      if (p_.receptions[i].point >= 0)
        receptions_[static_cast<std::size_t>(p_.receptions[i].point)].push_back(i);
  }

  ClockStart search(const std::function<bool(int)>& proceed) {
    ClockStart best;
    std::vector<ClockFit> fits;
    for (int k = 0; k < kStarts && best.agreeing < kAgreeing && proceed(k); ++k) {
      fits.push_back(solved(start_values(k)));
      const ClockFit& fit = fits.back();
      if (fit.cost < best.cost) best.x = fit.x, best.cost = fit.cost;
      best.starts = k + 1;
      best.agreeing = 0;
      for (const ClockFit& other : fits)
        best.agreeing += other.cost < best.cost + kSameFit * (1.0 + kSameFit * best.cost) &&
                         distance_m(other.x, best.x) < same_m();
    }
    for (const ClockFit& other : fits) {
      const double away_m = distance_m(other.x, best.x);
      if (away_m < same_m() || other.cost - best.cost >= best.rival_cost.value_or(INFINITY)) continue;
      best.rival_cost = other.cost - best.cost;
      best.rival_m = away_m;
    }
    return best;
  }

  /// Searches each point whose place follows from its receptions alone, for given beacons and clocks.
  void place_points(Eigen::VectorXd& x, double scale_m) {
    std::vector<bool> is_free(p_.points.size(), true);
    for (const ClockMotion& m : p_.motions) is_free[m.from] = is_free[m.to] = false;
    for (std::size_t i = 0; i < p_.points.size(); ++i) {
      if (!is_free[i] || p_.points[i].measured_m) continue;
      const Eigen::Vector3d at = x.segment<3>(p_.point(i));
      Eigen::Vector3d best = at;
      double least = point_cost(x, i, at, scale_m);
      for (int k = 0; k < kCandidates; ++k) {
        Eigen::Vector3d candidate = p_.centre_m;
        for (int axis = 0; axis < 3; ++axis) candidate[axis] += 0.6 * p_.extent_m * (uniform_(random_) - 0.5);
        if (p_.site.motion == Motion::kPlanar) candidate.z() = at.z();
        if (k >= kCandidates / 2)  // near the best one
          candidate = best + (candidate - p_.centre_m) * std::pow(0.5, 1 + k % 6);
        const double cost = point_cost(x, i, candidate, scale_m);
        if (cost < least) least = cost, best = candidate;
      }
      x.segment<3>(p_.point(i)) = best;
    }
  }

 private:
  [[nodiscard]] double same_m() const { return kSamePlace * p_.extent_m + 3.0 * p_.sigma_m; }

  /// Largest displacement of a beacon.
  [[nodiscard]] double distance_m(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    double far_m = 0.0;
    for (std::size_t i = 0; i < p_.site.beacons.size(); ++i)
      far_m = std::max(far_m, (a - b).segment<3>(p_.beacon(i)).norm());
    return far_m;
  }

  /// Robust cost of the receptions of a point at a place, with the best times of transmission.
  [[nodiscard]] double point_cost(const Eigen::VectorXd& x, std::size_t point, const Eigen::Vector3d& place,
                                  double scale_m) const {
    double cost = 0.0;
    std::vector<double> errors;
    const std::vector<std::size_t>& of_point = receptions_[point];
    for (std::size_t i = 0; i < of_point.size(); ++i) {
      const ClockReception& r = p_.receptions[of_point[i]];
      const DeviceId beacon = p_.is_beacon(r.to) ? r.to : r.from;
      if (p_.is_beacon(beacon))
        errors.push_back(r.range_m - (x.segment<3>(p_.beacon(beacon.index())) - place).norm() -
                         offset_m(x, r));
      if (i + 1 < of_point.size() && p_.receptions[of_point[i + 1]].transmission == r.transmission) continue;
      if (errors.empty()) continue;
      const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
      std::ranges::nth_element(errors, middle);
      const double sent_m = *middle;
      for (const double e : errors) cost += std::log1p(std::pow((e - sent_m) / scale_m, 2));
      errors.clear();
    }
    return cost;
  }

  /// Offset of a receiver's clock and delay.
  [[nodiscard]] double offset_m(const Eigen::VectorXd& x, const ClockReception& r) const {
    double offset_m = p_.is_beacon(r.to) ? x[p_.delay(r.to.index())] : 0.0;
    if (!p_.clocks.is_free) return offset_m;
    const auto run = static_cast<std::size_t>(r.run);
    const std::vector<double>& knots = p_.knots_s[run];
    const auto after = std::ranges::lower_bound(knots, r.time_s) - knots.begin();
    const auto k = static_cast<std::size_t>(std::min<std::ptrdiff_t>(after, std::ssize(knots) - 1));
    const int at = p_.knot(run, p_.clocks.of_device[r.to.index()], k);
    return offset_m + x[at] + x[at + 1] * (r.time_s - knots[k]);
  }

  [[nodiscard]] ClockFit solved(Eigen::VectorXd x) {
    ClockFit fit;
    for (const double share : kCoarse) {
      const double scale_m = std::max(share * p_.extent_m, kFine * p_.sigma_m);
      place_points(x, scale_m);
      fit = adjust_clocks(p_, std::move(x), scale_m / p_.sigma_m, 15);
      x = std::move(fit.x);
    }
    place_points(x, std::max(kPlaceShare * p_.extent_m, kFine * p_.sigma_m));
    return adjust_clocks(p_, std::move(x), kFine, 60);
  }

  /// Random values of what the priors leave open. The first start has the prior means of the beacons.
  Eigen::VectorXd start_values(int k) {
    Eigen::VectorXd x = prior_;
    const auto normal = [this] { return normal_(random_); };
    for (std::size_t b = 0; b < p_.site.beacons.size(); ++b)
      for (std::size_t i = 0; i < 3; ++i) {
        const SiteBeacon& beacon = p_.site.beacons[b];
        const double sigma_m = beacon.position_m[i] ? beacon.sigma_m[i].value_or(0.3) : INFINITY;
        const bool is_known = sigma_m < 0.1 * p_.extent_m;
        if (!is_known || (k > 0 && sigma_m > 0.0))
          x[p_.beacon(b) + static_cast<int>(i)] += std::min(sigma_m, 0.3 * p_.extent_m) * normal();
      }
    add_points(x);
    return x;
  }

  /// Points: chains of motions from a random place, others at random.
  void add_points(Eigen::VectorXd& x) {
    const auto normal = [this] { return normal_(random_); };
    std::vector<bool> chained(p_.points.size(), false);
    for (const ClockMotion& m : p_.motions) chained[m.to] = true;
    const double turn = p_.frame_turns || p_.heading_is_free ? 2 * M_PI * uniform_(random_) : 0.0;
    if (p_.frame_turns) x[p_.frame()] = turn;
    for (std::size_t i = 0; i < p_.points.size(); ++i) {
      if (p_.points[i].measured_m || chained[i]) continue;
      const bool is_datum = p_.frame_is_datum && i == 0;
      for (int k = 0; k < 3 && !is_datum; ++k)
        if (k < 2 || p_.site.motion == Motion::kSpatial)
          x[p_.point(i) + k] = p_.centre_m[k] + 0.2 * p_.extent_m * normal();
      if (p_.heading_is_free && !is_datum) x[p_.point(i) + 3] = turn;
    }
    for (const ClockMotion& m : p_.motions) {
      const double h = m.turns ? x[p_.point(m.from) + 3] : x[p_.frame()];
      Eigen::Vector3d step(std::cos(h) * m.step_m.x() - std::sin(h) * m.step_m.y(),
                           std::sin(h) * m.step_m.x() + std::cos(h) * m.step_m.y(), m.step_m.z());
      if (p_.site.motion == Motion::kPlanar) step.z() = 0.0;
      if (!p_.points[m.to].measured_m) x.segment<3>(p_.point(m.to)) = x.segment<3>(p_.point(m.from)) + step;
      x[p_.point(m.to) + 3] = x[p_.point(m.from) + 3] + m.turn_rad;
    }
  }

  const ClockProblem& p_;
  Eigen::VectorXd prior_;
  std::vector<std::vector<std::size_t>> receptions_;  ///< of each point, by transmission
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
};

}  // namespace

ClockStart start_clocks(const ClockProblem& problem, const std::function<bool(int)>& proceed) {
  return ClockStarter(problem).search(proceed);
}

Eigen::VectorXd continued(const ClockProblem& start, const Eigen::VectorXd& x, const ClockProblem& complete) {
  Eigen::VectorXd y = prior_values(complete);
  const auto beacons = static_cast<Eigen::Index>(3 * start.site.beacons.size());
  y.head(beacons) = x.head(beacons);
  for (std::size_t b = 0; b < start.site.beacons.size(); ++b) y[complete.delay(b)] = x[start.delay(b)];
  y[complete.speed()] = x[start.speed()];
  y[complete.frame()] = x[start.frame()];
  // Each point begins at the nearest one in time of the start.
  for (std::size_t i = 0; i < complete.points.size(); ++i) {
    const ClockPoint& point = complete.points[i];
    double nearest_s = INFINITY;
    for (std::size_t k = 0; k < start.points.size(); ++k) {
      const ClockPoint& of_start = start.points[k];
      const double apart_s = std::abs(of_start.time_s - point.time_s);
      if (of_start.run != point.run || of_start.vehicle != point.vehicle || apart_s >= nearest_s) continue;
      nearest_s = apart_s;
      y.segment<4>(complete.point(i)) = x.segment<4>(start.point(k));
    }
  }
  // Clocks by the knots of the start, on the lines of the complete problem.
  for (std::size_t run = 0; run < complete.knots_s.size(); ++run)
    for (int c = 0; c < static_cast<int>(complete.clocks.names.size()) && complete.clocks.is_free; ++c)
      for (std::size_t k = 0; k < complete.knots_s[run].size(); ++k) {
        const double t = complete.knots_s[run][k];
        const auto& knots = start.knots_s[run];
        std::size_t near = 0;
        for (std::size_t j = 0; j < knots.size(); ++j)
          if (std::abs(knots[j] - t) < std::abs(knots[near] - t)) near = j;
        const int from = start.knot(run, c, near), to = complete.knot(run, c, k);
        const auto clock = static_cast<std::size_t>(c);
        const Eigen::Vector2d a = start.lines[run][clock], b = complete.lines[run][clock];
        const double line_s =
            a[0] - b[0] + a[1] * (t - start.middle_s[run]) - b[1] * (t - complete.middle_s[run]);
        y[to] = x[from] + x[from + 1] * (t - knots[near]) + complete.speed_mps * line_s;
        y[to + 1] = x[from + 1] + complete.speed_mps * (a[1] - b[1]);
      }
  // Times of transmission by the median of the receptions.
  std::vector<std::vector<double>> sent(complete.transmissions);
  for (const ClockRow& row : rows_at(complete, y))
    if (row.kind == ClockRowKind::kReception)
      sent[complete.receptions[row.index].transmission].push_back(row.residual * complete.sigma_m);
  for (std::size_t e = 0; e < sent.size(); ++e) {
    if (sent[e].empty()) continue;
    const auto middle = sent[e].begin() + static_cast<std::ptrdiff_t>(sent[e].size() / 2);
    std::ranges::nth_element(sent[e], middle);
    y[complete.sent(e)] += *middle;
  }
  ClockStarter(complete).place_points(y, std::max(kPlaceShare * complete.extent_m, kFine * complete.sigma_m));
  return y;
}

}  // namespace octant::calib
