// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/motions.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <Eigen/Cholesky>

#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

constexpr std::size_t kFewestOfBeacon = 8;  ///< least number of arrivals on each side of a change
/// Least gain of a second pose, in half squares. Its three parameters gain a few units by chance, and one
/// late arrival that it absorbs gains eight.
constexpr double kStopGain = 30.0;
constexpr std::size_t kFewestBeacons = 3, kFewestOfHalf = 6;

/// Cost of the arrivals of a stop on one side of a time, each limited to the rejection limit.
struct SideCost {
  double cost = 0.0;
  std::size_t used = 0, beacons = 0;
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();  ///< position of the vehicle
};

class StopTest {
 public:
  StopTest(const Trajectory& t, const Segment& segment, const SharedState& state, double limit)
      : state_(state), limit_(limit), one_(standing_at(t, t.nodes[segment.first_node])) {
    for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
      ArrivalObservation a = t.arrivals[i];
      if (!is_by_residual(a.rejection)) continue;
      a.node = 0;
      if (a.hear_send >= 0) {  // two-way: motion of the vehicle between reception and reply
        one_.T_hear_send.push_back(t.T_hear_send[static_cast<std::size_t>(a.hear_send)]);
        a.hear_send = static_cast<std::int32_t>(one_.T_hear_send.size()) - 1;
      }
      one_.arrivals.push_back(a);
    }
    set_only_segment(one_);
    for (const ArrivalObservation& a : one_.arrivals) times_.insert(a.time_s);
  }

  /// The two poses that explain most; their gain is zero if the stop does not determine them.
  [[nodiscard]] StopMotion best() {
    StopMotion best;
    if (one_.arrivals.size() < 2 * kFewestOfHalf || times_.size() < 4) return best;
    const SideCost whole = side(-INFINITY, INFINITY);
    const std::vector<double> times(times_.begin(), times_.end());
    const std::size_t step = std::max<std::size_t>(1, times.size() / 8);
    for (std::size_t k = step; k < times.size(); k += step) {
      const double instant = 0.5 * (times[k - 1] + times[k]);
      const SideCost before = side(-INFINITY, instant), after = side(instant, INFINITY);
      if (std::min(before.beacons, after.beacons) < kFewestBeacons ||
          std::min(before.used, after.used) < kFewestOfHalf)
        continue;
      if (const double gain = whole.cost - before.cost - after.cost; gain > best.gain)
        best = {gain, (after.at_m - before.at_m).norm(), instant};
    }
    return best;
  }

 private:
  SideCost side(double from_s, double to_s) {
    Trajectory t = one_;
    for (ArrivalObservation& a : t.arrivals)
      a.rejection = a.time_s > from_s && a.time_s <= to_s ? Rejection::kUsed : Rejection::kNotNeeded;
    for (const double scale : {20.0, 2.385})
      static_cast<void>(solve_states(t, t.segments[0], state_, {scale, scale}));
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
    result.at_m = t.nodes[0].T_map_vehicle.translation_m.head<2>();
    return result;
  }

  const SharedState& state_;
  double limit_;
  Trajectory one_;
  std::set<double> times_;
};

/// Returns true if a second pose may explain enough. Several beacons must deviate, because echoes of a single
/// beacon are no motion, and the residuals must exceed what a second pose has to save.
bool may_have_moved(const Trajectory& t, const Segment& s, const SharedState& state, double limit) {
  std::optional<std::size_t> first;
  bool several = false;
  double squares = 0.0;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (!is_outlier(a.rejection)) continue;
    several = several || (first && *first != a.beacon.index());
    first = a.beacon.index();
  }
  if (!several) return false;
  for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
    if (is_by_residual(t.arrivals[i].rejection))
      squares += 0.5 * std::min(std::pow(arrival_residual(t, t.arrivals[i], state), 2), limit * limit) - 0.25;
  return squares > kStopGain;
}

}  // namespace

Fit split_fit(const SolveOptions& options, const Fit& fit, std::size_t b, double time_s) {
  Fit split = fit;
  SiteBeacon later = fit.problem.site.beacons[b];
  later.name += " later";
  later.sigma_m = {};
  split.problem.site.beacons.push_back(later);
  split.beacon_usable.push_back(true);
  SharedState state = fit.state();
  add_copy_of_beacon(state, b);
  const BeaconId after(split.problem.site.beacons.size() - 1);
  for (Trajectory& t : split.trajectories)
    for (ArrivalObservation& a : t.arrivals)
      if (a.beacon.index() == b && a.time_s > time_s) a.beacon = after;
  split.layout = make_layout(split.problem, state, split.beacon_usable);
  split.layout.dense_limit = fit.layout.dense_limit;
  for (Parameter& p : split.layout.parameters)  // with the current priors
    for (const Parameter& old : fit.layout.parameters)
      if (old.id == p.id) p = old;
  split.x = split.layout.vector_of(state);
  adjust_anew(options, split);
  return split;
}

Move move_of(const SolveOptions& options, const Fit& split, std::size_t b, double time_s) {
  Move move;
  const std::size_t later = split.layout.beacon.size() - 1;
  const SharedState state = split.state();
  move.by_m = state.beacon_p_map_m[later] - state.beacon_p_map_m[b];
  move.time_s = time_s;
  move.cost = split.cost;
  const Eigen::MatrixXd C = honest_covariance(options, split).matrix;
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

PositionChange likeliest_change(const Fit& fit, std::size_t b) {
  struct Row {
    double time_s = 0.0, residual = 0.0;
    Eigen::Vector3d by_position = Eigen::Vector3d::Zero();
  };
  const SharedState state = fit.state();
  std::vector<Row> rows;
  for (const Trajectory& t : fit.trajectories)
    for (const ArrivalObservation& a : t.arrivals) {
      if (a.beacon.index() != b || a.rejection != Rejection::kUsed) continue;
      const Eigen::Vector3d ray_m =
          state.beacon_p_map_m[b] -
          pose_at(t, a.node, a.alpha) * state.receiver_p_vehicle_m[a.receiver.index()];
      rows.push_back({a.time_s, arrival_residual(t, a, state),
                      ray_m.normalized() * (a.legs() / (a.model_speed_mps * a.sigma_s))});
    }
  PositionChange best;
  if (rows.size() < 4 * kFewestOfBeacon) return best;
  std::ranges::sort(rows, {}, &Row::time_s);
  struct Sums {
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    /// Squares that the best step saves.
    [[nodiscard]] double gain() const {
      const double ridge = 1e-6 * information.trace();
      const Eigen::Matrix3d H = information + ridge * Eigen::Matrix3d::Identity();
      return gradient.dot(H.ldlt().solve(gradient));
    }
  };
  Sums all, before;
  for (const Row& row : rows) {
    all.gradient += row.by_position * row.residual;
    all.information += row.by_position * row.by_position.transpose();
  }
  for (std::size_t k = 0; k + kFewestOfBeacon < rows.size(); ++k) {
    before.gradient += rows[k].by_position * rows[k].residual;
    before.information += rows[k].by_position * rows[k].by_position.transpose();
    if (k + 1 < kFewestOfBeacon || rows[k].time_s == rows[k + 1].time_s) continue;
    const Sums after{all.gradient - before.gradient, all.information - before.information};
    if (const double gain = before.gain() + after.gain() - all.gain(); gain > best.gain)
      best = {0.5 * (rows[k].time_s + rows[k + 1].time_s), gain};
  }
  return best;
}

std::vector<double> times_of_change(const Fit& fit, std::size_t b) {
  std::vector<std::pair<double, double>> out;  // time, 1 if rejected
  for (const Trajectory& t : fit.trajectories)
    for (const ArrivalObservation& a : t.arrivals)
      if (a.beacon.index() == b && is_by_residual(a.rejection))
        out.emplace_back(a.time_s, is_outlier(a.rejection) ? 1.0 : 0.0);
  if (out.size() < 4 * kFewestOfBeacon) return {};
  std::ranges::sort(out);
  double total = 0.0, sum = 0.0, best = 0.0;
  for (const auto& [time, left] : out) total += left;
  const auto n = static_cast<double>(out.size());
  std::vector<double> times = {0.5 * (out[out.size() / 2 - 1].first + out[out.size() / 2].first)};
  std::optional<double> change;
  for (std::size_t k = 0; k + 1 < out.size(); ++k) {
    sum += out[k].second;
    const double before = static_cast<double>(k) + 1.0;
    const double off = std::abs(sum - before / n * total) / std::sqrt(before * (n - before) / n);
    if (k + 1 < kFewestOfBeacon || k + 1 + kFewestOfBeacon > out.size() || out[k].first == out[k + 1].first ||
        off <= best)
      continue;
    best = off;
    change = 0.5 * (out[k].first + out[k + 1].first);
  }
  if (change) times.push_back(*change);
  return times;
}

std::optional<double> best_time_of_change(const Fit& split, std::size_t b, double limit) {
  const BeaconId earlier(b), later(split.problem.site.beacons.size() - 1);
  const SharedState state = split.state();
  // Time of each arrival, and its cost at the later position minus that at the earlier one.
  std::vector<std::pair<double, double>> more_if_later;
  for (const Trajectory& t : split.trajectories)
    for (ArrivalObservation a : t.arrivals) {
      if ((a.beacon != earlier && a.beacon != later) || !is_by_residual(a.rejection) ||
          !t.nodes[a.node].placed)
        continue;
      const auto cost_at = [&](BeaconId place) {
        a.beacon = place;
        return std::min(std::pow(arrival_residual(t, a, state), 2), limit * limit);
      };
      const double at_earlier = cost_at(earlier);
      more_if_later.emplace_back(a.time_s, cost_at(later) - at_earlier);
    }
  std::ranges::sort(more_if_later);
  std::optional<double> change;
  double sum = 0.0, most = -INFINITY;
  for (std::size_t k = 0; k + kFewestOfBeacon < more_if_later.size(); ++k) {
    sum += more_if_later[k].second;
    const double here_s = more_if_later[k].first, next_s = more_if_later[k + 1].first;
    if (k + 1 < kFewestOfBeacon || here_s == next_s || sum <= most) continue;
    most = sum;
    change = 0.5 * (here_s + next_s);
  }
  return change;
}

std::optional<StopMotion> motion_during(const Trajectory& t, const Segment& stop, const SharedState& state,
                                        double limit) {
  if (!may_have_moved(t, stop, state, limit)) return {};
  const StopMotion motion = StopTest(t, stop, state, limit).best();
  return motion.gain > kStopGain ? std::optional(motion) : std::nullopt;
}

}  // namespace octant::calib
