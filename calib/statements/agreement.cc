// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Cholesky>

#include "calib/problem/ranges.h"
#include "calib/verdict/observability.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// Of a beacon's arrivals, where others lose a third of that at most.
constexpr double kManyLeftOut = 0.15, kBeyondOthers = 3.0;
constexpr std::size_t kFewestLeftOut = 8;
/// Early spurious arrivals exist, and are few.
constexpr double kManyEarly = 0.10;
/// A beacon is held to have moved at so many sigmas, and by this share of the tolerance.
constexpr double kMovedSigmas = 6.0, kMovedMatters = 0.3;
constexpr std::size_t kMostSplit = 3;
/// A second pose has three parameters, each worth a few units of chance; a late arrival that it takes up
/// saves eight.
constexpr double kStopGain = 30.0;
constexpr std::size_t kFewestBeacons = 3, kFewestOfHalf = 6;

bool is_left_out(Rejection r) { return r == Rejection::kLate || r == Rejection::kEarly; }

struct BeaconCounts {
  std::size_t placed = 0, late = 0, early = 0, bearings = 0, bearings_out = 0;
  [[nodiscard]] std::size_t out() const { return late + early; }
  [[nodiscard]] double share() const {
    return placed > 0 ? static_cast<double>(out()) / static_cast<double>(placed) : 0.0;
  }
};

std::vector<BeaconCounts> count(const Fit& fit) {
  std::vector<BeaconCounts> counts(fit.problem.site.beacons.size());
  for (const Trajectory& t : fit.trajectories) {
    for (const ArrivalObservation& a : t.arrivals) {
      if (!t.nodes[a.node].placed || a.rejection == Rejection::kBeaconUnusable ||
          a.rejection == Rejection::kNoPose)
        continue;
      BeaconCounts& c = counts[a.beacon.index()];
      ++c.placed;
      c.late += a.rejection == Rejection::kLate;
      c.early += a.rejection == Rejection::kEarly;
    }
    for (const BearingObservation& b : t.bearings) {
      if (!b.reflector.valid() || !t.nodes[b.node].placed) continue;
      ++counts[b.reflector.index()].bearings;
      counts[b.reflector.index()].bearings_out += is_left_out(b.rejection);
    }
  }
  return counts;
}

// A beacon that moved
// ---------------------------------------------------------------------------------------------------

/// The fit in which a beacon's arrivals after some time are those of another one, of which nothing is known.
Fit split_fit(const SolveOptions& options, const Fit& fit, std::size_t b, double time_s) {
  Fit split = fit;
  SiteBeacon later = fit.problem.site.beacons[b];
  later.name += " later";
  later.sigma_m = {};
  split.problem.site.beacons.push_back(later);
  split.beacon_usable.push_back(true);
  SharedState state = fit.state();
  state.beacon_p_map_m.push_back(state.beacon_p_map_m[b]);
  state.beacon_delay_s.push_back(state.beacon_delay_s[b]);
  if (!state.pair_bias_s.empty())
    for (std::size_t r = 0; r < state.receiver_delay_s.size(); ++r)
      state.pair_bias_s.push_back(state.pair_bias_s[b * state.receiver_delay_s.size() + r]);
  const BeaconId after(split.problem.site.beacons.size() - 1);
  for (Trajectory& t : split.trajectories)
    for (ArrivalObservation& a : t.arrivals)
      if (a.beacon.index() == b && a.time_s > time_s) a.beacon = after;
  std::vector<bool> held(split.beacon_usable.size());
  for (std::size_t k = 0; k < held.size(); ++k) held[k] = !split.beacon_usable[k];
  split.layout = make_layout(split.problem, state, held);
  split.layout.dense_limit = fit.layout.dense_limit;
  for (Parameter& p : split.layout.parameters)  // as they are believed by now
    for (const Parameter& old : fit.layout.parameters)
      if (old.id == p.id) p = old;
  split.x = split.layout.vector_of(state);
  adjust_anew(options, split);
  return split;
}

struct Move {
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double time_s = 0.0, sigmas = 0.0, cost = 0.0;
};

/// Where the second half (the beacon's own last) and the first differ.
Move move_of(const SolveOptions& options, const Fit& split, std::size_t b, double time_s) {
  Move move;
  const std::size_t later = split.layout.beacon.size() - 1;
  const SharedState state = split.state();
  move.by_m = state.beacon_p_map_m[later] - state.beacon_p_map_m[b];
  move.time_s = time_s;
  move.cost = split.cost;
  const Eigen::MatrixXd C = honest_covariance(options, split);
  Eigen::MatrixXd by = Eigen::MatrixXd::Zero(3, C.rows());
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (split.layout.beacon[later][i] >= 0) by(row, split.layout.beacon[later][i]) = 1.0;
    if (split.layout.beacon[b][i] >= 0) by(row, split.layout.beacon[b][i]) = -1.0;
  }
  const Eigen::Matrix3d D = by * C * by.transpose() + 1e-12 * Eigen::Matrix3d::Identity();
  move.sigmas =
      std::max(0.0, std::sqrt(std::max(0.0, move.by_m.dot(D.ldlt().solve(move.by_m)))) - std::sqrt(2.0));
  return move;
}

/// Times at which a beacon may have moved: where arrivals begin or cease to be left out, and half way
/// through.
std::vector<double> moments_of(const Fit& fit, std::size_t b) {
  std::vector<std::pair<double, double>> out;  // time, whether left out
  for (const Trajectory& t : fit.trajectories)
    for (const ArrivalObservation& a : t.arrivals)
      if (a.beacon.index() == b && (a.rejection == Rejection::kUsed || is_left_out(a.rejection)))
        out.emplace_back(a.time_s, is_left_out(a.rejection) ? 1.0 : 0.0);
  if (out.size() < 4 * kFewestLeftOut) return {};
  std::sort(out.begin(), out.end());
  double total = 0.0, sum = 0.0, best = 0.0;
  for (const auto& [time, left] : out) total += left;
  const auto n = static_cast<double>(out.size());
  std::vector<double> moments = {0.5 * (out[out.size() / 2 - 1].first + out[out.size() / 2].first)};
  std::optional<double> change;
  for (std::size_t k = 0; k + 1 < out.size(); ++k) {
    sum += out[k].second;
    const double before = static_cast<double>(k) + 1.0;
    const double off = std::abs(sum - before / n * total) / std::sqrt(before * (n - before) / n);
    if (k + 1 < kFewestLeftOut || k + 1 + kFewestLeftOut > out.size() || out[k].first == out[k + 1].first ||
        off <= best)
      continue;
    best = off;
    change = 0.5 * (out[k].first + out[k + 1].first);
  }
  if (change) moments.push_back(*change);
  return moments;
}

std::string length(double m) {
  return m < 1.0 ? fmt::format("{:.0f} mm", 1e3 * m) : fmt::format("{:.2f} m", m);
}

// A stop that was none
// --------------------------------------------------------------------------------------------------

/// Squares of a stop's arrivals up to the limit of the rejection, of those on one side of an instant.
struct SideCost {
  double cost = 0.0;
  std::size_t used = 0, beacons = 0;
};

class StopTest {
 public:
  StopTest(const Trajectory& t, const Segment& segment, const SharedState& state, double limit)
      : state_(state), limit_(limit) {
    one_.run = t.run;
    one_.vehicle = t.vehicle;
    one_.motion = t.motion;
    one_.has_cycle_offset = t.has_cycle_offset;
    one_.nominal_speed_mps = t.nominal_speed_mps;
    one_.turnaround_s = t.turnaround_s;
    one_.nodes = {t.nodes[segment.first_node]};
    for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
      ArrivalObservation a = t.arrivals[i];
      if (a.rejection != Rejection::kUsed && !is_left_out(a.rejection)) continue;
      a.node = 0;
      if (a.hear_send >= 0) {  // two-way: how the vehicle moved between hearing and sending
        one_.T_hear_send.push_back(t.T_hear_send[static_cast<std::size_t>(a.hear_send)]);
        a.hear_send = static_cast<std::int32_t>(one_.T_hear_send.size()) - 1;
      }
      one_.arrivals.push_back(a);
    }
    one_.segments.resize(1);
    one_.segments[0].last_node = 1;
    one_.segments[0].last_arrival = one_.arrivals.size();
    for (const ArrivalObservation& a : one_.arrivals) times_.insert(a.time_s);
  }

  /// By how much two poses explain more than one; 0 where the stop does not tell.
  [[nodiscard]] double gain() {
    if (one_.arrivals.size() < 2 * kFewestOfHalf || times_.size() < 4) return 0.0;
    const SideCost whole = side(-INFINITY, INFINITY);
    double best = 0.0;
    const std::vector<double> times(times_.begin(), times_.end());
    const std::size_t step = std::max<std::size_t>(1, times.size() / 8);
    for (std::size_t k = step; k < times.size(); k += step) {
      const double instant = 0.5 * (times[k - 1] + times[k]);
      const SideCost before = side(-INFINITY, instant), after = side(instant, INFINITY);
      if (std::min(before.beacons, after.beacons) < kFewestBeacons ||
          std::min(before.used, after.used) < kFewestOfHalf)
        continue;
      best = std::max(best, whole.cost - before.cost - after.cost);
    }
    return best;
  }

 private:
  SideCost side(double from_s, double to_s) {
    Trajectory t = one_;
    for (ArrivalObservation& a : t.arrivals)
      a.rejection = a.time_s > from_s && a.time_s <= to_s ? Rejection::kUsed : Rejection::kNotNeeded;
    for (const double scale : {20.0, 2.385})
      static_cast<void>(settle(t, t.segments[0], state_, {scale, scale}));
    SideCost result;
    std::set<std::size_t> beacons;
    for (const ArrivalObservation& a : t.arrivals) {
      if (a.rejection != Rejection::kUsed) continue;
      const double r = arrival_residual(t, a, state_);
      result.cost += 0.5 * std::min(r * r, limit_ * limit_);
      if (std::abs(r) > limit_) continue;
      ++result.used;
      beacons.insert(a.beacon.index());
    }
    result.beacons = beacons.size();
    return result;
  }

  const SharedState& state_;
  double limit_;
  Trajectory one_;
  std::set<double> times_;
};

class Checker {
 public:
  Checker(const Problem& problem, const SolveOptions& options, const Fit& fit,
          const std::vector<Contradiction>& besides, double growth)
      : problem_(problem),
        options_(options),
        fit_(fit),
        besides_(besides),
        growth_(growth),
        counts_(count(fit)) {}

  Agreement run() {
    std::vector<double> shares;
    for (const BeaconCounts& c : counts_)
      if (c.placed > 0) shares.push_back(c.share());
    usual_ = shares.empty() ? 0.0 : median(shares);
    beacons();
    stops();
    return std::move(out_);
  }

 private:
  [[nodiscard]] bool said(const std::string& beacon) const {
    for (const Contradiction& c : besides_)
      if ((", " + c.subject + ",").find(", " + beacon + ",") != std::string::npos) return true;
    return false;
  }

  void beacons() {
    std::vector<std::size_t> suspects;
    for (std::size_t b = 0; b < counts_.size(); ++b) {
      const BeaconCounts& c = counts_[b];
      if (!fit_.beacon_usable[b] || said(problem_.site.beacons[b].name)) continue;
      if (c.bearings >= 10 && 2 * c.bearings_out > c.bearings) bearings_left_out(b);
      if (c.out() < kFewestLeftOut || c.share() < std::max(kManyLeftOut, kBeyondOthers * usual_)) continue;
      suspects.push_back(b);
    }
    std::sort(suspects.begin(), suspects.end(),
              [this](std::size_t a, std::size_t b) { return counts_[a].out() > counts_[b].out(); });
    for (std::size_t k = 0; k < suspects.size(); ++k) {
      if (k < kMostSplit && moved(suspects[k])) continue;
      much_left_out(suspects[k]);
    }
  }

  bool moved(std::size_t b) {
    std::optional<Move> best;
    for (const double moment : moments_of(fit_, b)) {
      const Fit split = split_fit(options_, fit_, b, moment);
      if (!split.ok || (best && split.cost >= best->cost)) continue;
      best = move_of(options_, split, b, moment);
    }
    // Half of what was left out must come back, else the move is not what ails it.
    const double regained = 0.5 * 0.5 * options_.rejection_sigmas * options_.rejection_sigmas *
                            static_cast<double>(counts_[b].out());
    if (!best || fit_.cost - best->cost < regained || best->sigmas < kMovedSigmas * growth_ ||
        best->by_m.norm() < kMovedMatters * tolerance_m(problem_))
      return false;
    const std::string& name = problem_.site.beacons[b].name;
    double first_s = INFINITY;
    for (const Trajectory& t : fit_.trajectories)
      if (!t.nodes.empty()) first_s = std::min(first_s, t.nodes.front().time_s);
    out_.contradictions.push_back(
        {ContradictionKind::kBeacon, name, "to stay where it is",
         fmt::format("to move by {} ({:+.3f}, {:+.3f}, {:+.3f} m) some {:.0f} s into the recording",
                     length(best->by_m.norm()), best->by_m.x(), best->by_m.y(), best->by_m.z(),
                     best->time_s - first_s),
         best->sigmas,
         fmt::format("fasten beacon {}; then calibrate with what was recorded before or after it moved, not "
                     "with both",
                     name)});
    return true;
  }

  void much_left_out(std::size_t b) {
    const BeaconCounts& c = counts_[b];
    const std::string& name = problem_.site.beacons[b].name;
    if (c.early >= kFewestLeftOut &&
        static_cast<double>(c.early) > kManyEarly * static_cast<double>(c.placed) && c.early > c.late) {
      const double expected = std::max(1.0, 0.01 * static_cast<double>(c.placed));
      out_.contradictions.push_back(
          {ContradictionKind::kBeacon, name, "to be heard along the straight path",
           fmt::format("early at {} of {} arrivals, as no echo can be", c.early, c.placed),
           (static_cast<double>(c.early) - expected) / std::sqrt(expected),
           fmt::format(
               "look whether beacon {} stood still, whether another sends under its name, and at its channel",
               name)});
      return;
    }
    out_.warnings.push_back(
        fmt::format("beacon {}: {} of {} arrivals do not fit where the others have it ({} late, {} early), "
                    "far more than of other beacons; look for "
                    "what stands in its way or reflects it",
                    name, c.out(), c.placed, c.late, c.early));
  }

  void bearings_left_out(std::size_t b) {
    const std::string& name = problem_.site.beacons[b].name;
    const BeaconCounts& c = counts_[b];
    out_.contradictions.push_back({ContradictionKind::kBeacon, name, "in the directions that were measured",
                                   fmt::format("{} of {} bearings elsewhere", c.bearings_out, c.bearings),
                                   0.0,
                                   fmt::format("look whether {} stands at the mirror image of its place, and "
                                               "whether the bearings' signs and names are right",
                                               name)});
  }

  /// Several beacons that do not fit: the echoes of one are no motion; and enough squares to be saved by a
  /// second pose.
  [[nodiscard]] bool may_have_moved(const Trajectory& t, const Segment& s, const SharedState& state) const {
    std::optional<std::size_t> first;
    bool several = false;
    double squares = 0.0;
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
      const ArrivalObservation& a = t.arrivals[i];
      if (!is_left_out(a.rejection)) continue;
      several = several || (first && *first != a.beacon.index());
      first = a.beacon.index();
    }
    if (!several) return false;
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
      if (t.arrivals[i].rejection == Rejection::kUsed || is_left_out(t.arrivals[i].rejection))
        squares += 0.5 * std::min(std::pow(arrival_residual(t, t.arrivals[i], state), 2),
                                  options_.rejection_sigmas * options_.rejection_sigmas) -
                   0.25;
    return squares > kStopGain;
  }

  void stops() {
    const SharedState state = fit_.state();
    std::vector<std::pair<double, std::int64_t>> moved;
    std::size_t all = 0;
    for (const Trajectory& t : fit_.trajectories) {
      if (t.moving || t.motion != Motion::kPlanar || !t.odometry.empty() || !t.poses.empty() ||
          t.segments.size() != t.nodes.size())
        continue;
      for (const Segment& s : t.segments) {
        const Node& node = t.nodes[s.first_node];
        if (!node.placed || node.epoch == kNoEpoch) continue;
        ++all;
        if (!may_have_moved(t, s, state)) continue;
        const double gain = StopTest(t, s, state, options_.rejection_sigmas).gain();
        if (gain > kStopGain) moved.emplace_back(gain, node.epoch);
      }
    }
    if (moved.empty()) return;
    std::sort(moved.begin(), moved.end(), std::greater<>());
    constexpr std::size_t kMostNamed = 12;
    std::vector<std::int64_t> named;
    for (std::size_t i = 0; i < moved.size() && i < kMostNamed; ++i) named.push_back(moved[i].second);
    out_.warnings.push_back(fmt::format(
        "the vehicle moved during {} of {} stops: stops {}{} (epochs of the recording); what does not fit of "
        "them is left out, better leave "
        "them out as a whole, or record them again",
        moved.size(), all, fmt::join(named, ", "), moved.size() > named.size() ? " and more" : ""));
  }

  const Problem& problem_;
  const SolveOptions& options_;
  const Fit& fit_;
  const std::vector<Contradiction>& besides_;
  double growth_;
  std::vector<BeaconCounts> counts_;
  double usual_ = 0.0;
  Agreement out_;
};

}  // namespace

Agreement agreement_of(const Problem& problem, const SolveOptions& options, const Fit& fit,
                       const std::vector<Contradiction>& besides, double growth) {
  if (!is_dense(fit.layout) || fit.x.size() == 0) return {};
  return Checker(problem, options, fit, besides, growth).run();
}

}  // namespace octant::calib
