// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/physics/plane.h"
#include "models/physics/pose.h"
#include "models/run.h"
#include "models/support/scratch.h"

namespace octant {

struct ScanLineOptions {
  double range_max_m =
      std::numeric_limits<double>::infinity();  ///< beams of this length or more have no echo
  double gap_m = 0.3;      ///< eq. 2: neighbours farther apart belong to different objects
  double gap_beams = 4.0;  ///< gap as a multiple of the spacing of the beams at that range; the larger gap
                           ///< counts. 0: eq. 2 alone
  double split_m = 0.06;  ///< eq. 3: a point farther from the line between an object's ends splits the object
  int min_points = 8;     ///< smallest number of points in a segment
  double min_length_m = 0.3;
};

/// Straight line in normal form, c = x cos(alpha) + y sin(alpha) (eq. 4), with c >= 0 and alpha in (-pi, pi].
struct NormalLine {
  double c_m = 0.0;
  double alpha_rad = 0.0;
  [[nodiscard]] Eigen::Vector2d normal() const { return direction_of(alpha_rad); }
  [[nodiscard]] double distance_m(const Eigen::Vector2d& p) const { return normal().dot(p) - c_m; }
};

/// Points on a line as sums, which are added to merge segments of one wall.
struct LineSegment {
  NormalLine line;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero(),
                  to_m = Eigen::Vector2d::Zero();        ///< end points on the line
  double count = 0.0;                                    ///< number of points
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();    ///< mean of the points
  Eigen::Matrix2d scatter_m2 = Eigen::Matrix2d::Zero();  ///< sum of (p - centre)(p - centre)'
  double rms_m = 0.0;                                    ///< root mean square of the distances from the line
  [[nodiscard]] double length_m() const { return (to_m - from_m).norm(); }
  /// Unit vector from end to end.
  [[nodiscard]] Eigen::Vector2d along() const { return (to_m - from_m) / std::max(length_m(), 1e-12); }
};

/// End points of the beams in the sensor's frame, in the order of the scan; beams without echo are omitted.
[[nodiscard]] std::pmr::vector<Eigen::Vector2d> scan_points(const Scan& scan,
                                                            const ScanLineOptions& options = {});

/// Splits the points into objects (Smieszek eq. 2). Returns the index of the first point of each object, and
/// one past the last point.
[[nodiscard]] std::pmr::vector<std::size_t> cluster(std::span<const Eigen::Vector2d> points, double beam_rad,
                                                    const ScanLineOptions& options = {});

/// Straight line through points by total least squares. @param points at least two distinct points
[[nodiscard]] LineSegment fit_segment(std::span<const Eigen::Vector2d> points);

/// Segments of one object by iterative generation (Smieszek eq. 3): the line through its ends is split at the
/// farthest point until all points are within split_m, then each part is fitted.
[[nodiscard]] std::pmr::vector<LineSegment> iterative_segments(std::span<const Eigen::Vector2d> object,
                                                               const ScanLineOptions& options = {});

/// All segments of a scan: points, then objects, then segments.
[[nodiscard]] std::pmr::vector<LineSegment> scan_segments(const Scan& scan,
                                                          const ScanLineOptions& options = {});

/// Transforms a segment into another frame.
[[nodiscard]] LineSegment transformed(const LineSegment& segment, const Pose& T_to_from);

struct LinkGate {
  double angle_rad = 0.1;
  double offset_m = 0.15;  ///< distance of either end from the other segment's line
  double gap_m = 0.3;      ///< gap between the segments along the line
};

/// Returns true if two segments in one frame may belong to the same wall.
[[nodiscard]] bool may_join(const LineSegment& a, const LineSegment& b, const LinkGate& gate);
/// Merges two segments.
[[nodiscard]] LineSegment joined(const LineSegment& a, const LineSegment& b);

}  // namespace octant
