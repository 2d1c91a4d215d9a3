// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/range_network.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "calib/errors/reliability.h"
#include "calib/network/place_by_ranges.h"
#include "calib/network/range_ambiguity.h"
#include "calib/network/select_observations.h"
#include "calib/network/survey_row.h"
#include "calib/problem/ranges.h"
#include "models/support/normal_noise.h"

namespace octant::calib {
namespace {

/// Bound on the rounds in which ranges are left out.
constexpr int kMostRejections = 30;
/// Ranges within this part of the worst one are left out with it: a blunder spreads over its neighbours.
constexpr double kShareOfWorst = 0.6;
/// Limit of |w|, relative to its robust scale, beyond which a range is left out.
constexpr double kCriticalRange = 4.0;
/// Starts, and the mean square of the ranges from which another start is tried.
constexpr int kMostPlacements = 8;
constexpr double kPoorFit = 4.0;
/// Limit of the deviation from approximate positions, in robust sigmas and in sigmas of the range.
constexpr double kGross = 6.0;
/// Redundancy below which a range cannot be tested.
constexpr double kTestable = 0.01;
/// Rounds of the variance component, and the redundancy from which it is estimated.
constexpr int kScaleRounds = 3;
constexpr double kLeastRedundancy = 5.0;

/// Damped steps to a point in the plane of its neighbours converge slowly.
constexpr NetworkOptions kAdjustment{.max_iterations = 300},
    kWithoutCovariance{.max_iterations = 300, .dense_limit = 0};

/// Points, ranges, observed coordinates and delays; `constants` are the delays as distances.
Network network_of(const Site& site, const BeaconRanges& ranges) {
  Network network;
  for (const SiteBeacon& beacon : site.beacons) {
    NetworkPoint point{.id = beacon.name};
    for (std::size_t i = 0; i < 3; ++i) {
      const bool exact = beacon.position_m[i] && beacon.sigma_m[i] && *beacon.sigma_m[i] == 0.0;
      point.role[i] = exact ? CoordinateRole::kFixed : CoordinateRole::kDatum;
      point.known[i] = beacon.position_m[i].has_value();
      point.p_map_m[static_cast<int>(i)] = beacon.position_m[i].value_or(0.0);
      if (exact || !beacon.position_m[i] || !beacon.sigma_m[i]) continue;
      network.observations.push_back(
          {.kind = static_cast<SurveyKind>(static_cast<int>(SurveyKind::kX) + static_cast<int>(i)),
           .from = static_cast<int>(network.points.size()),
           .line = beacon.line,
           .value = *beacon.position_m[i],
           .sigma = *beacon.sigma_m[i]});
    }
    network.points.push_back(std::move(point));
  }
  const double delay_s = largest_delay_sigma_s(site);
  for (const BeaconRange& range : ranges.pairs) {
    const double m_per_s = range.model_speed_mps / site.timing.legs();
    SurveyObservation o{.kind = SurveyKind::kSlopeDistance,
                        .from = range.from.value,
                        .to = range.to.value,
                        .value = m_per_s * range.tof_s,
                        .sigma = m_per_s * range.sigma_s};
    if (delay_s > 0.0) {
      o.constant = range.from.value;
      o.target_constant = range.to.value;
    }
    network.observations.push_back(o);
  }
  if (delay_s == 0.0 || ranges.pairs.empty()) return network;
  network.constants = static_cast<int>(site.beacons.size());
  const double sigma_m = delay_s * ranges.pairs.front().model_speed_mps / site.timing.legs();
  for (int b = 0; b < network.constants; ++b)
    network.observations.push_back({.kind = SurveyKind::kConstant, .constant = b, .sigma = sigma_m});
  return network;
}

bool heights_are_given(const Site& site) {
  return std::ranges::all_of(site.beacons,
                             [](const SiteBeacon& b) { return b.position_m[2] && b.sigma_m[2]; });
}

std::vector<RangeEdge> edges_of(const Network& network, bool plane) {
  std::vector<RangeEdge> edges;
  for (const SurveyObservation& o : network.observations) {
    if (o.kind != SurveyKind::kSlopeDistance) continue;
    const double rise_m = network.points[static_cast<std::size_t>(o.to)].p_map_m.z() -
                          network.points[static_cast<std::size_t>(o.from)].p_map_m.z();
    const double square = o.value * o.value - (plane ? rise_m * rise_m : 0.0);
    edges.push_back({o.from, o.to, std::sqrt(std::max(square, 1e-6))});
  }
  return edges;
}

/// Moves the placed points to the given positions, as far as there are enough of them.
/// @return false if a reflection fits about as well
bool move_to_given(const Network& network, PlacedByRanges& placed) {
  const auto d = static_cast<std::size_t>(placed.positions_m.rows());
  std::vector<int> given;
  for (std::size_t p = 0; p < network.points.size(); ++p)
    if (placed.column[p] >= 0 && std::all_of(network.points[p].known.begin(),
                                             network.points[p].known.begin() + static_cast<std::ptrdiff_t>(d),
                                             [](bool known) { return known; }))
      given.push_back(static_cast<int>(p));
  if (given.empty()) return false;
  Eigen::MatrixXd from(d, given.size()), to(d, given.size());
  for (std::size_t k = 0; k < given.size(); ++k) {
    const auto p = static_cast<std::size_t>(given[k]);
    from.col(static_cast<Eigen::Index>(k)) = placed.positions_m.col(placed.column[p]);
    to.col(static_cast<Eigen::Index>(k)) = network.points[p].p_map_m.head(static_cast<Eigen::Index>(d));
  }
  const RigidFit direct = fit_rigidly(from, to, false), reflected = fit_rigidly(from, to, true);
  const RigidFit& best = reflected.rms_m < direct.rms_m ? reflected : direct;
  placed.positions_m = ((best.rotation * placed.positions_m).colwise() + best.shift_m).eval();
  const double other_m = std::max(direct.rms_m, reflected.rms_m);
  return given.size() > d && best.rms_m < 0.5 * other_m;
}

bool is_range(const SurveyObservation& o) { return o.kind == SurveyKind::kSlopeDistance; }

/// Ranges with their test values.
using Suspects = std::vector<std::pair<double, std::size_t>>;

/// Observations without the suspects, the worst first. A suspect stays where a beacon of it would keep fewer
/// ranges than it has unknown coordinates that are not observed otherwise.
std::vector<bool> keep_without(const Network& network, Suspects suspects) {
  std::vector<int> spare(network.points.size(), 0);
  for (std::size_t p = 0; p < spare.size(); ++p)
    for (const CoordinateRole role : network.points[p].role)
      if (role >= CoordinateRole::kFree) --spare[p];
  for (const SurveyObservation& o : network.observations) {
    if (o.from >= 0) ++spare[static_cast<std::size_t>(o.from)];
    if (o.to >= 0) ++spare[static_cast<std::size_t>(o.to)];
  }
  std::vector<bool> keep(network.observations.size(), true);
  std::ranges::sort(suspects, std::greater{});
  for (const auto& [test, i] : suspects) {
    int &from = spare[static_cast<std::size_t>(network.observations[i].from)],
        &to = spare[static_cast<std::size_t>(network.observations[i].to)];
    const auto can_spare = [&](int point, int left) {
      return left > 0 || std::ranges::none_of(network.points[static_cast<std::size_t>(point)].role,
                                              [](CoordinateRole r) { return r >= CoordinateRole::kFree; });
    };
    if (!can_spare(network.observations[i].from, from) || !can_spare(network.observations[i].to, to))
      continue;
    --from;
    --to;
    keep[i] = false;
  }
  return keep;
}

/// Removes the observations that are not kept, and returns them.
std::vector<SurveyObservation> remove_others(Network& network, const std::vector<bool>& keep) {
  std::vector<SurveyObservation> removed;
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (!keep[i]) removed.push_back(network.observations[i]);
  if (!removed.empty()) keep_observations(network, keep);
  return removed;
}

/// Leaves out ranges that deviate from the approximate positions far more than most: echoes, before the first
/// adjustment, which would be displaced by them.
std::vector<SurveyObservation> leave_out_gross(Network& network) {
  std::vector<double> deviation_m;
  std::vector<std::size_t> ranges;
  for (std::size_t i = 0; i < network.observations.size(); ++i) {
    const SurveyObservation& o = network.observations[i];
    if (!is_range(o)) continue;
    const NetworkPoint &from = network.points[static_cast<std::size_t>(o.from)],
                       &to = network.points[static_cast<std::size_t>(o.to)];
    if (!from.known[0] || !to.known[0]) continue;
    deviation_m.push_back(std::abs((to.p_map_m - from.p_map_m).norm() - o.value));
    ranges.push_back(i);
  }
  if (ranges.empty()) return {};
  const double scale_m = median(deviation_m) / kMedianOfNormal;
  Suspects suspects;
  for (std::size_t k = 0; k < ranges.size(); ++k)
    if (const double limit_m = kGross * std::max(scale_m, network.observations[ranges[k]].sigma);
        deviation_m[k] > limit_m)
      suspects.emplace_back(deviation_m[k] / limit_m, ranges[k]);
  return remove_others(network, keep_without(network, std::move(suspects)));
}

/// Takes ranges back that agree with the adjusted positions within their uncertainty.
void restore_ranges(SolvedNetwork& solved) {
  const NetworkColumns columns = network_columns(solved.network);
  const auto sigma_of = [&](int p) {
    return std::sqrt(solved.solution.point_covariances_m2[static_cast<std::size_t>(p)].trace());
  };
  std::vector<SurveyObservation> back;
  std::erase_if(solved.outlying, [&](const SurveyObservation& o) {
    const double deviation_m = survey_row(solved.network, columns, o, solved.solution.unknowns).misclosure;
    const bool agrees =
        std::abs(deviation_m) < kCriticalRange * std::hypot(o.sigma, sigma_of(o.from) + sigma_of(o.to));
    if (agrees) back.push_back(o);
    return agrees;
  });
  if (back.empty()) return;
  solved.network.observations.insert(solved.network.observations.end(), back.begin(), back.end());
  solved.solution = adjust_network(solved.network, kWithoutCovariance);
}

/// Adjusts a network without gross ranges; with all of them where points would be lost without them.
Result<SolvedNetwork> solve_without_gross(const Network& network) {
  Network reduced = network;
  std::vector<SurveyObservation> gross = leave_out_gross(reduced);
  auto solved = solve_network(std::move(reduced), {.adjustment = kAdjustment});
  if (gross.empty() || !solved) return solved;
  if (solved->solution.status != NetworkStatus::kConverged || !solved->undetermined.empty())
    return solve_network(network, {.adjustment = kAdjustment});
  solved->outlying = std::move(gross);
  restore_ranges(*solved);
  return solved;
}

/// Ranges whose w exceeds the limit, relative to the median of all and to 1.
Suspects failed_ranges(const SolvedNetwork& solved) {
  std::vector<double> all;
  Suspects testable, failed;
  double worst = 0.0;
  for (std::size_t i = 0; i < solved.network.observations.size(); ++i) {
    if (!is_range(solved.network.observations[i])) continue;
    const ObservationResult& r = solved.solution.observations[i];
    all.push_back(std::abs(r.w));
    if (r.redundancy < kTestable) continue;
    testable.emplace_back(all.back(), i);
    worst = std::max(worst, all.back());
  }
  if (all.empty()) return failed;
  const double limit =
      std::max(kCriticalRange * std::max(median(all) / kMedianOfNormal, 1.0), kShareOfWorst * worst);
  for (const auto& suspect : testable)
    if (suspect.first >= limit) failed.push_back(suspect);
  return failed;
}

/// Leaves out ranges whose w-test fails, the worst ones first. Where the others do not determine the network
/// any more, only the worst one, or none.
void reject_ranges(SolvedNetwork& solved) {
  for (int round = 0; round < kMostRejections && solved.solution.status == NetworkStatus::kConverged;
       ++round) {
    Suspects suspects = failed_ranges(solved);
    bool rejected = false;
    while (!rejected && !suspects.empty()) {
      SolvedNetwork next = solved;
      const auto removed = remove_others(next.network, keep_without(next.network, suspects));
      if (removed.empty()) return;
      next.outlying.insert(next.outlying.end(), removed.begin(), removed.end());
      next.solution = adjust_network(next.network, kWithoutCovariance);
      rejected = next.solution.status == NetworkStatus::kConverged;
      if (rejected) solved = std::move(next);
      suspects = suspects.size() > 1 ? Suspects{*std::ranges::max_element(suspects)} : Suspects{};
    }
    if (!rejected) return;
  }
}

/// Scales the sigmas of the ranges to their residuals (variance component), and adjusts again.
void scale_ranges(SolvedNetwork& solved) {
  for (int round = 0; round < kScaleRounds && solved.solution.status == NetworkStatus::kConverged; ++round) {
    double squares = 0.0, redundancy = 0.0;
    for (std::size_t i = 0; i < solved.network.observations.size(); ++i) {
      const SurveyObservation& o = solved.network.observations[i];
      if (!is_range(o)) continue;
      squares += std::pow(solved.solution.observations[i].residual / o.sigma, 2);
      redundancy += solved.solution.observations[i].redundancy;
    }
    if (redundancy < kLeastRedundancy) return;
    const double factor = std::sqrt(squares / redundancy);
    for (SurveyObservation& o : solved.network.observations)
      if (is_range(o)) o.sigma = std::max(o.sigma * factor, 1e-9);
    solved.solution = adjust_network(solved.network, kAdjustment);
  }
}

/// Coordinates of a start, where they are not fixed.
void use_placed(const PlacedByRanges& placed, Network& network) {
  for (std::size_t p = 0; p < network.points.size(); ++p) {
    NetworkPoint& point = network.points[p];
    for (int i = 0; i < static_cast<int>(placed.positions_m.rows()); ++i)
      if (const auto axis = static_cast<std::size_t>(i);
          placed.column[p] >= 0 && point.role[axis] != CoordinateRole::kFixed) {
        point.p_map_m[i] = placed.positions_m(i, placed.column[p]);
        point.known[axis] = true;
      }
    if (placed.column[p] < 0) point.known.fill(false);
  }
}

/// Adjustment from one start of place_by_ranges().
Result<SolvedRangeNetwork> solve_from(Network network, int dimensions, int start) {
  SolvedRangeNetwork result;
  PlacedByRanges placed = place_by_ranges(static_cast<int>(network.points.size()),
                                          edges_of(network, dimensions == 2), dimensions, start);
  if (placed.positions_m.cols() > 0) result.mirror_is_equal = !move_to_given(network, placed);
  use_placed(placed, network);
  auto solved = solve_without_gross(network);
  if (!solved) return fail(solved.error());
  result.solved = std::move(*solved);
  reject_ranges(result.solved);
  return result;
}

/// Sum of squares of an adjustment, in which each range that is left out counts as one at the limit.
double squares_of(const SolvedNetwork& s) {
  if (s.solution.status != NetworkStatus::kConverged) return INFINITY;
  return s.solution.variance_factor * std::max(0, s.solution.redundancy) +
         kCriticalRange * kCriticalRange * static_cast<double>(s.outlying.size()) +
         1e6 * static_cast<double>(s.undetermined.size());
}

}  // namespace

Result<SolvedRangeNetwork> solve_range_network(const Site& site, const BeaconRanges& ranges) {
  const Network network = network_of(site, ranges);
  const int dimensions = heights_are_given(site) ? 2 : 3;
  if (ranges.pairs.empty())
    return fail({.file = site.path,
                 .found = "no range between beacons",
                 .expected = "beacon_tof.csv with rows in a run folder"});
  auto best = solve_from(network, dimensions, 0);
  if (!best) return best;
  // Another start is better if fewer ranges contradict it.
  const double expected = kPoorFit * static_cast<double>(ranges.pairs.size());
  for (int start = 1; start < kMostPlacements && squares_of(best->solved) > expected; ++start)
    if (auto other = solve_from(network, dimensions, start);
        other && squares_of(other->solved) < squares_of(best->solved))
      best = std::move(other);
  scale_ranges(best->solved);
  best->ambiguous = leave_out_ambiguous(best->solved, dimensions);
  return best;
}

}  // namespace octant::calib
