// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/gates.h"

#include <algorithm>
#include <cmath>

#include "calib/ranges.h"
#include "models/localizers/range_gates.h"

namespace octant::calib {
namespace {

constexpr double kSigmas = 4.0;
/// A beacon known to a larger share of its range says little in a triangle.
constexpr double kKnownShare = 0.1;

/// Chang's rules on a whole trajectory; a cycle offset hides the ranges.
void gate_ranges(const Site& site, const SharedState& prior, Trajectory& t) {
  const Gates& gates = site.gates;
  if (t.has_cycle_offset || (gates.min_range_m <= 0 && std::isinf(gates.max_range_m))) return;
  std::vector<GatedArrival> arrivals;
  std::vector<Rejection> marks;
  for (const ArrivalObservation& a : t.arrivals) {
    arrivals.push_back({a.beacon, a.receiver, a.time_s, prior_range_m(t, a, prior)});
    marks.push_back(a.rejection);
  }
  apply_range_gates(arrivals, {gates.min_range_m, gates.max_range_m}, speed_mps(site.medium), marks);
  for (std::size_t i = 0; i < marks.size(); ++i) t.arrivals[i].rejection = marks[i];
}

/// Kleeman's inequality between all pairs of arrivals of an epoch at one receiver; the longer of a pair that breaks it is out,
/// and still compared with the others (it can only make their differences smaller).
class TriangleGate {
 public:
  TriangleGate(const Site& site, const SharedState& prior) : site_(site), prior_(prior) {
    for (const SiteBeacon& b : site.beacons) {
      double sigma_m = 0.0;
      for (std::size_t i = 0; i < 3; ++i) sigma_m = std::max(sigma_m, b.position_m[i] ? b.sigma_m[i].value_or(INFINITY) : INFINITY);
      place_sigma_m_.push_back(sigma_m);
    }
  }

  void gate(Trajectory& t, const Segment& s) {
    known_.clear();
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
      if (std::isfinite(place_sigma_m_[t.arrivals[i].beacon.index()])) known_.push_back(i);
    for (const std::size_t i : known_)
      for (const std::size_t j : known_) {
        ArrivalObservation& a = t.arrivals[i];
        const ArrivalObservation& b = t.arrivals[j];
        if (a.receiver == b.receiver && a.beacon != b.beacon && a.rejection == Rejection::kUsed && too_long(t, a, b)) a.rejection = Rejection::kTriangle;
      }
  }

 private:
  [[nodiscard]] bool too_long(const Trajectory& t, const ArrivalObservation& a, const ArrivalObservation& b) const {
    const double ra = range_m(t, a), rb = range_m(t, b);
    if (!(ra > rb)) return false;
    const double sa = place_sigma_m_[a.beacon.index()], sb = place_sigma_m_[b.beacon.index()];
    const double apart_m = (prior_.beacon_p_map_m[a.beacon.index()] - prior_.beacon_p_map_m[b.beacon.index()]).norm();
    if (!(std::max(sa, sb) <= kKnownShare * apart_m)) return false;
    const double c = a.model_speed_mps;
    const double delay_m = site_.timing.delay_per.none() ? 0.0 : c * site_.timing.delay_sigma_s;
    const double speed_m = site_.speed_sigma_mps / c * std::abs(ra - rb);
    const double noise_m = c * a.sigma_s;
    const double sigma_m = std::sqrt(2 * noise_m * noise_m + 2 * delay_m * delay_m + speed_m * speed_m + sa * sa + sb * sb);
    return ra - rb > apart_m + kSigmas * sigma_m;
  }
  /// Differences are free of a cycle offset, so the range may be taken with it.
  [[nodiscard]] double range_m(const Trajectory& t, const ArrivalObservation& a) const {
    return (a.tof_s - prior_.delay_s(a.beacon, a.receiver)) * (a.model_speed_mps + prior_.speed_offset(t.run)) / (a.two_way ? 2.0 : 1.0);
  }

  const Site& site_;
  const SharedState& prior_;
  std::vector<double> place_sigma_m_;
  std::vector<std::size_t> known_;
};

}  // namespace

void apply_gates(const Site& site, std::vector<Trajectory>& trajectories) {
  const SharedState prior = prior_state(site);
  TriangleGate triangle(site, prior);
  for (Trajectory& t : trajectories) {
    gate_ranges(site, prior, t);
    // A vehicle that moves between two firings is at two places; time-walk makes weak signals late by more than noise.
    if (t.moving || site.attenuation || !site.gates.triangle) continue;
    for (const Segment& segment : t.segments) triangle.gate(t, segment);
  }
}

}  // namespace octant::calib
