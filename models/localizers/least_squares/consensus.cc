// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/consensus.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "models/physics/pose.h"

namespace octant {
namespace {

constexpr double kBehindCost = 4.0;  ///< against: one in fifty direct arrivals
constexpr double kBearingCap = 6.0;
constexpr double kLateScale = 2.5, kEarlyScale = 3.5;  ///< of the Cauchy weights, in sigmas

/// d predicted / d (x, y, heading), of a range with its residual at the state.
Eigen::Vector3d direction_row(const SearchRange& r, const PlanarState& s, double cosine, double sine,
                              double residual) {
  const double lx = cosine * r.p_lever_m.x() - sine * r.p_lever_m.y(),
               ly = sine * r.p_lever_m.x() + cosine * r.p_lever_m.y();
  const double distance = std::max(r.range_m - s.offset_m - residual, 1e-6);
  const double ux = (s.x_m + lx - r.p_beacon_map_m.x()) / distance,
               uy = (s.y_m + ly - r.p_beacon_map_m.y()) / distance;
  return {ux, uy, uy * lx - ux * ly};
}

}  // namespace

Consensus::Consensus(const SearchProblem& problem) : problem_(problem) {
  const std::size_t n = problem.ranges.size();
  inverse_variance_.resize(n);
  caps_.resize(n);
  residual_.resize(n);
  behind_.resize(n);
  sorted_.reserve(n);
  bias_variance_.resize(problem.groups());
  group_caps_.resize(problem.groups());
  set_extra_sigma(0.0);
}

Consensus::Caps Consensus::caps_for(double variance_m2) const {
  const double ratio = problem_.span_m / std::sqrt(variance_m2);
  return {std::max(2.0, std::log(1.4 * ratio)), std::max(4.0, std::log(28.0 * ratio))};
}

void Consensus::set_extra_sigma(double extra_m) {
  extra_m_ = extra_m;
  for (std::size_t group = 0; group < problem_.groups(); ++group) {
    const std::size_t first = problem_.group_first[group], last = problem_.group_first[group + 1];
    const double bias2 = problem_.group_bias_m[group] * problem_.group_bias_m[group];
    // Where a beacon's arrivals have nothing in common, or there is but one, its bias is a part of their own
    // errors.
    const bool own = !problem_.common_bias || last - first == 1;
    bias_variance_[group] =
        own || bias2 < 0.01 * problem_.median_sigma_m * problem_.median_sigma_m ? 0.0 : bias2;
    for (std::size_t i = first; i < last; ++i) {
      const double s = problem_.ranges[i].sigma_m;
      const double variance = s * s + extra_m * extra_m + (own ? bias2 : 0.0);
      inverse_variance_[i] = 1.0 / variance;
      const bool same = i > first && problem_.ranges[i - 1].sigma_m == s;
      caps_[i] = same ? caps_[i - 1] : caps_for(variance);
    }
    group_caps_[group] = caps_for(bias_variance_[group] +
                                  1.0 / (static_cast<double>(last - first) * inverse_variance_[first]));
  }
}

void Consensus::residuals_of_group(const PlanarState& s, double cosine, double sine, std::size_t group) {
  const auto signed_square = [](double x) { return x * std::abs(x); };
  for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i) {
    const SearchRange& r = problem_.ranges[i];
    const double dx = s.x_m + cosine * r.p_lever_m.x() - sine * r.p_lever_m.y() - r.p_beacon_map_m.x();
    const double dy = s.y_m + sine * r.p_lever_m.x() + cosine * r.p_lever_m.y() - r.p_beacon_map_m.y();
    const double dz = r.p_lever_m.z() - r.p_beacon_map_m.z();
    const double flat2 = dx * dx + dy * dy;
    residual_[i] = r.range_m - s.offset_m - std::sqrt(flat2 + dz * dz);
    behind_[i] = 0.0;
    if (!judge_shadows_ || r.axis.isZero(0.0)) continue;
    const double towards =
        -(dx * (cosine * r.axis.x() - sine * r.axis.y()) + dy * (sine * r.axis.x() + cosine * r.axis.y()));
    // towards < cosine * distance by their squares: roots are what this loop costs.
    if (signed_square(towards) < signed_square(r.hearing_cosine) * flat2) behind_[i] = kBehindCost;
  }
}

double Consensus::arrival_cost(std::size_t i, double residual) const {
  return std::min(0.5 * residual * residual * inverse_variance_[i],
                  residual > 0 ? caps_[i].late : caps_[i].early);
}

double Consensus::middle_residual(std::size_t group) {
  const double* r = residual_.data() + problem_.group_first[group];
  switch (problem_.group_first[group + 1] - problem_.group_first[group]) {  // mostly of few
    case 1: return r[0];
    case 2: return std::min(r[0], r[1]);
    case 3: return std::max(std::min(r[0], r[1]), std::min(std::max(r[0], r[1]), r[2]));
    default: break;
  }
  sorted_.assign(residual_.begin() + static_cast<std::ptrdiff_t>(problem_.group_first[group]),
                 residual_.begin() + static_cast<std::ptrdiff_t>(problem_.group_first[group + 1]));
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>((sorted_.size() - 1) / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
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
  // Nothing but a wrong beacon makes all its arrivals early; so without a bias of its own that is not
  // offered.
  if (bias <= 0 && bias_variance == 0.0) return plain;
  // An echo comes from any side, so hearing from behind costs nothing there.
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
  // What they have in common is taken out by least squares; if the rest is cheap, all is said.
  if (bias_variance_[group] > 0) plain = S2 - 0.5 * S1 * S1 / (1.0 / bias_variance_[group] + S0) + behind;
  return plain <= group_caps_[group].late ? plain : divided_group_cost(group, plain, direct);
}

double Consensus::bearing_cost(const SearchBearing& b, const PlanarState& s, double cosine,
                               double sine) const {
  const double dx = b.p_reflector_map_m.x() - s.x_m - cosine * b.p_lever_m.x() + sine * b.p_lever_m.y();
  const double dy = b.p_reflector_map_m.y() - s.y_m - sine * b.p_lever_m.x() - cosine * b.p_lever_m.y();
  const double off = wrap_angle(std::atan2(dy, dx) - s.heading_rad - b.bearing_rad);
  const double away2 =
      (extra_m_ * extra_m_ + problem_.slack_m * problem_.slack_m) / std::max(dx * dx + dy * dy, 1e-6);
  return std::min(0.5 * off * off / (b.sigma_rad * b.sigma_rad + away2), kBearingCap);
}

double Consensus::score(const PlanarState& state, double give_up) {
  const double cosine = std::cos(state.heading_rad), sine = std::sin(state.heading_rad);
  double total = 0.0;
  bool direct = true;
  for (std::size_t group = 0; group < problem_.groups(); ++group) {
    residuals_of_group(state, cosine, sine, group);
    total += group_cost(group, direct);
    if (total > give_up) return total;
  }
  for (const SearchBearing& b : problem_.bearings) total += bearing_cost(b, state, cosine, sine);
  return total;
}

double Consensus::best_offset(const PlanarState& state) {
  PlanarState s = state;
  s.offset_m = 0.0;
  const double cosine = std::cos(s.heading_rad), sine = std::sin(s.heading_rad);
  for (std::size_t group = 0; group < problem_.groups(); ++group) residuals_of_group(s, cosine, sine, group);
  sorted_.assign(residual_.begin(), residual_.end());
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>((sorted_.size() - 1) / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return sorted_.empty() ? 0.0 : *middle;
}

/// Normal equations of one beacon's arrivals; its bias, where it has one, is eliminated by the Schur
/// complement.
void Consensus::add_group(const PlanarState& s, double cosine, double sine, std::size_t group,
                          Eigen::Matrix4d& H, Eigen::Vector4d& g) {
  residuals_of_group(s, cosine, sine, group);
  bool direct = true;
  static_cast<void>(group_cost(group, direct));
  if (!direct) return;
  const bool biased = bias_variance_[group] > 0;
  const std::size_t first = problem_.group_first[group], last = problem_.group_first[group + 1];
  const double centre = biased ? middle_residual(group) : 0.0;
  Eigen::Vector4d coupling = Eigen::Vector4d::Zero();
  double bias_information = biased ? 1.0 / bias_variance_[group] : 1.0, bias_gradient = 0.0;
  for (std::size_t i = first; i < last; ++i) {
    const SearchRange& r = problem_.ranges[i];
    const Eigen::Vector3d by_pose = direction_row(r, s, cosine, sine, residual_[i]);
    const Eigen::Vector4d row(by_pose.x(), by_pose.y(), by_pose.z(), problem_.has_offset ? 1.0 : 0.0);
    const double off = residual_[i] - centre;
    const double scale = off > 0 ? kLateScale : kEarlyScale;
    const double w = inverse_variance_[i] / (1.0 + off * off * inverse_variance_[i] / (scale * scale));
    H.noalias() += w * row * row.transpose();
    g.noalias() += w * residual_[i] * row;
    coupling += w * row;
    bias_information += w;
    bias_gradient += w * residual_[i];
  }
  if (!biased) return;
  H.noalias() -= coupling * coupling.transpose() / bias_information;
  g.noalias() -= coupling * (bias_gradient / bias_information);
}

void Consensus::add_bearing(const SearchBearing& b, const PlanarState& s, double cosine, double sine,
                            Eigen::Matrix4d& H, Eigen::Vector4d& g) const {
  const double lx = cosine * b.p_lever_m.x() - sine * b.p_lever_m.y(),
               ly = sine * b.p_lever_m.x() + cosine * b.p_lever_m.y();
  const double dx = b.p_reflector_map_m.x() - s.x_m - lx, dy = b.p_reflector_map_m.y() - s.y_m - ly;
  const double n2 = std::max(dx * dx + dy * dy, 1e-6);
  const double off =
      wrap_angle(b.bearing_rad + s.heading_rad - std::atan2(dy, dx));  // observed less predicted
  const double variance =
      b.sigma_rad * b.sigma_rad + (extra_m_ * extra_m_ + problem_.slack_m * problem_.slack_m) / n2;
  const double w = 1.0 / variance / (1.0 + off * off / variance / (kEarlyScale * kEarlyScale));
  const double by_x = dy / n2, by_y = -dx / n2;
  const Eigen::Vector4d row(by_x, by_y, -by_x * ly + by_y * lx - 1.0, 0.0);
  H.noalias() += w * row * row.transpose();
  g.noalias() += w * off * row;
}

double Consensus::least_cap() const {
  double least = std::numeric_limits<double>::infinity();
  for (const Caps& c : caps_) least = std::min(least, c.late);
  for (const Caps& c : group_caps_) least = std::min(least, c.late);
  return least;
}

std::size_t Consensus::agreement(const PlanarState& s, std::size_t group, double sigmas,
                                 Eigen::Matrix3d& information) {
  const double cosine = std::cos(s.heading_rad), sine = std::sin(s.heading_rad);
  residuals_of_group(s, cosine, sine, group);
  const std::size_t first = problem_.group_first[group];
  std::size_t receivers = 0;
  for (std::size_t i = first; i < problem_.group_first[group + 1]; ++i) {
    const SearchRange& r = problem_.ranges[i];
    const double variance = 1.0 / inverse_variance_[i] + bias_variance_[group];
    if (residual_[i] * residual_[i] > sigmas * sigmas * variance) continue;
    const Eigen::Vector3d row = direction_row(r, s, cosine, sine, residual_[i]);
    information.noalias() += row * row.transpose() / variance;
    bool known = false;
    for (std::size_t j = first; j < i && !known; ++j)
      known = problem_.ranges[j].p_lever_m == r.p_lever_m &&
              residual_[j] * residual_[j] <=
                  sigmas * sigmas * (1.0 / inverse_variance_[j] + bias_variance_[group]);
    receivers += known ? 0 : 1;
  }
  return receivers;
}

bool Consensus::has_residual_between(const PlanarState& s, double low, double high) {
  const double cosine = std::cos(s.heading_rad), sine = std::sin(s.heading_rad);
  for (std::size_t group = 0; group < problem_.groups(); ++group) {
    residuals_of_group(s, cosine, sine, group);
    for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i) {
      const double squares =
          residual_[i] * residual_[i] / (1.0 / inverse_variance_[i] + bias_variance_[group]);
      if (squares > low * low && squares < high * high) return true;
    }
  }
  return false;
}

double Consensus::middle_misfit_m(const PlanarState& s) {
  const double cosine = std::cos(s.heading_rad), sine = std::sin(s.heading_rad);
  for (std::size_t group = 0; group < problem_.groups(); ++group) residuals_of_group(s, cosine, sine, group);
  sorted_.clear();
  for (const double r : residual_) sorted_.push_back(std::abs(r));
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return sorted_.empty() ? 0.0 : *middle;
}

Eigen::Matrix4d Consensus::refine(PlanarState& s, int iterations, std::size_t without_group) {
  Eigen::Matrix4d H;
  for (int k = 0; k < iterations; ++k) {
    H.setZero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    const double cosine = std::cos(s.heading_rad), sine = std::sin(s.heading_rad);
    for (std::size_t group = 0; group < problem_.groups(); ++group)
      if (group != without_group) add_group(s, cosine, sine, group, H, g);
    for (const SearchBearing& b : problem_.bearings) add_bearing(b, s, cosine, sine, H, g);
    // A heading that nothing tells stays where it is; so does a position where all arrivals have lost their
    // weight.
    Eigen::Matrix4d A = H;
    A(2, 2) += kVagueAngle;
    A.diagonal().head<2>().array() += 1.0 / (problem_.span_m * problem_.span_m);
    A(3, 3) += problem_.has_offset ? 1e-12 : 1.0;
    Eigen::Vector4d step = Eigen::LLT<Eigen::Matrix4d>(A).solve(g);
    if (!step.allFinite()) break;
    const double longest =
        std::max({step.head<2>().norm() / (0.3 * problem_.span_m), std::abs(step[2]) / 0.6, 1.0});
    step /= longest;
    s.x_m += step[0];
    s.y_m += step[1];
    s.heading_rad = wrap_angle(s.heading_rad + step[2]);
    if (problem_.has_offset) s.offset_m += step[3];
    if (step.head<2>().norm() < 1e-2 * problem_.median_sigma_m && std::abs(step[2]) < 1e-4) break;
  }
  return H;
}

}  // namespace octant
