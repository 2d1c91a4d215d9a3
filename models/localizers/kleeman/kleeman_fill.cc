// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Converts the solution of longsolve into a fix with its covariance.
#include <numbers>

#include <Eigen/LU>

#include "models/localizers/kleeman/kleeman.h"
#include "models/localizers/kleeman/kleeman_work.h"

namespace octant {

void Kleeman::fill(std::span<const Arrival> arrivals, Fix& fix) const noexcept {
  const Work& w = *work_;
  const LongsolveFix& s = w.solution;
  fix.T_map_vehicle = Pose::planar(s.p_map_m.x(), s.p_map_m.y(), w.heading.rad);
  // Arrivals that gather() skipped: an unusable beacon, another vehicle, or no valid time.
  fix.rejections.assign(arrivals.size(), Rejection::kBeaconUnusable);
  for (const HeardDistance& h : w.heard) {
    Rejection& why = fix.rejections[h.arrival];
    const double residual_m =
        h.centred_m - s.offset_m - slant_distance_m(w.vehicle->plan[h.beacon], s.p_map_m);
    if (w.impossible[h.beacon]) {
      why = Rejection::kTriangle;
    } else if (!s.agreeing[h.beacon]) {
      why = s.early[h.beacon] ? Rejection::kEarly : Rejection::kOutvoted;
    } else if (!h.kept) {
      why = residual_m > 0 ? Rejection::kLate : Rejection::kEarly;
    } else if (!s.averaged[h.beacon]) {
      why = Rejection::kNotNeeded;
    } else {
      why = Rejection::kUsed;
      fix.cost += residual_m * residual_m / (2 * h.sigma_m * h.sigma_m);
      ++fix.arrivals_used;
    }
  }
  fix.arrivals_rejected = static_cast<int>(arrivals.size()) - fix.arrivals_used;
}

/// The passes converge to P = A m(P, theta) and theta = theta(P), with the gain A of longsolve and the
/// distances m from the centre. With B = A dm/dP, g = A dm/dtheta, h = dtheta/dP,
///   [I - B  -g] [dP    ]   [A dm    ]
///   [ -h     1] [dtheta] = [dtheta|P]
/// The right-hand side has the noise of the beacons' means and that of the differences within beacons, which
/// are independent.
void Kleeman::propagate(Fix& fix) const noexcept {
  const Work& w = *work_;
  const LongsolveFix& s = w.solution;
  const Vehicle& v = *w.vehicle;
  Eigen::Matrix3d M = Eigen::Matrix3d::Identity(), C = Eigen::Matrix3d::Zero();
  Eigen::Vector2d by_scale = Eigen::Vector2d::Zero();
  for (std::size_t b = 0; b < beacon_p_map_m_.size(); ++b) {
    if (!s.averaged[b]) continue;
    double weight = 0.0, by_heading = 0.0;
    Eigen::RowVector2d by_position = Eigen::RowVector2d::Zero();
    for (const HeardDistance& h : w.heard) {
      if (h.beacon != b || !h.kept) continue;
      const double wi = 1 / (h.sigma_m * h.sigma_m);
      const ReceiverPath path =
          receiver_path(beacon_p_map_m_[b], v.receivers[h.receiver], s.p_map_m, w.heading.rad);
      weight += wi;
      by_heading -= wi * path.by_heading;
      by_position -= wi * (path.by_position + foreshortened(v.plan[b], s.p_map_m).transpose());
    }
    if (!(weight > 0)) continue;
    const Eigen::Vector2d gain = s.gain.col(static_cast<int>(b));
    C.topLeftCorner<2, 2>() += gain * gain.transpose() * (1 / weight + calibration_variance_m2(b));
    M.topLeftCorner<2, 2>() -= gain * by_position / weight;
    M.topRightCorner<2, 1>() -= gain * by_heading / weight;
    by_scale += gain * slant_distance_m(v.plan[b], s.p_map_m);
  }
  const double scale_sigma = deployment_.speed_sigma_mps / w.speed_mps;
  C.topLeftCorner<2, 2>() += by_scale * by_scale.transpose() * (scale_sigma * scale_sigma);
  C(2, 2) = w.heading.known ? w.heading.sigma_rad * w.heading.sigma_rad : std::numbers::pi * std::numbers::pi;
  if (w.heading.known) M.bottomLeftCorner<1, 2>() = -w.heading.by_position;
  const Eigen::Matrix3d inverse = M.inverse();
  const Eigen::Matrix3d covariance = inverse * C * inverse.transpose();
  fix.covariance = (covariance + covariance.transpose()) / 2;
}

}  // namespace octant
