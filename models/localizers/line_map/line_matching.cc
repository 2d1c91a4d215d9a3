// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/line_map/line_matching.h"
#include "models/physics/plane.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace octant {
namespace {

constexpr int kRounds = 4;
constexpr double kReach_sigmas = 3.0;

class Matcher {
 public:
  Matcher(const OdometryState& prior, std::span<const LineSegment> segments,
          std::span<const Eigen::Vector2d> points, const LineMap& map, const LineMapOptions& options)
      : prior_(prior),
        prior_information_(prior.covariance.inverse()),
        segments_(segments),
        points_(points),
        map_(map),
        options_(options),
        outlier_(square(options.gate_probability_sigmas)),
        clutter_(2 * std::log(4 * options.max_offset_m * options.max_angle_rad * (1 - options.clutter_share) /
                              options.clutter_share)) {
    double reach_m = 2 * options.max_offset_m;
    for (const Eigen::Vector2d& p : points) reach_m = std::max(reach_m, p.norm() + 2 * options.max_offset_m);
    for (std::size_t k = 0; k < map.lines.size(); ++k) {
      const LineSegment& w = map.lines[k].segment;
      if (distance_from_segment(w.from_m, w.to_m, prior.p_map_m) < reach_m)
        near_.push_back(static_cast<int>(k));
    }
    for (std::size_t i = 0; i < segments.size(); ++i) {
      first_candidate_.push_back(candidate_.size());
      for (std::size_t k = 0; k < map.lines.size(); ++k)
        if (distance(prior, prior.covariance, i, k) < outlier_) candidate_.push_back(static_cast<int>(k));
    }
    first_candidate_.push_back(candidate_.size());
  }

  std::pmr::vector<WallMatches> run() {
    std::pmr::vector<WallMatches> all(scratch());
    const auto consider = [&](int segment, int wall) {
      WallMatches m;
      m.wall.assign(segments_.size(), -1);
      m.state = prior_;
      if (segment >= 0) m.wall[static_cast<std::size_t>(segment)] = wall;
      m = follow(std::move(m));
      // Seeds of one pose lead to the same matches.
      if (std::ranges::any_of(all, [&](const WallMatches& other) { return other.wall == m.wall; })) return;
      if (m.matched > 0) {
        const MapSupport support = map_support(m.state, points_, map_, near_, options_);
        m.cost += options_.through_cost * support.through +
                  options_.on_wall_gain * (options_.chance_share * support.points - support.on_wall);
      }
      all.push_back(std::move(m));
    };
    consider(-1, -1);
    for (std::size_t i = 0; i < segments_.size(); ++i)
      for (const int k : candidates(i)) consider(static_cast<int>(i), k);
    return all;
  }

 private:
  [[nodiscard]] std::span<const int> candidates(std::size_t segment) const {
    return std::span(candidate_)
        .subspan(first_candidate_[segment], first_candidate_[segment + 1] - first_candidate_[segment]);
  }
  /// Squared normalised distance of a segment from a wall, seen from a pose; beyond the gate if it cannot be
  /// that wall.
  [[nodiscard]] double distance(const OdometryState& at, const Eigen::Matrix3d& P, std::size_t segment,
                                std::size_t wall) const {
    const LineSegment& s = segments_[segment];
    const LineSegment& w = map_.lines[wall].segment;
    const double turn =
        std::remainder(s.line.alpha_rad + at.heading_rad - w.line.alpha_rad, std::numbers::pi);
    if (std::abs(turn) > options_.max_angle_rad) return std::numeric_limits<double>::infinity();
    const Eigen::Vector2d p = at.p_map_m + Eigen::Rotation2Dd(at.heading_rad) * s.centre_m;
    if (std::abs(w.line.distance_m(p)) > options_.max_offset_m)
      return std::numeric_limits<double>::infinity();
    const Eigen::Vector2d along = w.along();
    const double slack_m =
        options_.join.gap_m + kReach_sigmas * std::sqrt(along.dot(P.topLeftCorner<2, 2>() * along));
    const double t = along.dot(p - w.from_m);
    if (t < -slack_m || t > w.length_m() + slack_m) return std::numeric_limits<double>::infinity();
    const WallObservation o = observe_wall(at, s, w, options_);
    Eigen::Matrix2d S = o.H * P * o.H.transpose();
    S.diagonal() += o.noise + Eigen::Vector2d(square(options_.map_sigma_m), square(options_.map_sigma_rad));
    return o.residual.dot(S.inverse() * o.residual);
  }

  /// Extends a seed to a consistent set of matches: adjusts and matches again under the smaller covariance
  /// until the matches do not change.
  [[nodiscard]] WallMatches follow(WallMatches m) const {
    std::pmr::vector<int> wall(segments_.size(), -1, scratch());
    for (int round = 0; round < kRounds; ++round) {
      adjust(m);
      std::ranges::fill(wall, -1);
      for (std::size_t i = 0; i < segments_.size(); ++i) {
        double nearest = outlier_;
        for (const int k : candidates(i)) {
          const double d = distance(m.state, m.state.covariance, i, static_cast<std::size_t>(k));
          if (d >= nearest) continue;
          nearest = d;
          wall[i] = k;
        }
      }
      if (wall == m.wall) break;
      m.wall = wall;
    }
    adjust(m);
    return m;
  }

  /// Gauss-Newton on prior and matched segments.
  void adjust(WallMatches& m) const {
    const Eigen::Vector2d wall_variance(square(options_.map_sigma_m), square(options_.map_sigma_rad));
    for (int step = 0; step < 3; ++step) {
      const Eigen::Vector3d moved = difference(prior_, m.state);
      Eigen::Matrix3d information = prior_information_;
      Eigen::Vector3d gradient = prior_information_ * moved;
      m.cost = moved.dot(prior_information_ * moved);
      m.wall_spread.setZero();
      m.matched = 0;
      for (std::size_t i = 0; i < segments_.size(); ++i) {
        if (m.wall[i] < 0) {
          m.cost += clutter_;
          continue;
        }
        const WallObservation o = observe_wall(
            m.state, segments_[i], map_.lines[static_cast<std::size_t>(m.wall[i])].segment, options_);
        const Eigen::Matrix<double, 3, 2> HtW = o.H.transpose() * o.noise.cwiseInverse().asDiagonal();
        information += HtW * o.H;
        gradient += HtW * o.residual;
        m.wall_spread += HtW * wall_variance.asDiagonal() * HtW.transpose();
        const Eigen::Vector2d variance = o.noise + wall_variance;
        m.cost += o.residual.dot(variance.cwiseInverse().asDiagonal() * o.residual) +
                  std::log(square(2 * std::numbers::pi) * variance.prod());
        ++m.matched;
      }
      m.state.covariance = information.inverse();
      m.cost += std::log(prior_.covariance.determinant() / m.state.covariance.determinant());
      const Eigen::Vector3d change = m.state.covariance * gradient;
      m.state.p_map_m += change.head<2>();
      m.state.heading_rad = wrap_angle(m.state.heading_rad + change.z());
      if (change.cwiseAbs().maxCoeff() < 1e-6) break;
    }
  }

  const OdometryState& prior_;
  Eigen::Matrix3d prior_information_;
  std::span<const LineSegment> segments_;
  std::span<const Eigen::Vector2d> points_;
  std::pmr::vector<int> near_{scratch()};  ///< walls within the range of the scan
  const LineMap& map_;
  const LineMapOptions& options_;
  double outlier_;
  double clutter_;                              ///< cost of an unmatched segment
  std::pmr::vector<int> candidate_{scratch()};  ///< candidate walls of each segment, segment by segment
  std::pmr::vector<std::size_t> first_candidate_{scratch()};
};

}  // namespace

WallObservation observe_wall(const OdometryState& pose, const LineSegment& segment, const LineSegment& wall,
                             const LineMapOptions& options) {
  const Eigen::Vector2d lever = Eigen::Rotation2Dd(pose.heading_rad) * segment.centre_m;
  const Eigen::Vector2d normal = wall.line.normal();
  const double beam_m = std::max(options.range_sigma_m, segment.rms_m),
               length_m = std::max(segment.length_m(), 1e-6);
  WallObservation o;
  // Walls have no orientation: the sensor may be on either side.
  o.residual = {
      -wall.line.distance_m(pose.p_map_m + lever),
      -std::remainder(segment.line.alpha_rad + pose.heading_rad - wall.line.alpha_rad, std::numbers::pi)};
  o.H << normal.x(), normal.y(), normal.dot(left_of(lever)), 0.0, 0.0, 1.0;
  // Variances of mean and slope of `count` points spread evenly over the length.
  o.noise = {square(beam_m) / segment.count + square(options.line_sigma_m),
             12 * square(beam_m / length_m) / segment.count + square(options.line_sigma_rad)};
  return o;
}

MapSupport map_support(const OdometryState& pose, std::span<const Eigen::Vector2d> points, const LineMap& map,
                       std::span<const int> walls, const LineMapOptions& options) {
  MapSupport support;
  const Eigen::Rotation2Dd R(pose.heading_rad);
  for (std::size_t i = 0; i < points.size();
       i += static_cast<std::size_t>(std::max(1, options.support_every))) {
    const Eigen::Vector2d beam = R * points[i], end = pose.p_map_m + beam;
    bool on_wall = false, through = false;
    for (const int k : walls) {
      const LineSegment& w = map.lines[static_cast<std::size_t>(k)].segment;
      const double start_off = w.line.distance_m(pose.p_map_m), end_off = w.line.distance_m(end);
      const Eigen::Vector2d along = w.along();
      if (std::abs(end_off) < options.hit_m) {
        const double t = along.dot(end - w.from_m);
        on_wall = on_wall || (t > -options.hit_m && t < w.length_m() + options.hit_m);
      } else if (start_off * end_off < 0 && std::abs(end_off) > 3 * options.hit_m &&
                 std::abs(start_off) > options.hit_m) {
        // Well inside the wall, because its ends may be door posts.
        const double t = along.dot(pose.p_map_m + beam * (start_off / (start_off - end_off)) - w.from_m);
        through = through || (t > 3 * options.hit_m && t < w.length_m() - 3 * options.hit_m);
      }
    }
    ++support.points;
    if (through) {
      ++support.through;
    } else if (on_wall) {
      ++support.on_wall;
    }
  }
  return support;
}

std::pmr::vector<WallMatches> match_walls(const OdometryState& prior, std::span<const LineSegment> segments,
                                          std::span<const Eigen::Vector2d> points, const LineMap& map,
                                          const LineMapOptions& options) {
  return Matcher(prior, segments, points, map, options).run();
}

}  // namespace octant
