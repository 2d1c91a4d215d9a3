// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/consensus.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "models/physics/pose.h"

namespace octant {
namespace {

constexpr double kBehindCost = 4.0;  ///< one in fifty direct arrivals comes from behind
/// Tolerance on the cosine of reception, because the heading is not exact during the search.
constexpr double kHearingMargin = 0.1;
constexpr double kBearingCap = 6.0;
const double kEarlyMore = std::log(20.0);              ///< ratio of frequencies of late and early arrivals
constexpr double kLateScale = 2.5, kEarlyScale = 3.5;  ///< scales of the Cauchy weights, in sigmas

constexpr double kCoarseStep = 0.1;   ///< share of the width; smaller steps end the iteration
constexpr double kRise = 1.0;         ///< increase of the score after which a step is halved
constexpr double kLongestTurn = 0.6;  ///< bound of a step [rad]

double signed_square(double x) { return x * std::abs(x); }

}  // namespace

Consensus::Consensus(const SearchProblem& problem) : problem_(problem) {
  const std::size_t n = problem.ranges.size();
  geometry_.reserve(n);
  for (const SearchRange& r : problem.ranges) {
    const double dz = r.p_lever_m.z() - r.p_beacon_map_m.z();
    geometry_.push_back({r.p_beacon_map_m.x(), r.p_beacon_map_m.y(), dz * dz, r.p_lever_m.x(),
                         r.p_lever_m.y(), r.range_m, r.axis.x(), r.axis.y(),
                         r.axis.isZero(0.0) ? -2.0 : signed_square(r.hearing_cosine - kHearingMargin),
                         kBehindCost});
  }
  if (problem.common_bias) share_behind_cost();
  inverse_variance_.resize(n);
  caps_.resize(n);
  for (auto* of_each : {&residual_, &behind_, &by_x_, &by_y_, &by_heading_}) of_each->resize(n);
  sorted_.reserve(n);
  bias_variance_.resize(problem.groups());
  group_caps_.resize(problem.groups());
  set_extra_sigma(0.0);
}

/// If one ping on a path is received from behind, all are, so the cost counts once.
void Consensus::share_behind_cost() {
  for (std::size_t group = 0; group < problem_.groups(); ++group)
    for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i) {
      const auto pings = std::count_if(
          problem_.ranges.begin() + static_cast<std::ptrdiff_t>(problem_.group_first[group]),
          problem_.ranges.begin() + static_cast<std::ptrdiff_t>(problem_.group_first[group + 1]),
          [&](const SearchRange& r) { return r.p_lever_m == problem_.ranges[i].p_lever_m; });
      geometry_[i].behind_cost /= static_cast<double>(pings);
    }
}

Consensus::Caps Consensus::caps_for(double variance_m2) const {
  const double late = std::log(1.4 * problem_.span_m) - 0.5 * std::log(variance_m2);
  return {std::max(2.0, late), std::max(4.0, late + kEarlyMore)};
}

void Consensus::set_extra_sigma(double extra_m) {
  extra_m_ = extra_m;
  // Most sigmas are equal, and logarithms dominate the cost of this loop.
  double of_arrival_m2 = 0.0, of_group_m2 = 0.0;
  Caps arrival_caps{}, caps_of_group{};
  for (std::size_t group = 0; group < problem_.groups(); ++group) {
    const std::size_t first = problem_.group_first[group], last = problem_.group_first[group + 1];
    const double bias2 = problem_.group_bias_m[group] * problem_.group_bias_m[group];
    // If a beacon's arrivals are independent, or there is only one, its bias adds to their own errors.
    const bool own = !problem_.common_bias || last - first == 1;
    bias_variance_[group] =
        own || bias2 < 0.01 * problem_.median_sigma_m * problem_.median_sigma_m ? 0.0 : bias2;
    for (std::size_t i = first; i < last; ++i) {
      const double s = problem_.ranges[i].sigma_m;
      const double variance = s * s + extra_m * extra_m + (own ? bias2 : 0.0);
      if (variance != std::exchange(of_arrival_m2, variance)) arrival_caps = caps_for(variance);
      inverse_variance_[i] = 1.0 / variance;
      caps_[i] = arrival_caps;
    }
    const double variance =
        bias_variance_[group] + 1.0 / (static_cast<double>(last - first) * inverse_variance_[first]);
    if (variance != std::exchange(of_group_m2, variance)) caps_of_group = caps_for(variance);
    group_caps_[group] = caps_of_group;
  }
}

void Consensus::set_residuals(const PlanarState& s, const PlanarTurn& heading, Part part) {
  const double cosine = heading.cosine, sine = heading.sine;
  const double judged = judge_shadows_ ? 1.0 : 0.0;
  for (std::size_t i = part.first; i < part.last; ++i) {
    const Geometry& r = geometry_[i];
    const double dx = s.x_m + cosine * r.lever_x_m - sine * r.lever_y_m - r.beacon_x_m;
    const double dy = s.y_m + sine * r.lever_x_m + cosine * r.lever_y_m - r.beacon_y_m;
    const double flat2 = dx * dx + dy * dy;
    residual_[i] = r.range_m - s.offset_m - std::sqrt(flat2 + r.dz2_m2);
    const double towards =
        -(dx * (cosine * r.axis_x - sine * r.axis_y) + dy * (sine * r.axis_x + cosine * r.axis_y));
    // Compares squares instead of towards < cosine * distance, because roots dominate the cost of this loop.
    behind_[i] = signed_square(towards) < r.hearing2 * flat2 ? judged * r.behind_cost : 0.0;
  }
}

void Consensus::set_rows(const PlanarState& s, const PlanarTurn& heading, Part part) {
  for (std::size_t i = part.first; i < part.last; ++i) {
    const Geometry& r = geometry_[i];
    const double lx = heading.cosine * r.lever_x_m - heading.sine * r.lever_y_m,
                 ly = heading.sine * r.lever_x_m + heading.cosine * r.lever_y_m;
    const double nearness = 1.0 / std::max(r.range_m - s.offset_m - residual_[i], 1e-6);
    by_x_[i] = (s.x_m + lx - r.beacon_x_m) * nearness;
    by_y_[i] = (s.y_m + ly - r.beacon_y_m) * nearness;
    by_heading_[i] = by_y_[i] * lx - by_x_[i] * ly;
  }
}

double Consensus::arrival_cost(std::size_t i, double residual) const {
  return std::min(0.5 * residual * residual * inverse_variance_[i],
                  residual > 0 ? caps_[i].late : caps_[i].early);
}

double Consensus::middle_residual(std::size_t group) {
  const double* r = residual_.data() + problem_.group_first[group];
  switch (problem_.group_first[group + 1] - problem_.group_first[group]) {  // specialised for small groups
    case 1: return r[0];
    case 2: return std::min(r[0], r[1]);
    case 3: return std::max(std::min(r[0], r[1]), std::min(std::max(r[0], r[1]), r[2]));
    default: break;
  }
  sorted_.assign(residual_.begin() + static_cast<std::ptrdiff_t>(problem_.group_first[group]),
                 residual_.begin() + static_cast<std::ptrdiff_t>(problem_.group_first[group + 1]));
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>((sorted_.size() - 1) / 2);
  std::ranges::nth_element(sorted_, middle);
  return *middle;
}

double Consensus::divided_group_cost(std::size_t group, double plain, bool& direct) {
  const double bias = middle_residual(group), bias_variance = bias_variance_[group];
  double among = 0.0, among_behind = 0.0, information = 0.0;
  for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i) {
    const double r = residual_[i] - bias;
    among += arrival_cost(i, r);
    among_behind +=
        std::min(0.5 * r * r * inverse_variance_[i] + behind_[i], r > 0 ? caps_[i].late : caps_[i].early);
    information += inverse_variance_[i];
  }
  if (bias_variance > 0) plain = 0.5 * bias * bias / (bias_variance + 1.0 / information) + among_behind;
  // Only a wrong beacon position makes all its arrivals early, so this is not considered without a bias.
  if (bias <= 0 && bias_variance == 0.0) return plain;
  // Echoes come from all directions, so reception from behind is free for them.
  const double shadowed = (bias > 0 ? group_caps_[group].late : group_caps_[group].early) + among;
  direct = plain <= shadowed;
  return std::min(plain, shadowed);
}

double Consensus::group_cost(std::size_t group, bool& direct) {
  const std::size_t first = problem_.group_first[group], last = problem_.group_first[group + 1];
  double plain = 0.0, S0 = 0.0, S1 = 0.0, S2 = 0.0, behind = 0.0;
  for (std::size_t i = first; i < last; ++i) {
    const double r = residual_[i], w = inverse_variance_[i];
    const double cost = 0.5 * r * r * w;
    plain += std::min(cost + behind_[i], r > 0 ? caps_[i].late : caps_[i].early);
    S0 += w;
    S1 += w * r;
    S2 += cost;
    behind += behind_[i];
  }
  direct = true;
  if (!judge_shadows_ || !problem_.common_bias || last - first < 2) return plain;
  // Eliminates the common error by least squares. If the remaining cost is low, the group is direct.
  if (bias_variance_[group] > 0) plain = S2 - 0.5 * S1 * S1 / (1.0 / bias_variance_[group] + S0) + behind;
  return plain <= group_caps_[group].late ? plain : divided_group_cost(group, plain, direct);
}

double Consensus::bearing_cost(const SearchBearing& b, const PlanarState& s,
                               const PlanarTurn& heading) const {
  const double cosine = heading.cosine, sine = heading.sine;
  const double dx = b.p_reflector_map_m.x() - s.x_m - cosine * b.p_lever_m.x() + sine * b.p_lever_m.y();
  const double dy = b.p_reflector_map_m.y() - s.y_m - sine * b.p_lever_m.x() - cosine * b.p_lever_m.y();
  const double off = wrap_angle(std::atan2(dy, dx) - s.heading_rad - b.bearing_rad);
  const double away2 = (extra_m_ * extra_m_ + problem_.uncertainty_m * problem_.uncertainty_m) /
                       std::max(dx * dx + dy * dy, 1e-6);
  return std::min(0.5 * off * off / (b.sigma_rad * b.sigma_rad + away2), kBearingCap);
}

double Consensus::score(const PlanarState& state, const PlanarTurn& heading, double give_up) {
  double total = 0.0;
  bool direct = true;
  for (std::size_t group = 0; group < problem_.groups(); ++group) {
    set_residuals(state, heading, {problem_.group_first[group], problem_.group_first[group + 1]});
    total += group_cost(group, direct);
    if (total > give_up) return total;
  }
  for (const SearchBearing& b : problem_.bearings) total += bearing_cost(b, state, heading);
  return total;
}

double Consensus::best_offset(const PlanarState& state) {
  PlanarState s = state;
  s.offset_m = 0.0;
  set_residuals(s, PlanarTurn(s.heading_rad), all());
  sorted_.assign(residual_.begin(), residual_.end());
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>((sorted_.size() - 1) / 2);
  std::ranges::nth_element(sorted_, middle);
  return sorted_.empty() ? 0.0 : *middle;
}

/// Adds the normal equations of one beacon's arrivals, with its bias eliminated (Schur complement).
double Consensus::add_group(std::size_t group, PoseEquations& eq) {
  bool direct = true;
  const double cost = group_cost(group, direct);
  if (!direct) return cost;
  const bool biased = bias_variance_[group] > 0;
  const std::size_t first = problem_.group_first[group], last = problem_.group_first[group + 1];
  const double centre = biased ? middle_residual(group) : 0.0;
  double coupling[4] = {}, bias_information = biased ? 1.0 / bias_variance_[group] : 1.0, bias_gradient = 0.0;
  constexpr double kLate = 1.0 / (kLateScale * kLateScale), kEarly = 1.0 / (kEarlyScale * kEarlyScale);
  for (std::size_t i = first; i < last; ++i) {
    const double row[4] = {by_x_[i], by_y_[i], by_heading_[i], 1.0};
    const double off = residual_[i] - centre;
    const double w =
        inverse_variance_[i] / (1.0 + off * off * inverse_variance_[i] * (off > 0 ? kLate : kEarly));
    eq.add(w, row, residual_[i], problem_.has_offset);
    if (!biased) continue;
    for (int p = 0; p < 4; ++p) coupling[p] += w * row[p];
    bias_information += w;
    bias_gradient += w * residual_[i];
  }
  if (biased) eq.add(-1.0 / bias_information, coupling, bias_gradient, problem_.has_offset);
  return cost;
}

void Consensus::add_bearing(const SearchBearing& b, const PlanarState& s, const PlanarTurn& heading,
                            PoseEquations& eq) const {
  const double cosine = heading.cosine, sine = heading.sine;
  const double lx = cosine * b.p_lever_m.x() - sine * b.p_lever_m.y(),
               ly = sine * b.p_lever_m.x() + cosine * b.p_lever_m.y();
  const double dx = b.p_reflector_map_m.x() - s.x_m - lx, dy = b.p_reflector_map_m.y() - s.y_m - ly;
  const double n2 = std::max(dx * dx + dy * dy, 1e-6);
  const double off =
      wrap_angle(b.bearing_rad + s.heading_rad - std::atan2(dy, dx));  // observed minus predicted
  const double variance = b.sigma_rad * b.sigma_rad +
                          (extra_m_ * extra_m_ + problem_.uncertainty_m * problem_.uncertainty_m) / n2;
  const double w = 1.0 / variance / (1.0 + off * off / variance / (kEarlyScale * kEarlyScale));
  const double by_x = dy / n2, by_y = -dx / n2;
  const double row[4] = {by_x, by_y, -by_x * ly + by_y * lx - 1.0, 0.0};
  eq.add(w, row, off, false);
}

double Consensus::least_cap() const {
  double least = std::numeric_limits<double>::infinity();
  for (const Caps& c : caps_) least = std::min(least, c.late);
  for (const Caps& c : group_caps_) least = std::min(least, c.late);
  return least;
}

std::size_t Consensus::agreement(const PlanarState& s, std::size_t group, double sigmas,
                                 std::span<const char> left_out, Eigen::Matrix3d& information) {
  const PlanarTurn heading(s.heading_rad);
  const std::size_t first = problem_.group_first[group];
  set_residuals(s, heading, {first, problem_.group_first[group + 1]});
  set_rows(s, heading, {first, problem_.group_first[group + 1]});
  std::size_t receivers = 0;
  for (std::size_t i = first; i < problem_.group_first[group + 1]; ++i) {
    const SearchRange& r = problem_.ranges[i];
    const double variance = variance_m2(i, group);
    if (left_out[i] != 0 || residual_[i] * residual_[i] > sigmas * sigmas * variance) continue;
    const Eigen::Vector3d row(by_x_[i], by_y_[i], by_heading_[i]);
    information.noalias() += row * row.transpose() / variance;
    bool known = false;
    for (std::size_t j = first; j < i && !known; ++j)
      known = left_out[j] == 0 && problem_.ranges[j].p_lever_m == r.p_lever_m &&
              residual_[j] * residual_[j] <= sigmas * sigmas * variance_m2(j, group);
    receivers += known ? 0 : 1;
  }
  return receivers;
}

bool Consensus::has_residual_between(const PlanarState& s, double low, double high) {
  set_residuals(s, PlanarTurn(s.heading_rad), all());
  for (std::size_t group = 0; group < problem_.groups(); ++group) {
    for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i) {
      const double squares = residual_[i] * residual_[i] / variance_m2(i, group);
      if (squares > low * low && squares < high * high) return true;
    }
  }
  return false;
}

bool Consensus::explains(const PlanarState& s, const std::array<std::size_t, 2>& arrivals) const {
  constexpr double kSigmas = 4.0;
  const double cosine = std::cos(s.heading_rad), sine = std::sin(s.heading_rad);
  return std::ranges::all_of(arrivals, [&](std::size_t i) {
    const SearchRange& r = problem_.ranges[i];
    const auto after = std::ranges::upper_bound(problem_.group_first, i);
    const double bias_m =
        problem_.group_bias_m[static_cast<std::size_t>(after - problem_.group_first.begin()) - 1];
    const double dx = s.x_m + cosine * r.p_lever_m.x() - sine * r.p_lever_m.y() - r.p_beacon_map_m.x();
    const double dy = s.y_m + sine * r.p_lever_m.x() + cosine * r.p_lever_m.y() - r.p_beacon_map_m.y();
    const double dz = r.p_lever_m.z() - r.p_beacon_map_m.z();
    const double off_m = r.range_m - s.offset_m - std::sqrt(dx * dx + dy * dy + dz * dz);
    return off_m * off_m <= kSigmas * kSigmas * (r.sigma_m * r.sigma_m + bias_m * bias_m);
  });
}

double Consensus::middle_misfit_m(const PlanarState& s) {
  set_residuals(s, PlanarTurn(s.heading_rad), all());
  sorted_.clear();
  for (const double r : residual_) sorted_.push_back(std::abs(r));
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::ranges::nth_element(sorted_, middle);
  return sorted_.empty() ? 0.0 : *middle;
}

Eigen::Matrix4d Consensus::refine(PlanarState& s, int iterations, std::size_t without_group,
                                  Descent& descent) {
  PoseEquations eq;
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  PlanarTurn heading(s.heading_rad);
  const double least_m = std::max(1e-2 * problem_.median_sigma_m, kCoarseStep * extra_m_);
  const double least_rad =
      std::max(1e-4, kCoarseStep * extra_m_ /
                         (problem_.bearings.empty() ? std::max(problem_.lever_m, 1e-3) : problem_.span_m));
  // A rotation by a moves the end of a lever arm l off its tangent by l a^2 / 2, which is limited to three
  // sigmas.
  const double longest_turn = std::min(
      kLongestTurn,
      std::sqrt(6 * std::hypot(problem_.median_sigma_m, extra_m_) / std::max(problem_.lever_m, 1e-3)));
  for (int k = 0; k < iterations; ++k) {
    eq = PoseEquations();
    set_residuals(s, heading, all());
    set_rows(s, heading, all());
    double cost = 0.0;
    for (std::size_t group = 0; group < problem_.groups(); ++group)
      if (group != without_group) cost += add_group(group, eq);
    if (cost > descent.score + kRise) {
      const PlanarState& before = descent.state;
      s = {0.5 * (s.x_m + before.x_m), 0.5 * (s.y_m + before.y_m),
           wrap_angle(before.heading_rad + 0.5 * wrap_angle(s.heading_rad - before.heading_rad)),
           0.5 * (s.offset_m + before.offset_m)};
      heading = PlanarTurn(s.heading_rad);
      continue;
    }
    descent = {s, cost};
    for (const SearchBearing& b : problem_.bearings) add_bearing(b, s, heading, eq);
    information = eq.H;
    Eigen::Vector4d step = eq.step(problem_.span_m, problem_.has_offset);
    if (!step.allFinite()) break;
    const double longest =
        std::max({step.head<2>().norm() / (0.3 * problem_.span_m), std::abs(step[2]) / longest_turn, 1.0});
    step /= longest;
    s.x_m += step[0];
    s.y_m += step[1];
    s.heading_rad = wrap_angle(s.heading_rad + step[2]);
    heading = PlanarTurn(step[2]) * heading;
    if (problem_.has_offset) s.offset_m += step[3];
    if (step.head<2>().norm() < least_m && std::abs(step[2]) < least_rad) break;
  }
  return information.selfadjointView<Eigen::Lower>();
}

}  // namespace octant
