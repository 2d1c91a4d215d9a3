// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/line_map/scan_lines.h"
#include "models/physics/plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace octant {
namespace {

/// Computes line, ends and fit of a segment from its sums; the ends are the given points projected onto the
/// line.
void refit_line(LineSegment& s, std::span<const Eigen::Vector2d> reach) {
  // Direction of largest scatter, in closed form.
  const Eigen::Matrix2d& S = s.scatter_m2;
  const double along_rad = 0.5 * std::atan2(2 * S(0, 1), S(0, 0) - S(1, 1));
  const Eigen::Vector2d along = direction_of(along_rad);
  Eigen::Vector2d normal = left_of(along);
  s.rms_m = std::sqrt(std::max(0.0, normal.dot(S * normal)) / s.count);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Eigen::Vector2d& p : reach) {
    const double t = along.dot(p - s.centre_m);
    low = std::min(low, t);
    high = std::max(high, t);
  }
  s.from_m = s.centre_m + low * along;
  s.to_m = s.centre_m + high * along;
  if (normal.dot(s.centre_m) < 0) normal = -normal;
  s.line = {normal.dot(s.centre_m), angle_of(normal)};
}

}  // namespace

std::pmr::vector<Eigen::Vector2d> scan_points(const Scan& scan, const ScanLineOptions& options) {
  std::pmr::vector<Eigen::Vector2d> points(scratch());
  points.reserve(scan.range_m.size());
  for (std::size_t k = 0; k < scan.range_m.size(); ++k) {
    const double r = scan.range_m[k];
    if (!(r > 0 && r < options.range_max_m)) continue;
    const double angle = scan.angle_min_rad + static_cast<double>(k) * scan.angle_increment_rad;
    points.push_back(r * direction_of(angle));
  }
  return points;
}

std::pmr::vector<std::size_t> cluster(std::span<const Eigen::Vector2d> points, double beam_rad,
                                      const ScanLineOptions& options) {
  std::pmr::vector<std::size_t> first(scratch());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) {
      const double nearer_m = std::min(points[i].norm(), points[i - 1].norm());
      const double epsilon_m = std::max(options.gap_m, options.gap_beams * beam_rad * nearer_m);
      if ((points[i] - points[i - 1]).norm() <= epsilon_m) continue;  // eq. 2
    }
    first.push_back(i);
  }
  first.push_back(points.size());
  return first;
}

LineSegment fit_segment(std::span<const Eigen::Vector2d> points) {
  LineSegment s;
  s.count = static_cast<double>(points.size());
  for (const Eigen::Vector2d& p : points) s.centre_m += p / s.count;
  for (const Eigen::Vector2d& p : points) s.scatter_m2 += (p - s.centre_m) * (p - s.centre_m).transpose();
  refit_line(s, points);
  return s;
}

std::pmr::vector<LineSegment> iterative_segments(std::span<const Eigen::Vector2d> object,
                                                 const ScanLineOptions& options) {
  std::pmr::vector<LineSegment> segments(scratch());
  struct PointRange {
    std::size_t first, last;  // both included
  };
  std::pmr::vector<PointRange> open(scratch());
  if (object.size() >= 2) open.push_back({0, object.size() - 1});
  while (!open.empty()) {
    const PointRange piece = open.back();
    open.pop_back();
    if (static_cast<int>(piece.last - piece.first) + 1 < std::max(2, options.min_points)) continue;
    // Line A x + B y + C = 0 through the ends P_a and P_z.
    const Eigen::Vector2d a = object[piece.first], z = object[piece.last];
    const double A = a.y() - z.y(), B = z.x() - a.x(), C = -A * a.x() - B * a.y();
    const double length = std::hypot(A, B);
    double farthest = 0.0;
    std::size_t m = piece.first;
    for (std::size_t i = piece.first + 1; i < piece.last; ++i) {
      const Eigen::Vector2d& p = object[i];
      const double d = length > 0 ? std::abs(A * p.x() + B * p.y() + C) / length : (p - a).norm();  // eq. 3
      if (d <= farthest) continue;
      farthest = d;
      m = i;
    }
    if (farthest >
        options.split_m) {  // the later half is pushed first, so that segments are in the order of the scan
      open.push_back({m, piece.last});
      open.push_back({piece.first, m});
      continue;
    }
    const LineSegment segment = fit_segment(object.subspan(piece.first, piece.last - piece.first + 1));
    if (segment.length_m() >= options.min_length_m) segments.push_back(segment);
  }
  return segments;
}

std::pmr::vector<LineSegment> scan_segments(const Scan& scan, const ScanLineOptions& options) {
  const std::pmr::vector<Eigen::Vector2d> points = scan_points(scan, options);
  const std::pmr::vector<std::size_t> first = cluster(points, std::abs(scan.angle_increment_rad), options);
  std::pmr::vector<LineSegment> segments(scratch());
  for (std::size_t k = 0; k + 1 < first.size(); ++k) {
    const auto object = std::span(points).subspan(first[k], first[k + 1] - first[k]);
    for (const LineSegment& s : iterative_segments(object, options)) segments.push_back(s);
  }
  return segments;
}

LineSegment transformed(const LineSegment& segment, const Pose& T) {
  const Eigen::Matrix2d R = T.rotation.toRotationMatrix().topLeftCorner<2, 2>();
  const Eigen::Vector2d t = T.translation_m.head<2>();
  LineSegment s = segment;
  s.centre_m = R * segment.centre_m + t;
  s.scatter_m2 = R * segment.scatter_m2 * R.transpose();
  const Eigen::Vector2d ends[] = {R * segment.from_m + t, R * segment.to_m + t};
  refit_line(s, ends);
  return s;
}

bool may_join(const LineSegment& a, const LineSegment& b, const LinkGate& gate) {
  // Normals may have opposite directions, because the origin can lie on either side of nearly the same line.
  const double turn = std::remainder(a.line.alpha_rad - b.line.alpha_rad, std::numbers::pi);
  if (std::abs(turn) > gate.angle_rad) return false;
  const LineSegment& longer = a.length_m() >= b.length_m() ? a : b;
  const LineSegment& other = a.length_m() >= b.length_m() ? b : a;
  for (const Eigen::Vector2d& end : {other.from_m, other.to_m})
    if (std::abs(longer.line.distance_m(end)) > gate.offset_m) return false;
  const double length = longer.length_m();
  const Eigen::Vector2d along = longer.along();
  const double t1 = along.dot(other.from_m - longer.from_m), t2 = along.dot(other.to_m - longer.from_m);
  return std::min(t1, t2) <= length + gate.gap_m && std::max(t1, t2) >= -gate.gap_m;
}

LineSegment joined(const LineSegment& a, const LineSegment& b) {
  LineSegment s;
  s.count = a.count + b.count;
  s.centre_m = (a.count * a.centre_m + b.count * b.centre_m) / s.count;
  const Eigen::Vector2d between = a.centre_m - b.centre_m;
  s.scatter_m2 = a.scatter_m2 + b.scatter_m2 + a.count * b.count / s.count * between * between.transpose();
  const Eigen::Vector2d ends[] = {a.from_m, a.to_m, b.from_m, b.to_m};
  refit_line(s, ends);
  return s;
}

}  // namespace octant
