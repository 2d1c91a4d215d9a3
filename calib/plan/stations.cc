// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/plan/stations.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "calib/adjust/covariance.h"
#include "calib/verdict/datum.h"
#include "models/simulator/random.h"
#include "models/support/decompositions.h"
#include "models/support/parallel.h"

namespace octant::calib {
namespace {

constexpr double kGains = 1.0 + 1e-4;  ///< an exchange has to gain more than rounding
constexpr double kFinestShare = 0.1;   ///< fraction of the grid at which the search around a stop ends
constexpr double kUnobservableByStations =
    1e-10;  ///< relative to the largest: a combination of beacons that the datum fixes
constexpr std::size_t kAtOnce = 16;  ///< candidates that a thread takes

struct Stop {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
};

Eigen::MatrixXd covariance_of_stations(const Knowledge& k, const Eigen::MatrixXd& information) {
  return *Covariance(information, free_datum(k.problem, k.layout, k.state, information)).matrix();
}

BeaconKnowledge knowledge_from(const Knowledge& k, const Eigen::MatrixXd& C) {
  BeaconKnowledge known;
  std::size_t asked = 0;
  for (std::size_t b = 0; b < k.layout.beacon.size(); ++b) {
    if (!k.placed[b]) {
      known.sigma_m.push_back(-1.0);
      continue;
    }
    double variance = 0.0;
    bool free = false;
    for (const int c : k.layout.beacon[b]) {
      if (c < 0) continue;
      free = true;
      variance += std::max(0.0, C(c, c));
    }
    known.sigma_m.push_back(std::sqrt(variance));
    if (!free) continue;
    ++asked;
    known.mean_m += known.sigma_m.back();
    if (known.sigma_m.back() > known.worst_m) {
      known.worst_m = known.sigma_m.back();
      known.worst_beacon = b;
    }
  }
  if (asked > 0) known.mean_m /= static_cast<double>(asked);
  return known;
}

/// Gain of one more stop, with its rows A and the present covariance C:
///
///   C_new = C - C A' (I + A C A')^-1 A C                       (Woodbury)
class Gain {
 public:
  Gain(const Knowledge& k, const Eigen::MatrixXd& information, StationCriterion criterion)
      : C_(covariance_of_stations(k, information)), beacons_(k.layout.beacon_columns()) {
    if (criterion != StationCriterion::kD) return;
    // det(C_bb - W'W) = det(C_bb) det(I - W C_bb^-1 W'), within what C_bb varies in.
    const SymmetricEigen<Eigen::MatrixXd> eigen(C_(beacons_, beacons_).eval());
    const Eigen::VectorXd& values = eigen.eigenvalues();
    const auto observable = (values.array() > kUnobservableByStations * values.maxCoeff()).count();
    whitener_ = values.tail(observable).cwiseSqrt().cwiseInverse().asDiagonal() *
                eigen.eigenvectors().rightCols(observable).transpose();
    volume_ = true;
  }

  /// Reduction of the variance [m2], or of the logarithm of the determinant; zero without rows.
  [[nodiscard]] double of(const StopRows& rows) const {
    if (rows.A.rows() == 0) return 0.0;
    const Eigen::MatrixXd CA = C_(Eigen::all, rows.columns) * rows.A.transpose();
    Eigen::MatrixXd S = rows.A * CA(rows.columns, Eigen::all);
    S.diagonal().array() += 1.0;
    const Eigen::LLT<Eigen::MatrixXd> llt(S);
    const Eigen::MatrixXd W = llt.matrixL().solve(CA(beacons_, Eigen::all).transpose().eval());
    if (!volume_) return W.squaredNorm();
    const Eigen::MatrixXd V = W * whitener_.transpose();
    const DenseLdlt left(Eigen::MatrixXd::Identity(V.rows(), V.rows()) - V * V.transpose());
    return -left.vectorD().array().max(1e-300).log().sum();
  }

 private:
  Eigen::MatrixXd C_, whitener_;
  std::vector<int> beacons_;
  bool volume_ = false;
};

class Planner {
 public:
  Planner(const Knowledge& k, const StationOptions& options)
      : k_(k), options_(options), information_(k.information) {
    for (const Eigen::Vector2d& p : options.places_m)
      for (int h = 0; h < options.headings; ++h)
        candidates_.push_back({p, wrap_angle(2 * M_PI * h / options.headings)});
  }

  Result<StationPlan> run() {
    plan_.candidates = candidates_.size();
    greedy();
    if (stops_.empty() && !plan_.interrupted)
      return fail({.code = Errc::kBadInput,
                   .file = k_.problem.site.path,
                   .found = "no place at which the vehicle would receive enough beacons for a fix",
                   .expected = "places within range of three beacons or more",
                   .advice = "check the range, the area and the beacons' positions"});
    plan_.greedy = beacon_knowledge(k_, information_);
    for (int sweep = 0; sweep < options_.sweeps && !plan_.interrupted; ++sweep)
      if (!exchange_all(sweep)) break;
    return ranked_plan();
  }

  StationPlan assess(const std::vector<Eigen::Vector3d>& stops) {
    for (const Eigen::Vector3d& s : stops) add({s.head<2>(), s[2]});
    return ranked_plan(/*best_first=*/false);
  }

 private:
  [[nodiscard]] StopRows rows_of(const Stop& s) const {
    return stop_rows(k_, s.position_m, s.heading_rad, options_.stop);
  }

  void add(const Stop& s) {
    stops_.push_back(s);
    rows_.push_back(rows_of(s));
    add_information(rows_.back(), information_);
  }

  /// Excludes positions of existing stops, where local errors (an echo, a shadow) would be measured twice.
  [[nodiscard]] bool is_apart(const Stop& s, std::size_t but) const {
    for (std::size_t i = 0; i < stops_.size(); ++i)
      if (i != but && (stops_[i].position_m - s.position_m).norm() < 0.5 * options_.spacing_m) return false;
    return true;
  }

  bool report(double fraction) {
    if (options_.on_progress && !options_.on_progress(fraction)) plan_.interrupted = true;
    return !plan_.interrupted;
  }

  /// Best of all candidates, with all stops but one.
  [[nodiscard]] std::pair<Stop, double> best_candidate(const Gain& gain, std::size_t but) const {
    std::vector<double> gains(candidates_.size(), 0.0);
    for_each_in_chunks(candidates_.size(), kAtOnce, options_.threads, [&](std::size_t i) {
      if (is_apart(candidates_[i], but)) gains[i] = gain.of(rows_of(candidates_[i]));
    });
    const auto best = std::ranges::max_element(gains);
    if (best == gains.end()) return {};
    return {candidates_[static_cast<std::size_t>(best - gains.begin())], *best};
  }

  void greedy() {
    for (int i = 0; i < options_.stations && report(0.4 * i / options_.stations); ++i) {
      const auto [stop, gain] = best_candidate(Gain(k_, information_, options_.criterion), stops_.size());
      if (!(gain > 0)) break;
      add(stop);
    }
  }

  /// Pattern search: a step in both directions of x, y and heading, halved if no step improves.
  void search_around(const Gain& gain, std::size_t but, Stop& stop, double& best) const {
    if (!options_.may_stop) return;
    double step_m = 0.5 * options_.spacing_m, turn = M_PI / std::max(1, options_.headings);
    while (step_m > kFinestShare * options_.spacing_m) {
      Stop better = stop;
      double most = best * kGains;
      for (int way = 0; way < 6; ++way) {
        Stop s = stop;
        const double sign = way % 2 == 0 ? 1.0 : -1.0;
        if (way < 4)
          s.position_m[way / 2] += sign * step_m;
        else
          s.heading_rad = wrap_angle(s.heading_rad + sign * turn);
        if ((way < 4 && !options_.may_stop(s.position_m)) || !is_apart(s, but)) continue;
        if (const double g = gain.of(rows_of(s)); g > most) {
          most = g;
          better = s;
        }
      }
      if (most > best * kGains) {
        stop = better;
        best = most;
      } else {
        step_m /= 2;
        turn /= 2;
      }
    }
  }

  /// Removes one stop after another and places it where it improves most; returns false if there was no
  /// improvement.
  bool exchange_all(int sweep) {
    bool changed = false;
    const auto count = static_cast<double>(stops_.size());
    for (std::size_t i = 0; i < stops_.size(); ++i) {
      if (!report(0.4 + 0.6 * (sweep + static_cast<double>(i) / count) / options_.sweeps)) break;
      Eigen::MatrixXd without = information_;
      add_information(rows_[i], without, -1.0);
      const Gain gain(k_, without, options_.criterion);
      const double now = gain.of(rows_[i]);
      auto [stop, best] = best_candidate(gain, i);
      if (best < now) {
        stop = stops_[i];
        best = now;
      }
      search_around(gain, i, stop, best);
      if (!(best > now * kGains)) continue;
      stops_[i] = stop;
      rows_[i] = rows_of(stop);
      information_ = without;
      add_information(rows_[i], information_);
      ++plan_.exchanges;
      changed = true;
    }
    return changed;
  }

  /// The stops in the order of their gain (or unchanged), with the gain of each.
  StationPlan ranked_plan(bool best_first = true) {
    Eigen::MatrixXd information = k_.information;
    plan_.before = beacon_knowledge(k_, information);
    BeaconKnowledge known = plan_.before;
    std::vector<std::size_t> left(stops_.size());
    for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
    while (!left.empty()) {
      std::size_t next = 0;
      if (best_first) {
        const Gain gain(k_, information, options_.criterion);
        double most = -1.0;
        for (std::size_t i = 0; i < left.size(); ++i)
          if (const double g = gain.of(rows_[left[i]]); g > most) {
            most = g;
            next = i;
          }
      }
      const std::size_t s = left[next];
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(next));
      add_information(rows_[s], information);
      plan_.stations.push_back(describe(s, known, information));
      known = plan_.stations.back().after;
    }
    plan_.after = known;
    return std::move(plan_);
  }

  [[nodiscard]] Station describe(std::size_t s, const BeaconKnowledge& before,
                                 const Eigen::MatrixXd& information) const {
    Station station{.position_m = stops_[s].position_m,
                    .heading_rad = stops_[s].heading_rad,
                    .arrivals = rows_[s].arrivals,
                    .arrival_count = rows_[s].arrival_count,
                    .after = beacon_knowledge(k_, information)};
    double most = -INFINITY;
    for (std::size_t b = 0; b < before.sigma_m.size(); ++b) {
      const double gained = before.sigma_m[b] - station.after.sigma_m[b];
      if (before.sigma_m[b] < 0 || !(gained > most)) continue;
      most = gained;
      station.most_improved = b;
      station.improved_from_m = before.sigma_m[b];
      station.improved_to_m = station.after.sigma_m[b];
    }
    return station;
  }

  const Knowledge& k_;
  const StationOptions& options_;
  std::vector<Stop> candidates_, stops_;
  std::vector<StopRows> rows_;
  Eigen::MatrixXd information_;
  StationPlan plan_;
};

}  // namespace

BeaconKnowledge beacon_knowledge(const Knowledge& knowledge, const Eigen::MatrixXd& information) {
  return knowledge_from(knowledge, covariance_of_stations(knowledge, information));
}

Result<StationPlan> plan_stations(const Knowledge& knowledge, const StationOptions& options) {
  return Planner(knowledge, options).run();
}

StationPlan assess_stations(const Knowledge& knowledge, const std::vector<Eigen::Vector3d>& stops,
                            const StationOptions& options) {
  return Planner(knowledge, options).assess(stops);
}

double random_stations_mean_m(const Knowledge& knowledge, const StationOptions& options, std::uint64_t seed) {
  constexpr std::size_t kPlans = 25;
  Random draws(seed, 1);
  std::vector<double> means;
  for (std::size_t plan = 0; plan < kPlans; ++plan) {
    std::vector<Eigen::Vector3d> stops;
    for (int i = 0; i < options.stations; ++i) {
      const Eigen::Vector2d& p = options.places_m[static_cast<std::size_t>(
          draws.uniform() * static_cast<double>(options.places_m.size()))];
      stops.emplace_back(p.x(), p.y(), draws.uniform(-M_PI, M_PI));
    }
    means.push_back(assess_stations(knowledge, stops, options).after.mean_m);
  }
  std::ranges::nth_element(means, means.begin() + kPlans / 2);
  return means[kPlans / 2];
}

}  // namespace octant::calib
