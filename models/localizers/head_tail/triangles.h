// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace octant {

/// Side of a base line, seen from its first base station towards its last.
enum class BaseLineSide { kAny = 0, kLeft = 1, kRight = -1 };

/// Third vertex A of a triangle with base stations at B and C (Thamma, section V, steps 1 to 10).
/// @param b_m, c_m  measured sides CA and BA, horizontal [m]  @param side  kAny counts as kLeft
/// @return no value if the sides form no triangle, or B and C coincide. Accuracy: rounding, times c / height
/// near the base line.
[[nodiscard]] std::optional<Eigen::Vector2d> triangle_vertex(const Eigen::Vector2d& B_m,
                                                             const Eigen::Vector2d& C_m, double b_m,
                                                             double c_m, BaseLineSide side);

/// Range from a base station to one receiver.
struct StationRange {
  Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
  double distance_m = 0.0;  ///< horizontal
  double sigma_m = 0.0;     ///< sigma of the distance, for weights and gates
};

/// Position that triangles agree on.
struct TrianglePoint {
  Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< 1/m^2, for independent ranges
  double cost = 0.0;                                      ///< sum of squared residuals over their variances
  int left_out = -1;                                      ///< station that disagrees with all others
  std::vector<Eigen::Vector2d> gain;                      ///< d p / d distance for each station
};

enum class TriangleStatus {
  kOk,
  kTooFew,        ///< fewer than two stations
  kFlat,          ///< no triangle is wide enough to determine the position
  kContradiction  ///< sides that form no triangle, or stations that disagree
};

/// Combines the triangles of all pairs of base stations, each weighted with the inverse covariance of its
/// vertex. The sum of these weights over all pairs is a multiple of the information of the ranges, so the
/// result equals least squares to first order. The other stations determine the side of a base line;
/// otherwise there are two positions.
class TriangleSolver {
 public:
  /// @param max_stations largest number for one receiver  @param min_sine  smallest sine of the angle at the
  /// vertex; flatter triangles are not used
  TriangleSolver(std::size_t max_stations, double min_sine, double gate_sigmas);

  [[nodiscard]] TriangleStatus solve(std::span<const StationRange> stations) noexcept;
  /// One position, or two that the stations explain about equally well; the better one first.
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
  bool any_closed_ = false,
       any_open_ =
           false;  ///< closed: at least one triangle that is flat or valid; open: sides that form none
  std::vector<Triangle> triangles_;
  std::array<TrianglePoint, 2> places_;
  std::size_t place_count_ = 0;
};

}  // namespace octant
