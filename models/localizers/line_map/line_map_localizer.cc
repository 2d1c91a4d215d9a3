// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/line_map/line_map_localizer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "models/localizers/common/localizer.h"
#include "models/localizers/line_map/line_matching.h"
#include "models/physics/plane.h"
#include "models/support/decompositions.h"

namespace octant {
namespace {

constexpr double kExact = 1e-4;  // m, rad: lower bound of the sigmas of an exact start
constexpr std::size_t kScanScratchBytes =
    4u << 20;                          // for a scan of a thousand beams and a map of hundreds of walls
constexpr double kSameSquared = 16.0;  // square of four sigmas: tracks within this distance are merged

bool same_pose(const OdometryState& a, const OdometryState& b) {
  const Eigen::Vector3d d = difference(b, a);
  return d.dot((a.covariance + b.covariance).inverse() * d) < kSameSquared;
}

/// Covariance of the pose error caused by the errors e of the walls. The pose absorbs P B e of them and keeps
/// P P0^-1 of its previous error. The errors are constant while the same walls are in view, so both parts are
/// treated as fully correlated: deviations are added, not variances. The pose error then converges to that of
/// the walls. The sum is formed along axes that diagonalise both P0^-1 and the new information, so that an
/// axis without information stays unchanged.
Eigen::Matrix3d with_walls(const Eigen::Matrix3d& before, const Eigen::Matrix3d& P0,
                           const Eigen::Matrix3d& spread, const Eigen::Matrix3d& P) {
  const Eigen::Matrix3d L = P0.llt().matrixL(), P0_inverse = P0.inverse();
  const Eigen::Matrix3d seen = L.transpose() * (P.inverse() - P0_inverse) * L;
  const SymmetricEigen<Eigen::Matrix3d> axes((seen + seen.transpose()) / 2);
  const Eigen::Matrix3d V = L * axes.eigenvectors(), V_inverse = V.inverse();
  const Eigen::Matrix3d kept = V_inverse * P * P0_inverse, taken = V_inverse * P;
  const Eigen::Matrix3d old = kept * before * kept.transpose(), fresh = taken * spread * taken.transpose();
  const Eigen::Matrix3d sum = old + fresh;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  for (int i = 0; i < 3; ++i) {
    const double deviation = std::sqrt(std::max(0.0, old(i, i))) + std::sqrt(std::max(0.0, fresh(i, i)));
    if (sum(i, i) > 0) scale[i] = deviation / std::sqrt(sum(i, i));
  }
  return V * scale.asDiagonal() * sum * scale.asDiagonal() * V.transpose();
}

}  // namespace

LineMapLocalizer::LineMapLocalizer(LineMap map, LineMapOptions options)
    : map_(std::move(map)), options_(options), scratch_(kScanScratchBytes) {
  tracks_.reserve(static_cast<std::size_t>(std::max(1, options_.max_hypotheses)));
  for (std::size_t k = 0; k < map_.lines.size(); ++k) walls_.push_back(static_cast<int>(k));
}

void LineMapLocalizer::start(const Pose& T_map_vehicle, const PoseAccuracy& start_accuracy,
                             const OdometryAccuracy& odometry_accuracy) noexcept {
  Track first;
  first.state = {T_map_vehicle.translation_m.head<2>(), T_map_vehicle.heading_rad()};
  const double start_m = std::max(start_accuracy.position_sigma_m, kExact);
  const double start_rad =
      start_accuracy.heading_known ? std::max(start_accuracy.heading_sigma_rad, kExact) : std::numbers::pi;
  first.state.covariance.diagonal() << square(start_m), square(start_m), square(start_rad);
  tracks_.assign(1, first);
  odometry_accuracy_ = odometry_accuracy;
  odometry_accuracy_.heading_sigma_per_rad =
      std::max(odometry_accuracy.heading_sigma_per_rad, options_.turn_sigma_per_rad);
  first_scan_ = true;
  on_wall_share_ = 1.0;
}

void LineMapLocalizer::move(const OdometryStep& step, double fraction) noexcept {
  for (Track& track : tracks_) {
    const Eigen::Matrix3d F = advance(track.state, step, odometry_accuracy_, fraction);
    track.of_map = F * track.of_map * F.transpose();
  }
}

void LineMapLocalizer::locate(const Scan& scan, Fix& fix) noexcept {
  clear(fix);
  fix.time_s = scan.time_s;
  fix.status = FixStatus::kPoorGeometry;
  if (tracks_.empty()) return;
  const Eigen::Vector3d slip(square(options_.step_sigma_m), square(options_.step_sigma_m),
                             square(options_.step_sigma_rad));
  if (!first_scan_)
    for (Track& track : tracks_) track.state.covariance.diagonal() += slip;
  first_scan_ = false;
  const ScratchScope scope(scratch_);
  correct(scan, fix);
  report(fix);
}

std::vector<Fix> LineMapLocalizer::locate(const MeasurementLog& log) {
  if (!line_map_fits(map_, log)) return {};
  return locate(log.scans, log.odometry, log.odometry_accuracy, log.poses.front(), log.pose_accuracy);
}

std::vector<Fix> LineMapLocalizer::locate(std::span<const Scan> scans, std::span<const OdometryStep> odometry,
                                          const OdometryAccuracy& accuracy, const TimedPose& begin,
                                          const PoseAccuracy& start_accuracy) {
  start(begin.T_map_vehicle, start_accuracy, accuracy);
  OdometryCursor cursor(odometry, begin.time_s);
  std::vector<Fix> fixes;
  for (const Scan& scan : scans) {
    if (scan.time_s < begin.time_s) continue;
    cursor.advance_to(scan.time_s,
                      [this](const OdometryStep& step, double fraction) { move(step, fraction); });
    locate(scan, fixes.emplace_back());
    fixes.back().vehicle = odometry.empty() ? VehicleId() : odometry.front().vehicle;
  }
  return fixes;
}

/// Extends each track by every match that the scan allows, and keeps the most likely distinct ones, best
/// first.
void LineMapLocalizer::correct(const Scan& scan, Fix& fix) {
  struct Way {
    Track track;
    std::pmr::vector<int> wall;  ///< matched wall of each segment; -1: none
  };
  const std::pmr::vector<Eigen::Vector2d> points = scan_points(scan, options_.scan);
  const std::pmr::vector<LineSegment> segments = scan_segments(scan, options_.scan);
  std::pmr::vector<Way> ways(scratch());
  for (const Track& track : tracks_) {
    for (WallMatches& m : match_walls(track.state, segments, points, map_, options_)) {
      const Eigen::Matrix3d of_map =
          with_walls(track.of_map, track.state.covariance, m.wall_spread, m.state.covariance);
      ways.push_back({{m.state, of_map, track.cost + m.cost}, std::move(m.wall)});
    }
  }
  std::pmr::vector<std::size_t> order(ways.size(), scratch());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return ways[a].track.cost != ways[b].track.cost ? ways[a].track.cost < ways[b].track.cost : a < b;
  });
  tracks_.clear();
  const Way& best = ways[order.front()];
  for (const std::size_t i : order) {
    const Track& track = ways[i].track;
    if (static_cast<int>(tracks_.size()) >= options_.max_hypotheses) break;
    if (!tracks_.empty() && track.cost > best.track.cost + options_.forget_margin) break;
    const bool is_known =
        std::ranges::any_of(tracks_, [&](const Track& kept) { return same_pose(kept.state, track.state); });
    if (!is_known) tracks_.push_back(track);
  }
  for (Track& track : tracks_) track.cost -= best.track.cost;
  if (const MapSupport seen = map_support(tracks_.front().state, points, map_, walls_, options_);
      seen.points > 0)
    on_wall_share_ +=
        (static_cast<double>(seen.on_wall) / seen.points - on_wall_share_) / options_.on_wall_scans;
  for (const int k : best.wall) {
    fix.rejections.push_back(k >= 0 ? Rejection::kUsed : Rejection::kOutvoted);
    ++(k >= 0 ? fix.arrivals_used : fix.arrivals_rejected);
  }
}

void LineMapLocalizer::report(Fix& fix) const {
  const Track& best = tracks_.front();
  fix.T_map_vehicle = best.state.pose();
  fix.covariance = best.state.covariance + best.of_map;
  const SymmetricEigen<Eigen::Matrix2d> axes(Eigen::Matrix2d(fix.covariance.topLeftCorner<2, 2>()));
  fix.status = FixStatus::kOk;
  if (tracks_.size() > 1 && tracks_[1].cost < options_.ambiguity_margin) fix.status = FixStatus::kAmbiguous;
  if (!map_.lines.empty() && on_wall_share_ < options_.least_on_wall) fix.status = FixStatus::kNoConsensus;
  if (!(axes.eigenvalues().maxCoeff() < square(options_.max_sigma_m))) fix.status = FixStatus::kPoorGeometry;
}

}  // namespace octant
