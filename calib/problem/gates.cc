// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/gates.h"

#include <algorithm>
#include <cmath>

#include "calib/problem/ranges.h"
#include "models/localizers/common/range_gates.h"
#include "models/support/parallel.h"
#include "models/trajectory/observed_range.h"

namespace octant::calib {
namespace {

constexpr double kSigmas = 4.0;
/// Accuracy of a beacon relative to its range above which a triangle is not informative.
constexpr double kKnownShare = 0.1;

/// Chang's rules on a whole trajectory; a cycle offset hides the ranges.
void gate_ranges(const Site& site, const SharedState& prior, Trajectory& t) {
  const Gates& gates = site.gates;
  if (t.has_cycle_offset || (gates.min_range_m <= 0 && std::isinf(gates.max_range_m))) return;
  std::vector<GatedArrival> arrivals;
  std::vector<Rejection> rejections;
  for (const ArrivalObservation& a : t.arrivals) {
    arrivals.push_back({a.beacon, a.receiver, a.time_s, prior_range_m(t, a, prior)});
    rejections.push_back(a.rejection);
  }
  apply_range_gates(arrivals, {gates.min_range_m, gates.max_range_m}, speed_mps(site.medium), rejections);
  for (std::size_t i = 0; i < rejections.size(); ++i) t.arrivals[i].rejection = rejections[i];
}

/// Kleeman's inequality between all pairs of arrivals of an epoch at one receiver; the longer of a pair that
/// breaks it is out, and still compared with the others (it can only make their differences smaller).
class TriangleGate {
 public:
  TriangleGate(const Site& site, const SharedState& prior) : prior_(prior) {
    for (const SiteBeacon& b : site.beacons) {
      double sigma_m = 0.0;
      for (std::size_t i = 0; i < 3; ++i)
        sigma_m = std::max(sigma_m, b.position_m[i] ? b.sigma_m[i].value_or(INFINITY) : INFINITY);
      sigma_m_.push_back(sigma_m);
      placed_ += std::isfinite(sigma_m);
    }
    delay_sigma_s_ = largest_delay_sigma_s(site);
    speed_sigma_mps_ = site.speed_sigma_mps;
  }

  /// Returns true if some pair of beacons is accurate enough for a test.
  [[nodiscard]] bool any() const { return placed_ >= 2; }

  void gate(Trajectory& t, const Segment& s) const {
    thread_local std::vector<double> range_m;
    range_m.clear();
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
      range_m.push_back(observed_range_m(t, t.arrivals[i], prior_));
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
      ArrivalObservation& a = t.arrivals[i];
      for (std::size_t j = s.first_arrival; j < s.last_arrival && a.rejection == Rejection::kUsed; ++j)
        if (a.receiver == t.arrivals[j].receiver &&
            too_long(a, t.arrivals[j], range_m[i - s.first_arrival], range_m[j - s.first_arrival]))
          a.rejection = Rejection::kTriangle;
    }
  }

 private:
  [[nodiscard]] bool too_long(const ArrivalObservation& a, const ArrivalObservation& b, double ra,
                              double rb) const {
    if (!(ra > rb) || a.beacon == b.beacon) return false;
    const double apart_m =
        (prior_.beacon_p_map_m[a.beacon.index()] - prior_.beacon_p_map_m[b.beacon.index()]).norm();
    const double beyond_m = ra - rb - apart_m, sa = sigma_m_[a.beacon.index()],
                 sb = sigma_m_[b.beacon.index()];
    if (!(beyond_m > 0) || std::max(sa, sb) > kKnownShare * apart_m) return false;
    const double c = a.model_speed_mps, delay_m = c * delay_sigma_s_,
                 speed_m = speed_sigma_mps_ / c * (ra - rb), noise_m = c * a.sigma_s;
    return beyond_m > kSigmas * std::sqrt(2 * noise_m * noise_m + 2 * delay_m * delay_m + speed_m * speed_m +
                                          sa * sa + sb * sb);
  }
  const SharedState& prior_;
  std::vector<double> sigma_m_;  ///< largest sigma of a coordinate of each beacon; infinite: not known
  std::size_t placed_ = 0;
  double delay_sigma_s_ = 0.0, speed_sigma_mps_ = 0.0;
};

}  // namespace

void apply_gates(const Site& site, std::vector<Trajectory>& trajectories, int threads) {
  const SharedState prior = prior_state(site);
  const TriangleGate triangle(site, prior);
  for (Trajectory& t : trajectories) {
    gate_ranges(site, prior, t);
    // A vehicle that moves between two firings is at two places; time-walk makes weak signals late by more
    // than noise.
    if (t.moving || site.attenuation || !site.gates.triangle || !triangle.any()) continue;
    constexpr std::size_t kSegmentsAtOnce = 1024;
    for_each_in_chunks(t.segments.size(), kSegmentsAtOnce, threads,
                       [&](std::size_t s) { triangle.gate(t, t.segments[s]); });
  }
}

}  // namespace octant::calib
