// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/gates.h"

#include <algorithm>
#include <cmath>

#include "calib/parallel.h"
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
  TriangleGate(const Site& site, const SharedState& prior) : prior_(prior), beacons_(site.beacons.size()) {
    std::vector<double> sigma_m(beacons_, 0.0);
    for (std::size_t b = 0; b < beacons_; ++b)
      for (std::size_t i = 0; i < 3; ++i)
        sigma_m[b] = std::max(sigma_m[b], site.beacons[b].position_m[i] ? site.beacons[b].sigma_m[i].value_or(INFINITY) : INFINITY);
    for (std::size_t a = 0; a < beacons_; ++a)
      for (std::size_t b = 0; b < beacons_; ++b) {
        const double apart_m = (prior.beacon_p_map_m[a] - prior.beacon_p_map_m[b]).norm();
        const bool known = a != b && std::max(sigma_m[a], sigma_m[b]) <= kKnownShare * apart_m;
        pairs_.push_back({apart_m, known ? sigma_m[a] * sigma_m[a] + sigma_m[b] * sigma_m[b] : INFINITY});
        any_ = any_ || known;
      }
    delay_sigma_s_ = site.timing.delay_per.none() ? 0.0 : site.timing.delay_sigma_s;
    speed_sigma_mps_ = site.speed_sigma_mps;
  }

  /// Some pair of beacons is known well enough to say anything.
  [[nodiscard]] bool any() const { return any_; }

  void gate(Trajectory& t, const Segment& s) const {
    thread_local std::vector<double> range_m;
    range_m.clear();
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) range_m.push_back(range_of(t, t.arrivals[i]));
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
      ArrivalObservation& a = t.arrivals[i];
      for (std::size_t j = s.first_arrival; j < s.last_arrival && a.rejection == Rejection::kUsed; ++j)
        if (a.receiver == t.arrivals[j].receiver && too_long(a, t.arrivals[j], range_m[i - s.first_arrival], range_m[j - s.first_arrival]))
          a.rejection = Rejection::kTriangle;
    }
  }

 private:
  struct Pair {
    double apart_m, variance_m2;  ///< of both places; infinite: not known well enough
  };

  [[nodiscard]] bool too_long(const ArrivalObservation& a, const ArrivalObservation& b, double ra, double rb) const {
    const Pair& pair = pairs_[a.beacon.index() * beacons_ + b.beacon.index()];
    const double beyond_m = ra - rb - pair.apart_m;
    if (!(beyond_m > 0) || std::isinf(pair.variance_m2)) return false;
    const double c = a.model_speed_mps, delay_m = c * delay_sigma_s_, speed_m = speed_sigma_mps_ / c * (ra - rb), noise_m = c * a.sigma_s;
    return beyond_m > kSigmas * std::sqrt(2 * noise_m * noise_m + 2 * delay_m * delay_m + speed_m * speed_m + pair.variance_m2);
  }
  /// Differences are free of a cycle offset, so the range may be taken with it.
  [[nodiscard]] double range_of(const Trajectory& t, const ArrivalObservation& a) const {
    return (a.tof_s - prior_.delay_s(a.beacon, a.receiver)) * (a.model_speed_mps + prior_.speed_offset(t.run)) / (a.two_way ? 2.0 : 1.0);
  }

  const SharedState& prior_;
  std::size_t beacons_;
  std::vector<Pair> pairs_;
  bool any_ = false;
  double delay_sigma_s_ = 0.0, speed_sigma_mps_ = 0.0;
};

}  // namespace

void apply_gates(const Site& site, std::vector<Trajectory>& trajectories, int threads) {
  const SharedState prior = prior_state(site);
  const TriangleGate triangle(site, prior);
  for (Trajectory& t : trajectories) {
    gate_ranges(site, prior, t);
    // A vehicle that moves between two firings is at two places; time-walk makes weak signals late by more than noise.
    if (t.moving || site.attenuation || !site.gates.triangle || !triangle.any()) continue;
    constexpr std::size_t kSegmentsAtOnce = 1024;
    for_each_chunk(t.segments.size(), kSegmentsAtOnce, threads, [&](std::size_t, std::size_t first, std::size_t last) {
      for (std::size_t s = first; s < last; ++s) triangle.gate(t, t.segments[s]);
    });
  }
}

}  // namespace octant::calib
