// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace octant {

/// Side of a base line on which a vehicle is, seen from its first base station towards its last.
enum class BaseLineSide { kAny = 0, kLeft = 1, kRight = -1 };

/// Third vertex A of a triangle whose base stations stand at B and C (Thamma, section V, steps 1 to 10).
/// @param b_m, c_m  measured sides CA and BA, horizontal [m]  @param side  kAny counts as kLeft
/// @return nothing where the sides make no triangle, or B and C coincide. Accuracy: rounding, times c /
/// height near the base line.
[[nodiscard]] std::optional<Eigen::Vector2d> triangle_vertex(const Eigen::Vector2d& B_m,
                                                             const Eigen::Vector2d& C_m, double b_m,
                                                             double c_m, BaseLineSide side);

/// Base station as one receiver hears it.
struct StationRange {
  Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
  double distance_m = 0.0;  ///< horizontal
  double sigma_m = 0.0;     ///< of it, for weights and gates
};

/// A place that triangles agree on.
struct TrianglePoint {
  Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< 1/m^2, of independent station ranges
  double cost = 0.0;                  ///< sum of squared station residuals over their sigmas
  int left_out = -1;                  ///< station that disagrees with all others
  std::vector<Eigen::Vector2d> gain;  ///< d p / d distance of each station
};

enum class TriangleStatus {
  kOk,
  kTooFew,        ///< fewer than two stations
  kFlat,          ///< no triangle is wide enough to tell the place
  kContradiction  ///< sides that make no triangle, or stations that disagree
};

/// Combines the triangles of all pairs of base stations, each weighted with the inverse covariance of its
/// vertex. The sum over pairs of these weights is the information of the ranges times a number, so nothing is
/// lost against least squares to first order. The other stations tell on which side of a base line the
/// receiver is; where they cannot, there are two places.
class TriangleSolver {
 public:
  /// @param max_stations that a receiver hears  @param min_sine  of the angle at the vertex; flatter
  /// triangles are not used
  TriangleSolver(std::size_t max_stations, double min_sine, double gate_sigmas);

  [[nodiscard]] TriangleStatus solve(std::span<const StationRange> stations) noexcept;
  /// One place, or two that the stations explain about equally well; the better first.
  [[nodiscard]] std::span<const TrianglePoint> places() const { return {places_.data(), place_count_}; }

 private:
  struct Triangle {
    std::size_t first = 0, second = 0;
    std::array<Eigen::Vector2d, 2> vertex;
  };
  void form(std::span<const StationRange> stations);
  [[nodiscard]] TrianglePoint combine(const Eigen::Vector2d& near_m, std::span<const StationRange> stations,
                                      int left_out) const;
  template <class Visit>
  void for_each_place(std::span<const StationRange> stations, int left_out, const Visit& visit) const;
  [[nodiscard]] double best_cost(std::span<const StationRange> stations, int left_out) const;
  [[nodiscard]] int choose_left_out(std::span<const StationRange> stations, bool& agree) const;
  void fill(TrianglePoint& place, const TrianglePoint& from, std::span<const StationRange> stations);

  double min_sine_, gate_sigmas_;
  bool any_closed_ = false, any_open_ = false;  ///< flat or sound triangles; sides that make none
  std::vector<Triangle> triangles_;
  std::array<TrianglePoint, 2> places_;
  std::size_t place_count_ = 0;
};

}  // namespace octant
