// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/head_tail/triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "models/changes/chi_square.h"

namespace octant {
namespace {

constexpr double kDistinct2 = 25.0;  // two positions are distinct if they are five sigma apart
constexpr double kNothing = std::numeric_limits<double>::infinity();

/// Heron's formula, Area = sqrt(s (s-a) (s-b) (s-c)), in Kahan's form, which is accurate for flat triangles.
double area_m2(double a, double b, double c) {
  double x = a, y = b, z = c;
  if (x < y) std::swap(x, y);
  if (y < z) std::swap(y, z);
  if (x < y) std::swap(x, y);
  const double product = (x + (y + z)) * (z - (x - y)) * (z + (x - y)) * (x + (y - z));
  return product >= 0 ? std::sqrt(product) / 4 : std::numeric_limits<double>::quiet_NaN();
}

Eigen::Vector2d rotated_about(const Eigen::Vector2d& p, const Eigen::Vector2d& centre, double angle) {
  const double dx = p.x() - centre.x(), dy = p.y() - centre.y(), c = std::cos(angle), s = std::sin(angle);
  return {c * dx - s * dy + centre.x(), s * dx + c * dy + centre.y()};
}

/// If the sides fail to close only by noise, the receiver is on the base line.
bool nearly_closes(const StationRange& i, const StationRange& j, double base_m, double sigmas) {
  const double noise_m = sigmas * std::hypot(i.sigma_m, j.sigma_m);
  return i.distance_m + j.distance_m > base_m - noise_m &&
         std::abs(i.distance_m - j.distance_m) < base_m + noise_m;
}

}  // namespace

std::optional<Eigen::Vector2d> triangle_vertex(const Eigen::Vector2d& B, const Eigen::Vector2d& C, double b,
                                               double c, BaseLineSide side) {
  // Step 1: the sides.
  const double a = (C - B).norm();
  if (!(a > 0 && b > 0 && c > 0)) return std::nullopt;
  // Steps 2 and 3: area and height.
  const double area = area_m2(a, b, c);
  if (!(area >= 0)) return std::nullopt;
  const double height = 2 * area / a;
  // Steps 4 and 5: interior angles at C and B. The paper uses arcsin(height / b), and its supplement if c is
  // the longest side. That condition is necessary for an obtuse angle at C but not sufficient, and near 90
  // degrees the arc sine loses half its digits. The foot of the height determines both angles.
  const double foot = (a * a + (b - c) * (b + c)) / (2 * a);  // from C towards B; negative: beyond C
  const double angle_C = std::atan2(height, foot);
  const double angle_B = std::atan2(height, a - foot);
  // Step 6: angle that rotates the base parallel to the x axis (arccos in the paper, with the sign of 6c).
  const double theta = -std::atan2(C.y() - B.y(), C.x() - B.x());
  // Steps 7 and 8: C, rotated about B.
  const Eigen::Vector2d C_turned = rotated_about(C, B, theta);
  // Step 9: A from C if the angle there is acute, from B if it is obtuse. The paper's A is on the left of B
  // -> C.
  const double up = side == BaseLineSide::kRight ? -1.0 : 1.0;
  Eigen::Vector2d A;
  if (angle_C <= M_PI / 2) {
    A = {C_turned.x() - b * std::cos(angle_C), C_turned.y() + up * b * std::sin(angle_C)};  // 9a
  } else {
    A = {B.x() + c * std::cos(angle_B), B.y() + up * c * std::sin(angle_B)};  // 9b
  }
  // Step 10: rotation back.
  return rotated_about(A, B, -theta);
}

TriangleSolver::TriangleSolver(std::size_t max_stations, double min_sine, double gate_sigmas)
    : min_sine_(min_sine), gate_sigmas_(gate_sigmas) {
  triangles_.reserve(max_stations * max_stations / 2 + 1);
  for (TrianglePoint& place : places_) place.gain.reserve(max_stations);
}

void TriangleSolver::form(std::span<const StationRange> stations) {
  triangles_.clear();
  any_closed_ = any_open_ = false;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    for (std::size_t j = i + 1; j < stations.size(); ++j) {
      const StationRange &B = stations[i], &C = stations[j];
      const double base_m = (C.p_m - B.p_m).norm();
      const auto left = triangle_vertex(B.p_m, C.p_m, C.distance_m, B.distance_m, BaseLineSide::kLeft);
      const auto right = triangle_vertex(B.p_m, C.p_m, C.distance_m, B.distance_m, BaseLineSide::kRight);
      if (!left || !right) {
        (nearly_closes(B, C, base_m, gate_sigmas_) ? any_closed_ : any_open_) = true;
        continue;
      }
      any_closed_ = true;
      const double height_m = 0.5 * (*left - *right).norm();
      if (base_m * height_m > min_sine_ * B.distance_m * C.distance_m)
        triangles_.push_back({i, j, {*left, *right}});
    }
  }
}

/// Weighted mean of one vertex of each triangle, the one closer to a position.
TrianglePoint TriangleSolver::combine(const Eigen::Vector2d& near_m, std::span<const StationRange> stations,
                                      int left_out) const {
  TrianglePoint place;
  Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
  for (const Triangle& t : triangles_) {
    if (static_cast<int>(t.first) == left_out || static_cast<int>(t.second) == left_out) continue;
    const bool left = (t.vertex[0] - near_m).squaredNorm() <= (t.vertex[1] - near_m).squaredNorm();
    const Eigen::Vector2d offset = t.vertex[left ? 0 : 1] - near_m;  // small numbers avoid cancellation
    for (const std::size_t k : {t.first, t.second}) {
      const Eigen::Vector2d u = (near_m + offset - stations[k].p_m).normalized();
      const Eigen::Matrix2d weight = u * u.transpose() / (stations[k].sigma_m * stations[k].sigma_m);
      place.information += weight;
      weighted += weight * offset;
    }
  }
  place.p_m = near_m + place.information.inverse() * weighted;
  place.left_out = left_out;
  for (std::size_t k = 0; k < stations.size(); ++k) {
    if (static_cast<int>(k) == left_out) continue;
    const double off = ((place.p_m - stations[k].p_m).norm() - stations[k].distance_m) / stations[k].sigma_m;
    place.cost += off * off;
  }
  return place;
}

template <class Visit>
void TriangleSolver::for_each_place(std::span<const StationRange> stations, int left_out,
                                    const Visit& visit) const {
  for (const Triangle& t : triangles_) {
    if (static_cast<int>(t.first) == left_out || static_cast<int>(t.second) == left_out) continue;
    for (const Eigen::Vector2d& vertex : t.vertex) {
      // The vertices of a flat triangle are close to each other: the mean of all triangles selects one better
      // than a single vertex.
      TrianglePoint place = combine(vertex, stations, left_out);
      for (int i = 0; i < 2; ++i) place = combine(place.p_m, stations, left_out);
      if (place.p_m.allFinite() && std::isfinite(place.cost)) visit(place);
    }
  }
}

double TriangleSolver::best_cost(std::span<const StationRange> stations, int left_out) const {
  double best = kNothing;
  for_each_place(stations, left_out, [&](const TrianglePoint& place) { best = std::min(best, place.cost); });
  return best;
}

/// Returns -1 if all agree, else the station without which the others do.
int TriangleSolver::choose_left_out(std::span<const StationRange> stations, bool& agree) const {
  const int n = static_cast<int>(stations.size());
  agree = n == 2 || best_cost(stations, -1) <= chi2_gate(n - 2, gate_sigmas_);
  if (agree || n < 4) return -1;
  int left_out = -1;
  double least = kNothing;
  for (int k = 0; k < n; ++k) {
    const double cost = best_cost(stations, k);
    if (cost < least) {
      least = cost;
      left_out = k;
    }
  }
  agree = least <= chi2_gate(n - 3, gate_sigmas_);
  return left_out;
}

void TriangleSolver::fill(TrianglePoint& place, const TrianglePoint& from,
                          std::span<const StationRange> stations) {
  place.p_m = from.p_m;
  place.information = from.information;
  place.cost = from.cost;
  place.left_out = from.left_out;
  place.gain.assign(stations.size(), Eigen::Vector2d::Zero());
  const Eigen::Matrix2d covariance = place.information.inverse();
  Eigen::Matrix2d pairwise =
      Eigen::Matrix2d::Zero();  // counts each range once, whatever triangles contain it
  for (const Triangle& t : triangles_) {
    if (static_cast<int>(t.first) == place.left_out || static_cast<int>(t.second) == place.left_out) continue;
    for (const std::size_t k : {t.first, t.second}) {
      const Eigen::Vector2d u = (place.p_m - stations[k].p_m).normalized();
      place.gain[k] += covariance * u / (stations[k].sigma_m * stations[k].sigma_m);
    }
  }
  for (std::size_t k = 0; k < stations.size(); ++k)
    pairwise += stations[k].sigma_m * stations[k].sigma_m * place.gain[k] * place.gain[k].transpose();
  place.information = pairwise.inverse();
}

TriangleStatus TriangleSolver::solve(std::span<const StationRange> stations) noexcept {
  place_count_ = 0;
  if (stations.size() < 2) return TriangleStatus::kTooFew;
  form(stations);
  if (triangles_.empty())
    return any_closed_ || !any_open_ ? TriangleStatus::kFlat : TriangleStatus::kContradiction;
  bool agree = false;
  const int left_out = choose_left_out(stations, agree);
  if (!agree) return TriangleStatus::kContradiction;
  TrianglePoint best, other;
  best.cost = other.cost = kNothing;
  for_each_place(stations, left_out, [&](const TrianglePoint& place) {
    if (place.cost < best.cost) best = place;
  });
  if (!(best.cost < kNothing)) return TriangleStatus::kFlat;
  const double counted = static_cast<double>(stations.size()) -
                         (left_out >= 0 ? 2 : 1);  // number of times that each range occurs in the sum
  for_each_place(stations, left_out, [&](const TrianglePoint& place) {
    const Eigen::Vector2d apart = place.p_m - best.p_m;
    if (apart.dot(best.information * apart) > kDistinct2 * counted && place.cost < other.cost) other = place;
  });
  fill(places_[place_count_++], best, stations);
  const int dof = static_cast<int>(stations.size()) - (left_out >= 0 ? 3 : 2);
  if (other.cost <= best.cost + chi2_gate(std::max(dof, 1), gate_sigmas_))
    fill(places_[place_count_++], other, stations);
  return TriangleStatus::kOk;
}

}  // namespace octant
