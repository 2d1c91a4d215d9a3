// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/clocks/clock_findings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "models/changes/chi_square.h"

namespace octant::calib {
namespace {

/// Size of a step in its own sigmas from which it is a candidate. A fit with the step decides.
constexpr double kCandidate = 6.0;
/// Receptions on each side of a step.
constexpr std::size_t kLeastSide = 4;
/// Significance of a finding, over everything that is tested.
constexpr double kSignificance = 1e-4;
/// Scale of Cauchy's loss, in sigmas.
constexpr double kLossScale = 3.0;
/// Efficiency of a median: its sigma relative to that of a mean.
constexpr double kMedianSigma = 1.2533;

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Residuals of a clock in a run, by time.
using ClockSeries = std::vector<std::pair<double, double>>;

/// Largest step of the median in a series, in sigmas, and its time.
std::pair<double, double> step_in(const ClockSeries& series) {
  std::pair<double, double> best{0.0, 0.0};
  constexpr std::size_t kMostTimes = 200;
  const std::size_t stride = series.size() / kMostTimes + 1;
  for (std::size_t k = kLeastSide; k + kLeastSide <= series.size(); k += stride) {
    if (series[k].first == series[k - 1].first) continue;
    std::vector<double> before, after;
    for (std::size_t i = 0; i < series.size(); ++i) (i < k ? before : after).push_back(series[i].second);
    const double sigma = kMedianSigma * std::sqrt(1.0 / static_cast<double>(before.size()) +
                                                  1.0 / static_cast<double>(after.size()));
    const double size = std::abs(median_of(std::move(after)) - median_of(std::move(before))) / sigma;
    if (size > best.first) best = {size, series[k].first};
  }
  return best;
}

/// One assumption about the beacons other than the stated one.
struct PlaceHypothesis {
  std::size_t a = 0, b = 0;  ///< equal: the beacon is released
  ClockProblem problem;
  ClockFit fit;
};

class PlaceTests {
 public:
  PlaceTests(ClockProblem start, const Eigen::VectorXd& x) : stated_{0, 0, std::move(start), {}} {
    stated_.fit = adjusted(stated_.problem, x);
  }

  std::optional<Contradiction> find() {
    const std::size_t n = stated_.problem.site.beacons.size();
    for (std::size_t a = 0; a < n; ++a) {
      if (!is_stated(a)) continue;
      consider(a, a);
      for (std::size_t b = 0; b < a; ++b)
        if (is_stated(b)) consider(b, a);
    }
    if (!best_) return {};
    // Both are compared with the noise that the receptions show under the better one.
    const double share = best_->problem.sigma_m * robust_sigma(best_->problem, best_->fit.x);
    for (PlaceHypothesis* h : {&stated_, &*best_}) {
      h->problem.sigma_m = share;
      h->fit = adjusted(h->problem, h->fit.x);
    }
    const double gain = stated_.fit.cost - best_->fit.cost;
    const int dof = best_->a == best_->b ? 3 : 1;
    const double limit = 0.5 * chi_square_beyond(kSignificance / static_cast<double>(tests_), dof);
    if (gain < limit) return {};
    return words(std::sqrt(2.0 * gain));
  }

 private:
  static ClockFit adjusted(const ClockProblem& problem, const Eigen::VectorXd& x) {
    return adjust_clocks(problem, adjust_clocks(problem, x, 10 * kLossScale, 20).x, kLossScale, 40);
  }

  [[nodiscard]] bool is_stated(std::size_t b) const {
    const ClockProblem& p = stated_.problem;
    const SiteBeacon& beacon = p.site.beacons[b];
    for (std::size_t i = 0; i < 3; ++i)
      if (!beacon.position_m[i] || !(beacon.sigma_m[i].value_or(INFINITY) < 0.1 * p.extent_m)) return false;
    return true;
  }

  void consider(std::size_t a, std::size_t b) {
    ++tests_;
    PlaceHypothesis h{a, b, stated_.problem, {}};
    Eigen::VectorXd x = stated_.fit.x;
    SiteBeacon &first = h.problem.site.beacons[a], &second = h.problem.site.beacons[b];
    if (a == b) {
      for (auto& sigma_m : first.sigma_m) sigma_m = h.problem.extent_m;
    } else {
      std::swap(first.position_m, second.position_m);
      std::swap(first.sigma_m, second.sigma_m);
      const Eigen::VectorXd prior = prior_values(h.problem);
      for (const std::size_t k : {a, b})
        x.segment<3>(h.problem.beacon(k)) = prior.segment<3>(h.problem.beacon(k));
    }
    h.fit = adjusted(h.problem, x);
    if (!best_ || h.fit.cost < best_->fit.cost) best_ = std::move(h);
  }

  [[nodiscard]] Contradiction words(double sigmas) const {
    const SiteBeacon &a = stated_.problem.site.beacons[best_->a], &b = stated_.problem.site.beacons[best_->b];
    const auto at = [](const Eigen::Vector3d& p) {
      return fmt::format("at ({:.2f}, {:.2f}, {:.2f}) m", p.x(), p.y(), p.z());
    };
    if (best_->a != best_->b)
      return {ContradictionKind::kExchanged,
              a.name + ", " + b.name,
              fmt::format("{} {}, {} {}", a.name, at(*a.place_m()), b.name, at(*b.place_m())),
              "the other way round",
              sigmas,
              "check the ids of the two beacons, or exchange their positions in the site file"};
    const Eigen::Vector3d found_m = best_->fit.x.segment<3>(best_->problem.beacon(best_->a));
    return {a.is_control_point() ? ContradictionKind::kControlPoint : ContradictionKind::kBeacon,
            a.name,
            at(*a.place_m()),
            at(found_m),
            sigmas,
            "survey this beacon again, or state a larger sigma_m"};
  }

  PlaceHypothesis stated_;
  std::optional<PlaceHypothesis> best_;
  std::size_t tests_ = 0;
};

}  // namespace

std::optional<ClockJump> jump_in(const ClockProblem& problem, const ClockFit& fit) {
  std::map<std::pair<int, int>, ClockSeries> series;
  for (const ClockRow& row : rows_at(problem, fit.x)) {
    if (row.kind != ClockRowKind::kReception) continue;
    const ClockReception& r = problem.receptions[row.index];
    series[{r.run, problem.clocks.of_device[r.to.index()]}].emplace_back(r.time_s, row.residual);
  }
  ClockJump best;
  double size = kCandidate;
  for (auto& [key, of_clock] : series) {
    std::ranges::sort(of_clock);
    const auto [sigmas, time_s] = step_in(of_clock);
    if (sigmas > size) size = sigmas, best = {key.first, key.second, time_s};
    // A clock that walks between its knots absorbs a small step there.
    const std::vector<double>& knots = problem.knots_s[static_cast<std::size_t>(key.first)];
    for (std::size_t k = 0; problem.clocks.is_free && k + 1 < knots.size(); ++k) {
      const int a = problem.knot(static_cast<std::size_t>(key.first), key.second, k), b = a + 2;
      const double h = knots[k + 1] - knots[k];
      const double walked = std::abs(fit.x[b] - fit.x[a] - h * fit.x[a + 1]) /
                            std::sqrt(problem.phase_walk_m2 * h + problem.rate_walk_m2 * h * h * h / 3);
      if (walked > size) size = walked, best = {key.first, key.second, 0.5 * (knots[k] + knots[k + 1])};
    }
  }
  if (size <= kCandidate) return {};
  return best;
}

std::optional<Contradiction> wrong_position(ClockProblem start, Eigen::VectorXd x, double sigma_m) {
  start.sigma_m = sigma_m;
  return PlaceTests(std::move(start), x).find();
}

}  // namespace octant::calib
