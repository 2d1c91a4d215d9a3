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
  double range_max_m = std::numeric_limits<double>::infinity();  ///< a beam this long or longer saw nothing
  double gap_m = 0.3;      ///< eq. 2: neighbours farther apart are of different objects
  double gap_beams = 4.0;  ///< the same as a multiple of the beams' spacing at that range; the larger one
                           ///< counts. 0: eq. 2 alone
  double split_m = 0.06;   ///< eq. 3: a point farther off the line of an object's ends splits it
  int min_points = 8;      ///< of a segment
  double min_length_m = 0.3;
};

/// A straight line in normal form, c = x cos(alpha) + y sin(alpha) (eq. 4), with c >= 0 and alpha in (-pi,
/// pi].
struct NormalLine {
  double c_m = 0.0;
  double alpha_rad = 0.0;
  [[nodiscard]] Eigen::Vector2d normal() const { return direction_of(alpha_rad); }
  [[nodiscard]] double distance_m(const Eigen::Vector2d& p) const { return normal().dot(p) - c_m; }
};

/// Points on a line, as sums that may be added: a segment seen again makes one with both.
struct LineSegment {
  NormalLine line;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero(), to_m = Eigen::Vector2d::Zero();  ///< ends, on the line
  double count = 0.0;                                                                ///< points
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();                                ///< their mean
  Eigen::Matrix2d scatter_m2 = Eigen::Matrix2d::Zero();  ///< sum of (p - centre)(p - centre)'
  double rms_m = 0.0;                                    ///< of the distances from the line
  [[nodiscard]] double length_m() const { return (to_m - from_m).norm(); }
  /// Unit vector from end to end.
  [[nodiscard]] Eigen::Vector2d along() const { return (to_m - from_m) / std::max(length_m(), 1e-12); }
};

/// Ends of the beams in the sensor's frame, in the order of the scan; beams that saw nothing are left out.
[[nodiscard]] std::pmr::vector<Eigen::Vector2d> scan_points(const Scan& scan,
                                                            const ScanLineOptions& options = {});

/// Division of the points into objects (Smieszek eq. 2): indices of the first point of each, and one past the
/// last.
[[nodiscard]] std::pmr::vector<std::size_t> cluster(std::span<const Eigen::Vector2d> points, double beam_rad,
                                                    const ScanLineOptions& options = {});

/// Straight line through points by total least squares. @param points two or more, not all the same
[[nodiscard]] LineSegment fit_segment(std::span<const Eigen::Vector2d> points);

/// Segments of one object by iterative generation (Smieszek eq. 3): the line through its ends, split at the
/// farthest point until all are within split_m; each then fitted.
[[nodiscard]] std::pmr::vector<LineSegment> iterative_segments(std::span<const Eigen::Vector2d> object,
                                                               const ScanLineOptions& options = {});

/// All segments of a scan: points, objects, segments.
[[nodiscard]] std::pmr::vector<LineSegment> scan_segments(const Scan& scan,
                                                          const ScanLineOptions& options = {});

/// The segment in another frame.
[[nodiscard]] LineSegment transformed(const LineSegment& segment, const Pose& T_to_from);

struct LinkGate {
  double angle_rad = 0.1;
  double offset_m = 0.15;  ///< of either end from the other's line
  double gap_m = 0.3;      ///< between them, along the line
};

/// Whether two segments of one frame may be parts of one.
[[nodiscard]] bool may_join(const LineSegment& a, const LineSegment& b, const LinkGate& gate);
/// Both together.
[[nodiscard]] LineSegment joined(const LineSegment& a, const LineSegment& b);

}  // namespace octant
