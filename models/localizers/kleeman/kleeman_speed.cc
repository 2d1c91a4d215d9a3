// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// "The inherent redundancy in the data to minimise the solution distance discrepancy by varying the speed of
// sound" (section 5.1).
#include "models/localizers/kleeman/kleeman_work.h"
#include "models/support/observed.h"

namespace octant {

/// Discrepancy of all epochs at one speed, and its derivatives by the scale. A beacon that disagrees costs
/// the gate squared, so that no speed wins by making beacons disagree.
struct Kleeman::SpeedNormal {
  double discrepancy = 0.0, gradient = 0.0, information = 0.0;
  int epochs = 0;
};

Kleeman::SpeedNormal Kleeman::speed_normal(std::span<const Arrival> arrivals, double scale) noexcept {
  SpeedNormal sum;
  Work& w = *work_;
  const double gate = options_.longsolve.deviation_sigmas * options_.longsolve.deviation_sigmas;
  for (std::size_t first = 0, last = 0; first < arrivals.size(); first = last) {
    while (last < arrivals.size() && arrivals[last].epoch == arrivals[first].epoch &&
           arrivals[last].vehicle == arrivals[first].vehicle)
      ++last;
    const FixStatus status = place(arrivals.subspan(first, last - first), scale);
    if (w.vehicle == nullptr) continue;
    const LongsolveFix& s = w.solution;
    const BeaconSet agreeing = status == FixStatus::kOk ? s.agreeing : BeaconSet();
    sum.discrepancy += gate * static_cast<double>((w.distances.heard & ~agreeing).count());
    if (agreeing.count() < 4) continue;
    // Least squares of the agreeing distances over x, y and the offset; what is left is the discrepancy, and
    // `free_` is what is left of a change of the speed.
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b_residual = Eigen::Vector3d::Zero(), b_length = Eigen::Vector3d::Zero();
    double rr = 0.0, rv = 0.0, vv = 0.0;
    for (std::size_t b = 0; b < beacon_p_map_m_.size(); ++b) {
      if (!agreeing[b]) continue;
      const double weight = 1 / (w.distances.sigma_m[b] * w.distances.sigma_m[b]);
      const Eigen::Vector2d e = foreshortened(w.vehicle->plan[b], s.p_map_m);
      const Eigen::Vector3d row(-e.x(), -e.y(), 1.0);
      const double length_m = slant_distance_m(w.vehicle->plan[b], s.p_map_m), r = s.residual_m[b];
      N += weight * row * row.transpose();
      b_residual += weight * r * row;
      b_length += weight * length_m * row;
      rr += weight * r * r;
      rv += weight * r * length_m;
      vv += weight * length_m * length_m;
    }
    const ObservedState<Eigen::Matrix3d> observed(N);
    if (!observed.all()) continue;
    const Eigen::Vector3d solved = observed.solve(b_length);
    sum.discrepancy += rr - b_residual.dot(observed.solve(b_residual));
    sum.gradient += rv - b_residual.dot(solved);
    sum.information += vv - b_length.dot(solved);
    ++sum.epochs;
  }
  return sum;
}

SpeedEstimate Kleeman::estimate_speed(std::span<const Arrival> arrivals) noexcept {
  SpeedEstimate estimate;
  work_->searching_speed = true;  // its sigma must not excuse what it is searched by
  double least = 0.0;
  bool any = false;
  const int steps = static_cast<int>(std::lround(options_.speed_span / options_.speed_step));
  for (int i = -steps; i <= steps; ++i) {
    const double scale = scale_ * (1 + i * options_.speed_step);
    const SpeedNormal normal = speed_normal(arrivals, scale);
    if (normal.epochs == 0 || (any && normal.discrepancy >= least)) continue;
    any = true;
    least = normal.discrepancy;
    estimate.scale = scale;
  }
  // Between the steps: the discrepancy is a parabola there.
  SpeedNormal normal;
  for (int i = 0; any && i < 6; ++i) {
    normal = speed_normal(arrivals, estimate.scale);
    if (normal.epochs == 0 || !(normal.information > 0)) break;
    const double step =
        std::clamp(-normal.gradient / normal.information, -options_.speed_step, options_.speed_step);
    estimate.scale += step * estimate.scale;
    if (std::abs(step) < 1e-9) break;
  }
  work_->searching_speed = false;
  if (!any || normal.epochs == 0) return estimate;
  estimate.epochs = normal.epochs;
  estimate.speed_mps = estimate.scale * deployment_.speed_mps(deployment_.medium.temperature_degC);
  const double relative = normal.information > 0 ? 1 / std::sqrt(normal.information) : 1.0;
  estimate.sigma_mps = relative * estimate.speed_mps;
  estimate.status = relative <= options_.max_speed_sigma ? FixStatus::kOk : FixStatus::kPoorGeometry;
  return estimate;
}

}  // namespace octant
