// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/survey_row.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace octant::calib {
namespace {

class RowBuilder {
 public:
  RowBuilder(const Network& network, const NetworkColumns& columns, const Eigen::VectorXd& x)
      : network_(network), columns_(columns), x_(x) {}

  Eigen::Vector3d position_m(int point) const {
    Eigen::Vector3d p = network_.points[static_cast<std::size_t>(point)].p_map_m;
    for (int i = 0; i < 3; ++i)
      if (const int c = column(point, i); c >= 0) p[i] = x_[c];
    return p;
  }

  void by_point(int point, const Eigen::Vector3d& derivative) {
    for (int i = 0; i < 3; ++i)
      if (const int c = column(point, i); c >= 0 && derivative[i] != 0.0)
        row.entries.emplace_back(c, derivative[i]);
  }

  void by_difference(const SurveyObservation& o, const Eigen::Vector3d& derivative) {
    by_point(o.to, derivative);
    by_point(o.from, -derivative);
  }

  /// Computed azimuth from `from` to `to`, whose derivatives enter with the factor `sign`.
  double azimuth(int from, int to, double sign) {
    const Eigen::Vector3d v = position_m(to) - position_m(from);
    const double square = v.head<2>().squaredNorm();
    const Eigen::Vector3d derivative(-v.y() / square, v.x() / square, 0.0);
    by_point(to, sign * derivative);
    by_point(from, -sign * derivative);
    return std::atan2(v.y(), v.x());
  }

  /// Distance of length `length_m`, along the unit vector `direction`, with scale and constant.
  double distance(const SurveyObservation& o, double length_m, const Eigen::Vector3d& direction) {
    double factor = 1.0, constants = 0.0;
    if (o.scale >= 0) {
      const int c = columns_.first_scale + o.scale;
      factor += x_[c];
      row.entries.emplace_back(c, length_m);
    }
    for (const int number : {o.constant, o.target_constant})
      if (number >= 0) constants += constant(number);
    by_difference(o, factor * direction);
    return factor * length_m + constants;
  }

  double constant(int number) {
    const int c = columns_.first_constant + number;
    row.entries.emplace_back(c, 1.0);
    return x_[c];
  }

  double orientation(int set) {
    row.entries.emplace_back(columns_.first_set + set, -1.0);
    return x_[columns_.first_set + set];
  }

  SurveyRow row;

 private:
  int column(int point, int i) const {
    return columns_.point[static_cast<std::size_t>(point)][static_cast<std::size_t>(i)];
  }

  const Network& network_;
  const NetworkColumns& columns_;
  const Eigen::VectorXd& x_;
};

double zenith_angle(RowBuilder& build, const SurveyObservation& o, const Eigen::Vector3d& sight) {
  const double horizontal = sight.head<2>().norm(), square = sight.squaredNorm();
  const double k = sight.z() / (horizontal * square);
  build.by_difference(o, {sight.x() * k, sight.y() * k, -horizontal / square});
  return std::atan2(horizontal, sight.z());
}

double coordinate_value(RowBuilder& build, const SurveyObservation& o) {
  const bool difference = o.kind >= SurveyKind::kDx;
  const int axis = static_cast<int>(o.kind) - static_cast<int>(difference ? SurveyKind::kDx : SurveyKind::kX);
  if (difference) {
    build.by_difference(o, Eigen::Vector3d::Unit(axis));
    return (build.position_m(o.to) - build.position_m(o.from))[axis];
  }
  build.by_point(o.from, Eigen::Vector3d::Unit(axis));
  return build.position_m(o.from)[axis];
}

double computed_value(RowBuilder& build, const SurveyObservation& o) {
  if (o.kind == SurveyKind::kConstant) return build.constant(o.constant);
  if (o.kind >= SurveyKind::kX) return coordinate_value(build, o);
  const Eigen::Vector3d v = build.position_m(o.to) - build.position_m(o.from);
  const Eigen::Vector3d sight = v + Eigen::Vector3d(0.0, 0.0, o.target_height_m - o.instrument_height_m);
  switch (o.kind) {
    case SurveyKind::kDirection: return build.azimuth(o.from, o.to, 1.0) - build.orientation(o.set);
    case SurveyKind::kAzimuth: return build.azimuth(o.from, o.to, 1.0);
    case SurveyKind::kAngle: {
      const double second = build.azimuth(o.from, o.second, 1.0);
      return second - build.azimuth(o.from, o.to, -1.0);
    }
    case SurveyKind::kZenithAngle: return zenith_angle(build, o, sight);
    case SurveyKind::kHorizontalDistance: {
      const double length = v.head<2>().norm();
      return build.distance(o, length, {v.x() / length, v.y() / length, 0.0});
    }
    case SurveyKind::kSlopeDistance: return build.distance(o, sight.norm(), sight.normalized());
    default: build.by_difference(o, Eigen::Vector3d::UnitZ()); return sight.z();
  }
}

}  // namespace

NetworkColumns network_columns(const Network& network) {
  NetworkColumns columns;
  for (const NetworkPoint& point : network.points) {
    std::array<int, 3>& c = columns.point.emplace_back(std::array{-1, -1, -1});
    for (std::size_t i = 0; i < 3; ++i) {
      if (point.role[i] != CoordinateRole::kFree && point.role[i] != CoordinateRole::kDatum) continue;
      if (point.role[i] == CoordinateRole::kDatum) columns.datum.push_back(columns.size);
      c[i] = columns.size++;
    }
  }
  columns.first_set = columns.size;
  columns.first_scale = columns.first_set + network.sets;
  columns.first_constant = columns.first_scale + network.scales;
  columns.size = columns.first_constant + network.constants;
  return columns;
}

SurveyRow survey_row(const Network& network, const NetworkColumns& columns,
                     const SurveyObservation& observation, const Eigen::VectorXd& x) {
  RowBuilder build(network, columns, x);
  const double difference = observation.value - computed_value(build, observation);
  const bool angle = observation.kind <= SurveyKind::kZenithAngle;
  build.row.misclosure = angle ? std::remainder(difference, 2.0 * std::numbers::pi) : difference;
  return build.row;
}

Eigen::VectorXd initial_unknowns(const Network& network, const NetworkColumns& columns) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(columns.size);
  for (std::size_t p = 0; p < network.points.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i)
      if (const int c = columns.point[p][i]; c >= 0) x[c] = network.points[p].p_map_m[static_cast<int>(i)];
  std::vector<std::vector<double>> orientations(static_cast<std::size_t>(network.sets));
  for (const SurveyObservation& o : network.observations)
    if (o.kind == SurveyKind::kDirection)
      orientations[static_cast<std::size_t>(o.set)].push_back(-survey_row(network, columns, o, x).misclosure);
  for (std::size_t set = 0; set < orientations.size(); ++set) {
    if (orientations[set].empty()) continue;
    const double first = orientations[set].front();
    for (double& o : orientations[set]) o = std::remainder(o - first, 2.0 * std::numbers::pi);
    const auto middle = orientations[set].begin() + static_cast<std::ptrdiff_t>(orientations[set].size() / 2);
    std::ranges::nth_element(orientations[set], middle);
    x[columns.first_set + static_cast<int>(set)] = first + *middle;
  }
  return x;
}

}  // namespace octant::calib
