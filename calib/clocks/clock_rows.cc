// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/clocks/clock_problem.h"

namespace octant::calib {
namespace {

/// Standard deviation of rates: beyond the tolerance of any oscillator, so that it has no effect.
constexpr double kRateSigma = 1.0e-4;
/// Standard deviation of unknown positions, in extents of the site.
constexpr double kUnknownPlace = 10.0;

class RowMaker {
 public:
  RowMaker(const ClockProblem& problem, const Eigen::VectorXd& x) : p_(problem), x_(x) {}

  std::vector<ClockRow> all() {
    rows_.reserve(p_.receptions.size() + 3 * p_.points.size() + 64);
    for (std::size_t i = 0; i < p_.receptions.size(); ++i) add_reception(i);
    add_site();
    for (std::size_t p = 0; p < p_.points.size(); ++p) add_point(p);
    for (const ClockMotion& motion : p_.motions) add_motion(motion);
    for (std::size_t run = 0; run < p_.knots_s.size(); ++run)
      for (int clock = 0; clock < static_cast<int>(p_.clocks.names.size()); ++clock) add_clock(run, clock);
    return std::move(rows_);
  }

 private:
  ClockRow& add_row(ClockRowKind kind, double residual, std::size_t index = 0) {
    ClockRow& row = rows_.emplace_back();
    row.kind = kind, row.index = index, row.residual = residual;
    return row;
  }
  void add_prior(int at, double mean, double sigma) {
    if (sigma > 0.0) add_row(ClockRowKind::kPrior, (mean - x_[at]) / sigma).add(at, -1.0 / sigma);
  }

  /// Position of a device with its derivative by the heading of the point.
  Eigen::Vector3d place(DeviceId device, int point, Eigen::Vector3d& by_heading) const {
    by_heading.setZero();
    if (p_.is_beacon(device)) return x_.segment<3>(p_.beacon(device.index()));
    const auto at = static_cast<std::size_t>(point);
    const Eigen::Vector3d& o = p_.site.receivers[device.index() - p_.site.beacons.size()].position_m;
    const Eigen::Vector3d turned = p_.points[at].R_map_vehicle * o;
    const double c = std::cos(x_[p_.point(at) + 3]), s = std::sin(x_[p_.point(at) + 3]);
    const Eigen::Vector3d lever(c * turned.x() - s * turned.y(), s * turned.x() + c * turned.y(), turned.z());
    by_heading = {-lever.y(), lever.x(), 0.0};
    return x_.segment<3>(p_.point(at)) + lever;
  }

  void add_end(DeviceId device, int point, const Eigen::Vector3d& by_place, const Eigen::Vector3d& by_heading,
               ClockRow& row) const {
    const bool is_beacon = p_.is_beacon(device);
    const int first = is_beacon ? p_.beacon(device.index()) : p_.point(static_cast<std::size_t>(point));
    for (int i = 0; i < 3; ++i) row.add(first + i, by_place[i]);
    if (!is_beacon) row.add(first + 3, by_place.dot(by_heading));
  }

  /// Offset of a clock at a time, and its derivatives times k.
  double add_offset(const ClockReception& r, double k, ClockRow& row) const {
    const int clock = p_.clocks.of_device[r.to.index()];
    const std::vector<double>& knots = p_.knots_s[static_cast<std::size_t>(r.run)];
    const auto run = static_cast<std::size_t>(r.run);
    double offset_m = 0.0;
    if (p_.clocks.is_free && knots.size() == 1) {
      const int at = p_.knot(run, clock, 0);
      const double t = r.time_s - knots[0];
      row.add(at, k), row.add(at + 1, k * t);
      offset_m = x_[at] + t * x_[at + 1];
    } else if (p_.clocks.is_free) {
      const auto after = std::ranges::upper_bound(knots, r.time_s) - knots.begin();
      const auto left = static_cast<std::size_t>(
          std::clamp<std::ptrdiff_t>(after - 1, 0, static_cast<std::ptrdiff_t>(knots.size()) - 2));
      const double a = (r.time_s - knots[left]) / (knots[left + 1] - knots[left]);
      const int from = p_.knot(run, clock, left), to = p_.knot(run, clock, left + 1);
      row.add(from, k * (1 - a)), row.add(to, k * a);
      offset_m = (1 - a) * x_[from] + a * x_[to];
    }
    for (std::size_t j = 0; j < p_.jumps.size(); ++j) {
      if (p_.jumps[j].run != r.run || p_.jumps[j].clock != clock || r.time_s < p_.jumps[j].time_s) continue;
      row.add(p_.jump(j), k);
      offset_m += x_[p_.jump(j)];
    }
    return offset_m;
  }

  void add_reception(std::size_t i) {
    const ClockReception& r = p_.receptions[i];
    ClockRow& row = add_row(ClockRowKind::kReception, 0.0, i);
    const double k = -1.0 / p_.sigma_m;
    Eigen::Vector3d from_by_heading, to_by_heading;
    const Eigen::Vector3d from = place(r.from, r.point, from_by_heading),
                          to = place(r.to, r.point, to_by_heading);
    const double c = p_.speed_mps + x_[p_.speed()], scale = p_.speed_mps / c;
    const Eigen::Vector3d v = to - from;
    const double distance_m = v.norm();
    const Eigen::Vector3d by =
        distance_m > 0 ? Eigen::Vector3d(k * scale / distance_m * v) : Eigen::Vector3d::Zero();
    double predicted_m = x_[p_.sent(r.transmission)] + scale * distance_m;
    row.add(p_.sent(r.transmission), k);
    if (r.from != r.to) {
      add_end(r.to, r.point, by, to_by_heading, row);
      add_end(r.from, r.point, -by, from_by_heading, row);
      row.add(p_.speed(), -k * scale * distance_m / c);
    }
    // A delay belongs to the beacon of a path; the sum of two in a path between beacons.
    for (const DeviceId end : {r.from, r.to})
      if (p_.is_beacon(end) && r.from != r.to) {
        row.add(p_.delay(end.index()), k);
        predicted_m += x_[p_.delay(end.index())];
      }
    predicted_m += add_offset(r, k, row);
    row.residual = (r.range_m - predicted_m) / p_.sigma_m;
  }

  void add_site() {
    for (std::size_t b = 0; b < p_.site.beacons.size(); ++b) {
      const SiteBeacon& beacon = p_.site.beacons[b];
      for (std::size_t i = 0; i < 3; ++i) {
        const bool known = beacon.position_m[i] && beacon.sigma_m[i];
        add_prior(p_.beacon(b) + static_cast<int>(i),
                  beacon.position_m[i].value_or(p_.centre_m[static_cast<int>(i)]),
                  known ? *beacon.sigma_m[i] : kUnknownPlace * p_.extent_m);
      }
      const Prior delay = beacon_delay_prior(p_.site, b);
      if (p_.site.timing.delay_per.beacon)
        add_prior(p_.delay(b), p_.speed_mps * delay.value, p_.speed_mps * delay.sigma);
    }
    add_prior(p_.speed(), 0.0, p_.site.speed_sigma_mps);
    if (p_.frame_turns) add_prior(p_.frame(), 0.0, std::numbers::pi);
    for (std::size_t j = 0; j < p_.jumps.size(); ++j)
      add_prior(p_.jump(j), 0.0, kRateSigma * p_.speed_mps * 1e3);
    for (const ControlDistance& d : p_.site.distances) {
      const int from = p_.beacon(d.from.index()), to = p_.beacon(d.to.index());
      const Eigen::Vector3d v = x_.segment<3>(to) - x_.segment<3>(from);
      const double sigma_m = std::max(d.sigma_m, 1e-4);
      ClockRow& row = add_row(ClockRowKind::kPrior, (d.distance_m - v.norm()) / sigma_m);
      for (int i = 0; i < 3; ++i) {
        row.add(to + i, -v[i] / (v.norm() * sigma_m));
        row.add(from + i, v[i] / (v.norm() * sigma_m));
      }
    }
  }

  void add_point(std::size_t p) {
    const ClockPoint& point = p_.points[p];
    for (int i = 0; i < 3; ++i) {
      if (point.measured_m)
        add_prior(p_.point(p) + i, (*point.measured_m)[i], point.measured_sigma_m);
      else  // bounds points with few receptions
        add_prior(p_.point(p) + i, p_.centre_m[i], kUnknownPlace * p_.extent_m);
    }
  }

  void add_motion(const ClockMotion& m) {
    const int from = p_.point(m.from), to = p_.point(m.to);
    const int turn_at = m.turns ? from + 3 : p_.frame();
    const double h = x_[turn_at], c = std::cos(h), s = std::sin(h);
    const Eigen::Vector3d d = x_.segment<3>(to) - x_.segment<3>(from);
    // Odometry is in the axes of the vehicle, displacements are in axes that the frame turns into the map.
    const Eigen::Matrix3d R = (Eigen::Matrix3d() << c, s, 0, -s, c, 0, 0, 0, 1).finished();
    const Eigen::Vector3d step = R * d;
    const Eigen::Vector3d by_turn(step.y(), -step.x(), 0.0);
    for (int i = 0; i < 3; ++i) {
      ClockRow& row = add_row(ClockRowKind::kMotion, (m.step_m[i] - step[i]) / m.sigma_m);
      for (int j = 0; j < 3; ++j) {
        row.add(to + j, -R(i, j) / m.sigma_m);
        row.add(from + j, R(i, j) / m.sigma_m);
      }
      row.add(turn_at, -by_turn[i] / m.sigma_m);
    }
    if (!m.turns) return;
    const double turned = std::remainder(m.turn_rad - (x_[to + 3] - x_[from + 3]), 2 * std::numbers::pi);
    ClockRow& row = add_row(ClockRowKind::kMotion, turned / m.sigma_rad);
    row.add(to + 3, -1.0 / m.sigma_rad);
    row.add(from + 3, 1.0 / m.sigma_rad);
  }

  /// Prior of the rate at the first knot, and the random walks from knot to knot, whitened by the Cholesky
  /// factor of Q = [q1 h + q2 h^3 / 3, q2 h^2 / 2; q2 h^2 / 2, q2 h].
  void add_clock(std::size_t run, int clock) {
    if (!p_.clocks.is_free) return;
    const std::vector<double>& knots = p_.knots_s[run];
    add_prior(p_.knot(run, clock, 0) + 1, 0.0, kRateSigma * p_.speed_mps);
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
      const double h = knots[k + 1] - knots[k], q1 = p_.phase_walk_m2, q2 = p_.rate_walk_m2;
      const double l11 = std::sqrt(q1 * h + q2 * h * h * h / 3), l21 = q2 * h * h / 2 / l11,
                   l22 = std::sqrt(q2 * h - l21 * l21);
      const int a = p_.knot(run, clock, k), b = p_.knot(run, clock, k + 1);
      const double phase = -(x_[b] - x_[a] - h * x_[a + 1]), rate = -(x_[b + 1] - x_[a + 1]);
      ClockRow& first = add_row(ClockRowKind::kProcess, phase / l11);
      first.add(b, -1 / l11), first.add(a, 1 / l11), first.add(a + 1, h / l11);
      ClockRow& second = add_row(ClockRowKind::kProcess, (rate - l21 / l11 * phase) / l22);
      const double m = l21 / l11;
      second.add(b + 1, -1 / l22), second.add(a + 1, (1 - m * h) / l22);
      second.add(b, m / l22), second.add(a, -m / l22);
    }
  }

  const ClockProblem& p_;
  const Eigen::VectorXd& x_;
  std::vector<ClockRow> rows_;
};

}  // namespace

int ClockProblem::knot(std::size_t run, int clock, std::size_t k) const {
  std::size_t before = 0;
  for (std::size_t r = 0; r < run; ++r) before += knots_s[r].size() * clocks.names.size();
  return jump(jumps.size()) +
         2 * static_cast<int>(before + static_cast<std::size_t>(clock) * knots_s[run].size() + k);
}

int ClockProblem::size() const { return knot(knots_s.size(), 0, 0); }

std::vector<bool> fixed_elements(const ClockProblem& p) {
  std::vector<bool> fixed(static_cast<std::size_t>(p.size()), false);
  const auto fix = [&fixed](int at) { fixed[static_cast<std::size_t>(at)] = true; };
  for (std::size_t b = 0; b < p.site.beacons.size(); ++b) {
    for (std::size_t i = 0; i < 3; ++i)
      if (p.site.beacons[b].position_m[i] && p.site.beacons[b].sigma_m[i].value_or(1.0) == 0.0)
        fix(p.beacon(b) + static_cast<int>(i));
    if (!p.site.timing.delay_per.beacon || !(beacon_delay_prior(p.site, b).sigma > 0)) fix(p.delay(b));
  }
  if (!(p.site.speed_sigma_mps > 0)) fix(p.speed());
  if (!p.frame_turns) fix(p.frame());
  std::vector<bool> run_seen(p.knots_s.size(), false);
  for (std::size_t i = 0; i < p.points.size(); ++i) {
    if (p.site.motion == Motion::kPlanar) fix(p.point(i) + 2);
    const bool is_first = !run_seen[p.points[i].run];
    run_seen[p.points[i].run] = true;
    const bool is_datum = p.frame_is_datum && is_first && p.points[i].run == 0;
    for (int k = 0; is_datum && k < 3; ++k) fix(p.point(i) + k);
    if (!p.heading_is_free || is_datum) fix(p.point(i) + 3);
  }
  std::vector<std::vector<bool>> observed(p.knots_s.size(), std::vector<bool>(p.clocks.names.size(), false));
  for (const ClockReception& r : p.receptions)
    observed[static_cast<std::size_t>(r.run)][static_cast<std::size_t>(p.clocks.of_device[r.to.index()])] =
        true;
  for (std::size_t run = 0; run < p.knots_s.size(); ++run)
    for (int clock = 0; clock < static_cast<int>(p.clocks.names.size()); ++clock)
      for (std::size_t k = 0; k < p.knots_s[run].size(); ++k) {
        const bool is_origin = clock == p.reference_clock && k == 0;
        if (!p.clocks.is_free || is_origin || !observed[run][static_cast<std::size_t>(clock)]) {
          fix(p.knot(run, clock, k));
          fix(p.knot(run, clock, k) + 1);
        }
      }
  return fixed;
}

Eigen::VectorXd prior_values(const ClockProblem& p) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(p.size());
  for (std::size_t b = 0; b < p.site.beacons.size(); ++b) {
    for (std::size_t i = 0; i < 3; ++i)
      x[p.beacon(b) + static_cast<int>(i)] =
          p.site.beacons[b].position_m[i].value_or(p.centre_m[static_cast<int>(i)]);
    if (p.site.timing.delay_per.beacon) x[p.delay(b)] = p.speed_mps * beacon_delay_prior(p.site, b).value;
  }
  for (std::size_t i = 0; i < p.points.size(); ++i) {
    x.segment<3>(p.point(i)) = p.points[i].measured_m.value_or(p.centre_m);
    if (p.site.motion == Motion::kPlanar) x[p.point(i) + 2] = 0.0;
  }
  return x;
}

std::vector<ClockRow> rows_at(const ClockProblem& problem, const Eigen::VectorXd& x) {
  return RowMaker(problem, x).all();
}

}  // namespace octant::calib
