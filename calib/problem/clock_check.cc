// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/clock_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "calib/problem/ranges.h"
#include "calib/problem/unit_check.h"

namespace octant::calib {
namespace {

constexpr double kFastestVehicleMps = 5.0;
constexpr std::size_t kAtLeastBeacons = 3;
constexpr double kMost = 0.7;  ///< fraction of the pairs of beacon and receiver that span a jump
constexpr double kAgreeing =
    0.25;  ///< fraction of the step by which they may differ, in addition to their motion
constexpr std::size_t kSide = 8, kAtLeastSide = 5;  ///< stops before and after a step that are compared
constexpr double kOnTheirSide = 0.8;                ///< fraction of the stops
constexpr double kStepSigmas = 8.0;
constexpr std::size_t kOfMoment = 32, kBeaconsOfMoment = 4;  ///< arrivals of a drive

/// Two arrivals in a row of one beacon at one receiver.
struct RangeStep {
  double from_s, to_s, range_m;  ///< by which the later range is longer
  BeaconId beacon;
  double moved_m;  ///< the most that the vehicle can have moved, noise included
  /// The next change of the pair undoes this one, or this one the change before: an echo, not a jump.
  bool returns = false;
  [[nodiscard]] bool beyond() const { return std::abs(range_m) > moved_m; }
};

/// Distance along odometry up to a time; without odometry: kFastestVehicleMps.
class Travelled {
 public:
  Travelled(const MeasurementLog& run, VehicleId vehicle) {
    double way = 0.0;
    for (const OdometryStep& s : run.odometry) {
      if (s.vehicle != vehicle) continue;
      way += std::hypot(s.dx_m, s.dy_m, s.dz_m);
      time_.push_back(s.time_s);
      way_.push_back(way);
    }
  }
  [[nodiscard]] double most_m(double from_s, double to_s) const {
    const double fastest = kFastestVehicleMps * (to_s - from_s);
    if (time_.size() < 2 || from_s < time_.front() || to_s > time_.back()) return fastest;
    const auto first = std::ranges::upper_bound(time_, from_s) - time_.begin() - 1;
    const auto last = std::min<std::ptrdiff_t>(std::ranges::lower_bound(time_, to_s) - time_.begin(),
                                               std::ssize(time_) - 1);
    return std::min(
        fastest, 1.1 * (way_[static_cast<std::size_t>(last)] - way_[static_cast<std::size_t>(first)]) + 0.02);
  }

 private:
  std::vector<double> time_, way_;
};

std::vector<RangeStep> range_steps_of(const Site& site, const MeasurementLog& run, VehicleId vehicle) {
  const Travelled travelled(run, vehicle);
  double array_m = 0.0;  // turning moves a receiver by up to twice its distance from the origin
  for (const SiteReceiver& r : site.receivers)
    if (r.vehicle == vehicle) array_m = std::max(array_m, 2 * r.position_m.head<2>().norm());
  const double legs = site.timing.legs();
  const double noise_m = 6 * site.noise.tof_sigma_s * speed_mps(site.medium) / legs + array_m;
  struct LastArrival {
    const Arrival* arrival = nullptr;
    std::size_t change = 0;
    bool has_change = false;
  };
  std::map<std::pair<BeaconId, ReceiverId>, LastArrival> last;
  std::vector<RangeStep> changes;
  for (const Arrival& a : run.arrivals) {
    if (a.vehicle != vehicle) continue;
    LastArrival& before = last[{a.beacon, a.receiver}];
    if (before.arrival != nullptr && a.time_s > before.arrival->time_s) {
      const double from_s = before.arrival->time_s,
                   change_m = stated_range_m(site, run, a) - stated_range_m(site, run, *before.arrival);
      RangeStep change{from_s, a.time_s, change_m, a.beacon, travelled.most_m(from_s, a.time_s) + noise_m};
      if (before.has_change) {
        RangeStep& earlier = changes[before.change];
        if (change.beyond() && earlier.beyond() && change.range_m * earlier.range_m < 0)
          earlier.returns = change.returns = true;
      }
      before.change = changes.size();
      before.has_change = true;
      changes.push_back(change);
    }
    before.arrival = &a;
  }
  return changes;
}

/// Returns true if most pairs of beacon and receiver jump by the same amount before time_s, and stay there.
/// @param by_m  approximate size; pairs between whose arrivals the vehicle may have moved as far are not used
bool step_at(const std::vector<RangeStep>& changes, double time_s, double by_m, ClockStep& step) {
  std::set<BeaconId> beacons;
  std::vector<double> changed_m, moved_m;
  std::size_t across = 0;
  for (const RangeStep& c : changes) {
    if (c.from_s >= time_s || c.to_s < time_s) continue;
    if (!c.beyond() && c.moved_m > std::abs(by_m)) continue;
    ++across;
    if (!c.beyond() || c.returns || c.range_m * by_m < 0) continue;
    beacons.insert(c.beacon);
    changed_m.push_back(c.range_m);
    moved_m.push_back(c.moved_m);
  }
  if (beacons.size() < kAtLeastBeacons ||
      static_cast<double>(changed_m.size()) < kMost * static_cast<double>(across))
    return false;
  // One clock: the jumps agree.
  const double step_m = median(changed_m);
  std::size_t agree = 0;
  for (std::size_t i = 0; i < changed_m.size(); ++i)
    agree += std::abs(changed_m[i] - step_m) < moved_m[i] + kAgreeing * std::abs(step_m);
  step = {time_s, step_m, beacons.size()};
  return static_cast<double>(agree) >= kMost * static_cast<double>(changed_m.size());
}

struct ClockOffset {
  double time_s, offset_s, sigma_s;
};

/// Clock offset of each stop that has beacons enough for a place and an offset.
std::vector<ClockOffset> offsets_of(const Trajectory& original, const SharedState& state) {
  Trajectory t = original;
  t.has_cycle_offset = true;
  for (ArrivalObservation& a : t.arrivals)
    if (is_outlier(a.rejection)) a.rejection = Rejection::kUsed;
  std::vector<ClockOffset> offsets;
  const std::size_t needed = t.motion == Motion::kPlanar ? 4 : 5;
  for (const Segment& s : t.segments) {
    if (!t.nodes[s.first_node].placed) continue;
    std::map<std::size_t, std::set<BeaconId>> beacons;
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i)
      if (t.arrivals[i].rejection == Rejection::kUsed)
        beacons[t.arrivals[i].node].insert(t.arrivals[i].beacon);
    (void)solve_states(t, s, state, RobustLoss{});
    (void)solve_states(t, s, state, RobustLoss{kCauchyScale, kCauchyScale});
    for (const auto& [node, heard] : beacons) {
      if (heard.size() < needed) continue;
      const Eigen::MatrixXd C = node_covariance(t, s, node, state);
      if (C.rows() == 0) continue;
      offsets.push_back({t.nodes[node].time_s, t.nodes[node].cycle_offset_s,
                         std::sqrt(C(C.rows() - 1, C.rows() - 1)) / t.nominal_speed_mps});
    }
  }
  std::ranges::sort(offsets, {}, &ClockOffset::time_s);
  return offsets;
}

struct OffsetDifference {
  double difference_s, sigma_s;
};

/// Difference of the medians after and before i, and its standard deviation from the scatter about them; no
/// value for too few stops, or if they do not stay on their sides.
std::optional<OffsetDifference> difference_at(const std::vector<ClockOffset>& o, std::size_t i,
                                              double usual_scatter_s) {
  const std::size_t first = i > kSide ? i - kSide : 0, last = std::min(o.size(), i + kSide);
  if (i - first < kAtLeastSide || last - i < kAtLeastSide) return {};
  std::vector<double> before, after, off;
  for (std::size_t k = first; k < i; ++k) before.push_back(o[k].offset_s);
  for (std::size_t k = i; k < last; ++k) after.push_back(o[k].offset_s);
  const double low = median(before), high = median(after);
  double variance = 0.0;
  for (const double x : before) off.push_back(std::abs(x - low));
  for (const double x : after) off.push_back(std::abs(x - high));
  for (std::size_t k = first; k < last; ++k)
    variance += o[k].sigma_s * o[k].sigma_s / static_cast<double>(last - first);
  // Nearly every stop is on the side of its own median.
  const double middle = 0.5 * (low + high);
  std::size_t on_side = 0;
  for (const double x : before) on_side += (x < middle) == (low < high);
  for (const double x : after) on_side += (x > middle) == (low < high);
  if (static_cast<double>(on_side) < kOnTheirSide * static_cast<double>(off.size())) return {};
  const double scatter = std::max({1.4826 * median(off), std::sqrt(variance), usual_scatter_s});
  return OffsetDifference{high - low, 1.25 * scatter *
                                          std::sqrt(1.0 / static_cast<double>(before.size()) +
                                                    1.0 / static_cast<double>(after.size()))};
}

/// Refines a split. Medians depend little on the side of single stops, so the split found by them is
/// inaccurate; the one with the smallest absolute deviation from the medians on both sides is accurate.
/// @return the first of [first, last) after it
std::size_t sharpened(const std::vector<ClockOffset>& o, std::size_t first, std::size_t last, std::size_t i) {
  std::vector<double> before, after;
  for (std::size_t k = first; k < i; ++k) before.push_back(o[k].offset_s);
  for (std::size_t k = i; k < last; ++k) after.push_back(o[k].offset_s);
  const double low = median(std::move(before)), high = median(std::move(after));
  double deviation = 0.0, least = 0.0;  // of a split at k less that at first
  std::size_t best = first;
  for (std::size_t k = first; k < last; ++k) {
    deviation += std::abs(o[k].offset_s - low) - std::abs(o[k].offset_s - high);
    if (deviation < least) {
      least = deviation;
      best = k + 1;
    }
  }
  return std::clamp(best, first + 1, last - 1);
}

/// The steps that offsets in a row show, each at the first offset after it.
std::vector<std::pair<std::size_t, double>> steps_among(const std::vector<ClockOffset>& o,
                                                        double smallest_s) {
  std::vector<double> changes;
  for (std::size_t i = 1; i < o.size(); ++i) changes.push_back(std::abs(o[i].offset_s - o[i - 1].offset_s));
  const double usual_s = 1.4826 * median(std::move(changes)) / std::sqrt(2.0);
  std::vector<std::pair<double, std::size_t>> candidates;  // significance, index
  for (std::size_t i = 1; i < o.size(); ++i) {
    const auto d = difference_at(o, i, usual_s);
    if (d && std::abs(d->difference_s) > std::max(kStepSigmas * d->sigma_s, smallest_s))
      candidates.emplace_back(std::abs(d->difference_s) / d->sigma_s, i);
  }
  std::sort(candidates.rbegin(), candidates.rend());
  std::vector<std::size_t> taken;
  std::vector<std::pair<std::size_t, double>> steps;
  for (const auto& [significance, i] : candidates) {
    const auto at = i;
    if (std::ranges::any_of(taken, [at](std::size_t k) { return std::max(k, at) - std::min(k, at) < kSide; }))
      continue;
    taken.push_back(i);
    const std::size_t sharp = sharpened(o, i > kSide ? i - kSide : 0, std::min(o.size(), i + kSide), i);
    auto d = difference_at(o, sharp, usual_s);
    if (!d) d = difference_at(o, i, usual_s);
    steps.emplace_back(sharp, d->difference_s);
  }
  return steps;
}

/// Residuals of the arrivals of a drive, in the order of time: single ones, and groups of some dozens of a
/// few beacons.
struct Misfits {
  std::vector<ClockOffset> arrivals, moments;
  std::vector<std::size_t> first;  ///< arrival of each moment, and one past the last's
};

Misfits misfits_of(const Trajectory& t, const SharedState& state) {
  Misfits m;
  m.first.push_back(0);
  std::set<BeaconId> beacons;
  std::vector<double> values;
  for (const ArrivalObservation& a : t.arrivals) {
    if (a.rejection != Rejection::kUsed) continue;
    m.arrivals.push_back({a.time_s, a.sigma_s * arrival_residual(t, a, state), a.sigma_s});
    beacons.insert(a.beacon);
    values.push_back(m.arrivals.back().offset_s);
    if (values.size() < kOfMoment || beacons.size() < kBeaconsOfMoment) continue;
    const double middle = median(values);
    for (double& v : values) v = std::abs(v - middle);
    const auto count = static_cast<double>(values.size());
    m.moments.push_back(
        {m.arrivals[m.first.back()].time_s, middle, 1.25 * 1.4826 * median(values) / std::sqrt(count)});
    m.first.push_back(m.arrivals.size());
    beacons.clear();
    values.clear();
  }
  return m;
}

}  // namespace

std::vector<ClockStep> steps_in_ranges(const Site& site, const MeasurementLog& run) {
  std::vector<ClockStep> steps;
  if (site.timing.clock == Clock::kCycleOffset) return steps;  // a new offset each epoch is what it is about
  for (std::size_t v = 0; v < site.vehicles.size(); ++v) {
    const std::vector<RangeStep> changes = range_steps_of(site, run, VehicleId(v));
    std::vector<RangeStep> near;  // a jump is looked for among what spans or touches it
    double done_s = -INFINITY, longest_s = 0.0;
    for (const RangeStep& c : changes) longest_s = std::max(longest_s, c.beyond() ? c.to_s - c.from_s : 0.0);
    std::size_t first = 0;
    for (const RangeStep& c : changes) {
      if (!c.beyond() || c.returns || c.from_s < done_s) continue;
      // The jump lies within (from, to]; the changes are in the order of their ends.
      while (first < changes.size() && changes[first].to_s < c.to_s) ++first;
      near.clear();
      for (std::size_t k = first; k < changes.size() && changes[k].to_s <= c.to_s + longest_s; ++k)
        near.push_back(changes[k]);
      ClockStep step;
      if (!step_at(near, c.to_s, c.range_m, step)) continue;
      step.step_s /= speed_mps(site.medium) / site.timing.legs();
      steps.push_back(step);
      done_s = c.to_s;
    }
  }
  return steps;
}

bool ranges_show_a_jump(const Site& site, const std::vector<MeasurementLog>& runs) {
  return std::ranges::any_of(runs,
                             [&](const MeasurementLog& run) { return !steps_in_ranges(site, run).empty(); });
}

std::vector<ClockStep> steps_between_stops(const std::vector<Trajectory>& trajectories, std::size_t run,
                                           const SharedState& state, double smallest_m) {
  std::vector<ClockStep> steps;
  for (const Trajectory& t : trajectories) {
    if (t.run != run || t.moving || t.has_cycle_offset) continue;
    const std::vector<ClockOffset> o = offsets_of(t, state);
    for (const auto& [at, step_s] : steps_among(o, smallest_m / t.nominal_speed_mps))
      steps.push_back({o[at].time_s, step_s, state.beacon_p_map_m.size()});
  }
  std::ranges::sort(steps, {}, &ClockStep::time_s);
  return steps;
}

std::vector<ClockStep> steps_along_drives(const std::vector<Trajectory>& trajectories,
                                          const SharedState& state, double smallest_m) {
  std::vector<ClockStep> steps;
  for (const Trajectory& t : trajectories) {
    if (!t.moving || t.has_cycle_offset) continue;
    const Misfits m = misfits_of(t, state);
    for (const auto& [at, step_s] : steps_among(m.moments, smallest_m / t.nominal_speed_mps)) {
      // The moment that holds the jump is on neither side: among the arrivals of it and its neighbours.
      const std::size_t first = m.first[at > 1 ? at - 2 : 0],
                        last = m.first[std::min(at + 2, m.moments.size())];
      steps.push_back({m.arrivals[sharpened(m.arrivals, first, last, m.first[at])].time_s, step_s,
                       state.beacon_p_map_m.size()});
    }
  }
  std::ranges::sort(steps, {}, &ClockStep::time_s);
  return steps;
}

}  // namespace octant::calib
