// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Converts arrivals at receivers into distances of beacons from the vehicle's centre.
#include <limits>

#include "models/localizers/kleeman/kleeman.h"
#include "models/localizers/kleeman/kleeman_work.h"
#include "models/physics/range.h"

namespace octant {
namespace {

constexpr double kMaxPassShare = 0.95;  // largest ratio of threshold to predicted amplitude
constexpr double kMinPassDistance_m = 0.05;

}  // namespace

/// d = c (T - beacon's delay - receiver's delay), corrected for the drift of the vehicle's clock since the
/// first arrival of the epoch.
void Kleeman::gather(std::span<const Arrival> arrivals) noexcept {
  Work& w = *work_;
  w.heard.clear();
  w.arrivals = arrivals.size();
  w.vehicle = nullptr;
  if (arrivals.empty() || !arrivals.front().vehicle.valid() ||
      arrivals.front().vehicle.index() >= vehicles_.size())
    return;
  w.vehicle = &vehicles_[arrivals.front().vehicle.index()];
  const Noise& noise = deployment_.noise;
  const double pair_s = noise.pair_sigma_s.value_or(0.0);
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    const Arrival& a = arrivals[i];
    if (a.vehicle != arrivals.front().vehicle || !a.beacon.valid() ||
        a.beacon.index() >= deployment_.beacons.size())
      continue;
    const DeploymentBeacon& beacon = deployment_.beacons[a.beacon.index()];
    if (beacon.status == BeaconStatus::kUndetermined || !std::isfinite(a.tof_s) || !a.receiver.valid())
      continue;
    const std::size_t receiver = a.receiver.index() - w.vehicle->first_receiver;
    if (a.receiver.index() < w.vehicle->first_receiver || receiver >= w.vehicle->receivers.size()) continue;
    const ArrayReceiver& r = w.vehicle->receivers[receiver];
    w.speed_mps = deployment_.speed_mps(
        std::isfinite(a.temperature_degC) ? a.temperature_degC : deployment_.medium.temperature_degC);
    const double drifted_s = w.vehicle->drift * (a.time_s - arrivals.front().time_s);
    HeardDistance h;
    h.arrival = i;
    h.beacon = a.beacon.index();
    h.receiver = receiver;
    h.time_m = w.speed_mps * (a.tof_s - beacon.delay_s - r.delay_s - drifted_s);
    const double noise_m = w.speed_mps * std::hypot(noise.tof_sigma_s, pair_s);
    // With zero noise every rounding error would be an outlier, so a tenth of a micrometre is added.
    double variance_m2 = noise_m * noise_m + r.variance_m2 + 1e-14;
    if (deployment_.attenuation && deployment_.attenuation->measures(a.amplitude_v)) {
      const AttenuationModel& model = *deployment_.attenuation;
      const double share = std::min(model.threshold_v / a.amplitude_v, kMostMeasuredShare);
      h.time_m -= w.speed_mps * walk_of_share_s(share, model);  // walk at the measured amplitude
      const double spread_m =
          w.speed_mps * walk_by_log_amplitude_s(a.amplitude_v, model) * noise.amplitude_relative_sigma;
      variance_m2 += spread_m * spread_m;
      h.walk_known = true;
      h.log_amplitude = std::log(a.amplitude_v);
    }
    h.sigma_m = std::sqrt(variance_m2);
    h.slant_m = h.time_m;
    w.heard.push_back(h);
  }
}

void Kleeman::subtract_walk(HeardDistance& h, double distance_m, double log_directivity) const noexcept {
  if (!deployment_.attenuation || h.walk_known) return;
  const AttenuationModel& model = *deployment_.attenuation;
  const double amplitude =
      amplitude_v(std::max(distance_m, kMinPassDistance_m), model) * std::exp(log_directivity);
  const double share = std::min(model.threshold_v / amplitude, kMaxPassShare);
  h.slant_m = h.time_m - work_->speed_mps * walk_of_share_s(share, model);
}

/// First pass: uses the first arrival of each beacon and treats the array as a point. An arrival must be
/// confirmed by another one of the same beacon if there are several, because a spurious early pulse is
/// isolated.
void Kleeman::earliest() noexcept {
  Work& w = *work_;
  const Vehicle& v = *w.vehicle;
  w.distances.heard.reset();
  double walk_m =
      0.0;  // unknown without a distance: use that of the site's centre, with an equal uncertainty
  if (deployment_.attenuation) {
    double extent_m = 0.0;
    for (const Eigen::Vector3d& b : beacon_p_map_m_)
      extent_m = std::max(extent_m, (b - beacon_p_map_m_.front()).norm());
    for (HeardDistance& h : w.heard) {
      subtract_walk(h, extent_m / 2, 0.0);
      walk_m = std::max(walk_m, (h.time_m - h.slant_m) / 2);
    }
  }
  for (HeardDistance& h : w.heard) h.centred_m = h.slant_m;
  for (std::size_t b = 0; b < beacon_p_map_m_.size(); ++b) {
    keep_agreeing(b);
    double first_m = std::numeric_limits<double>::infinity(), sigma_m = 0.0;
    for (const HeardDistance& h : w.heard) {
      if (h.beacon != b || !h.kept || !(h.centred_m < first_m)) continue;
      first_m = h.centred_m;
      sigma_m = h.sigma_m;
    }
    if (!std::isfinite(first_m)) continue;
    w.distances.heard.set(b);
    w.distances.distance_m[b] = first_m;
    const DeploymentBeacon& beacon = deployment_.beacons[b];
    const double known_m = std::sqrt(beacon.covariance_m2.trace()) + w.speed_mps * beacon.delay_sigma_s;
    w.distances.sigma_m[b] = std::hypot(sigma_m, std::hypot(v.radius_m / 2, walk_m), known_m);
  }
}

/// Further passes: reduces every arrival to the vehicle's centre with the position and heading of the
/// previous pass.
void Kleeman::centre() noexcept {
  Work& w = *work_;
  const Vehicle& v = *w.vehicle;
  w.distances.heard.reset();
  for (HeardDistance& h : w.heard) {
    const ArrayReceiver& receiver = v.receivers[h.receiver];
    const ReceiverPath path =
        receiver_path(beacon_p_map_m_[h.beacon], receiver, w.solution.p_map_m, w.heading.rad);
    const bool off_axis = !h.walk_known && deployment_.attenuation &&
                          deployment_.attenuation->directional() && !receiver.direction.isZero();
    const double log_directivity =
        off_axis ? receiver_gain(beacon_p_map_m_[h.beacon], receiver, w.solution.p_map_m, w.heading.rad,
                                 *deployment_.attenuation)
                       .log_directivity
                 : 0.0;
    subtract_walk(h, path.slant_m, log_directivity);
    h.centred_m = h.slant_m + slant_distance_m(v.plan[h.beacon], w.solution.p_map_m) - path.slant_m;
  }
  for (std::size_t b = 0; b < beacon_p_map_m_.size(); ++b) {
    keep_agreeing(b);
    combine(b);
  }
}

/// Selects the consistent arrivals of a beacon: the first that another one confirms (the first of all if none
/// is confirmed), and those within noise and lever-arm uncertainty after it.
void Kleeman::keep_agreeing(std::size_t beacon) noexcept {
  Work& w = *work_;
  const bool first_pass = !w.heading_tried;
  const double lever_m =
      first_pass ? 0.0 : w.vehicle->radius_m * (w.heading.known ? std::min(w.heading.sigma_rad, 2.0) : 2.0);
  const double slack_m = first_pass ? 2 * w.vehicle->radius_m : 0.0;
  const auto gate_m = [&](const HeardDistance& a, const HeardDistance& b) {
    return options_.gate_sigmas *
               std::sqrt(a.sigma_m * a.sigma_m + b.sigma_m * b.sigma_m + 2 * lever_m * lever_m) +
           slack_m;
  };
  const HeardDistance *first = nullptr, *supported = nullptr;
  for (const HeardDistance& a : w.heard) {
    if (a.beacon != beacon) continue;
    if (first == nullptr || a.centred_m < first->centred_m) first = &a;
    if (supported != nullptr && a.centred_m >= supported->centred_m) continue;
    for (const HeardDistance& b : w.heard) {
      if (&a == &b || b.beacon != beacon || std::abs(a.centred_m - b.centred_m) > gate_m(a, b)) continue;
      supported = &a;
      break;
    }
  }
  if (first == nullptr) return;
  if (supported != nullptr) first = supported;
  for (HeardDistance& h : w.heard) {
    if (h.beacon == beacon)
      h.kept = h.centred_m >= first->centred_m && h.centred_m - first->centred_m <= gate_m(h, *first);
  }
}

/// Weighted mean of the selected arrivals. Errors of calibration and heading do not average out.
void Kleeman::combine(std::size_t beacon) noexcept {
  Work& w = *work_;
  double weight = 0.0, sum_m = 0.0, by_heading = 0.0;
  for (const HeardDistance& h : w.heard) {
    if (h.beacon != beacon || !h.kept) continue;
    const double wi = 1 / (h.sigma_m * h.sigma_m);
    weight += wi;
    sum_m += wi * h.centred_m;
    by_heading += wi * receiver_path(beacon_p_map_m_[beacon], w.vehicle->receivers[h.receiver],
                                     w.solution.p_map_m, w.heading.rad)
                           .by_heading;
  }
  if (!(weight > 0)) return;
  w.distances.heard.set(beacon);
  w.distances.distance_m[beacon] = sum_m / weight;
  const double turned_m = by_heading / weight * (w.heading.known ? w.heading.sigma_rad : M_PI);
  w.distances.sigma_m[beacon] = std::sqrt(1 / weight + calibration_variance_m2(beacon) + turned_m * turned_m);
}

/// The error estimates of triples assume equally accurate distances. A distance whose pulse barely exceeds
/// the threshold, as from a beacon high above, may be accurate to centimetres where others are to
/// millimetres. The position is better without it if four other beacons are received.
void Kleeman::set_rough_aside() noexcept {
  constexpr double kRough = 4.0;  // ratio to the median sigma
  constexpr std::size_t kEnough = 4;
  OffsetDistances& d = work_->distances;
  d.rough.reset();
  std::array<double, kKleemanBeacons> sigma_m{};
  std::size_t count = 0;
  for (std::size_t b = 0; b < beacon_p_map_m_.size(); ++b)
    if (d.heard[b]) sigma_m[count++] = d.sigma_m[b];
  if (count <= kEnough) return;
  std::sort(sigma_m.begin(), sigma_m.begin() + static_cast<std::ptrdiff_t>(count));
  const double limit_m = std::max(kRough * sigma_m[count / 2], sigma_m[kEnough - 1]);
  for (std::size_t b = 0; b < beacon_p_map_m_.size(); ++b) d.rough[b] = d.heard[b] && d.sigma_m[b] > limit_m;
}

/// Variance of a beacon's distance due to its position along the line of sight and its delay.
double Kleeman::calibration_variance_m2(std::size_t beacon) const noexcept {
  const DeploymentBeacon& b = deployment_.beacons[beacon];
  const Eigen::Vector3d to(b.position_m - Eigen::Vector3d(work_->solution.p_map_m.x(),
                                                          work_->solution.p_map_m.y(),
                                                          work_->vehicle->plane_m));
  const double delay_m = work_->speed_mps * b.delay_sigma_s, squared_m2 = to.squaredNorm();
  const double place_m2 =
      squared_m2 > 0 ? to.dot(b.covariance_m2 * to) / squared_m2 : b.covariance_m2.trace();
  return place_m2 + delay_m * delay_m;
}

}  // namespace octant
