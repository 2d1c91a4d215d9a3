// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/epoch_fix.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "models/localizers/common/arrival_rejections.h"
#include "models/localizers/common/correlated_arrivals.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/least_squares/candidates.h"
#include "models/localizers/least_squares/linear_ranges.h"
#include "models/localizers/least_squares/node_adjustment.h"
#include "models/localizers/least_squares/place_fix.h"
#include "models/localizers/least_squares/rivals.h"
#include "models/localizers/least_squares/spatial_start.h"
#include "models/physics/plane.h"
#include "models/support/decompositions.h"
#include "models/support/observed.h"

namespace octant {
namespace {

constexpr double kHeadingStepM = 0.05;
constexpr int kMaxHeadings = 24;

struct Count {
  int heard = 0, used = 0;                         ///< arrivals of usable beacons
  int bearings = 0, bearings_seen = 0, poses = 0;  ///< labelled bearings of usable reflectors: in use, total
  int beacons_heard = 0, beacons_used = 0;
};

Count count(const Trajectory& t, const Segment& segment, const EpochFixModel& model) {
  Count c;
  std::pmr::vector<char> heard(model.beacon_usable.size(), 0, scratch()), used(heard, scratch());
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (!model.beacon_usable[a.beacon.index()]) continue;
    ++c.heard;
    heard[a.beacon.index()] = 1;
    if (a.rejection != Rejection::kUsed) continue;
    ++c.used;
    used[a.beacon.index()] = 1;
  }
  for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i) {
    const BearingObservation& b = t.bearings[i];
    if (!b.reflector.valid() || b.rejection == Rejection::kBeaconUnusable) continue;
    ++c.bearings_seen;
    if (b.rejection == Rejection::kUsed) ++c.bearings;
  }
  c.poses = static_cast<int>(segment.last_pose - segment.first_pose);
  c.beacons_heard = static_cast<int>(std::ranges::count(heard, 1));
  c.beacons_used = static_cast<int>(std::ranges::count(used, 1));
  return c;
}

void set_node(const Trajectory& t, const SearchProblem& problem, Node& node, const PlanarState& s) {
  node.T_map_vehicle = Pose::planar(s.x_m, s.y_m, s.heading_rad);
  if (t.has_cycle_offset) node.cycle_offset_s = s.offset_m / problem.speed_mps;
}

/// Start of an epoch with a measured pose: only heading and offset may be unknown.
PlanarState start_at_measured_pose(const PoseObservation& measured, const SearchProblem& problem) {
  PlanarState best{measured.T_map_vehicle.translation_m.x(), measured.T_map_vehicle.translation_m.y(),
                   measured.T_map_vehicle.heading_rad(), 0.0};
  Consensus consensus(problem);
  consensus.set_extra_sigma(0.3 * problem.lever_m + measured.position_sigma_m);
  if (problem.has_offset) best.offset_m = consensus.best_offset(best);
  if (std::isfinite(measured.heading_sigma_rad)) return best;
  double lowest = std::numeric_limits<double>::infinity();
  PlanarState state = best;
  for (int k = 0; k < 24; ++k) {
    state.heading_rad = wrap_angle(2 * std::numbers::pi * k / 24);
    if (problem.has_offset) state.offset_m = consensus.best_offset(state);
    const double score = consensus.score(state);
    if (score < lowest) best = state;
    lowest = std::min(lowest, score);
  }
  return best;
}

double horizontal_sigma_m(const PoseCovariance& covariance) {
  return std::sqrt(std::max(largest_eigenvalue(covariance(0, 0), covariance(0, 1), covariance(1, 1)), 0.0));
}

/// Root of the mean variance of the ranges in use.
double mean_range_sigma_m(const Trajectory& t, const Segment& segment, const EpochFixModel& model) {
  double sum_m2 = 0.0;
  int count = 0;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    if (a.rejection != Rejection::kUsed) continue;
    sum_m2 += square(a.sigma_s * (a.model_speed_mps + model.state.speed_offset(t.run)) / a.legs());
    ++count;
  }
  return std::sqrt(sum_m2 / std::max(count, 1));
}

/// Returns true if the sigma of a fix is large, by itself and relative to that of the ranges.
bool is_poor(const Trajectory& t, const Segment& segment, const EpochFixModel& model,
             const EpochFixOptions& options, bool place_alone, const PoseCovariance& covariance) {
  constexpr double kMaxDilution = 10.0;
  const double sigma_m =
      place_alone
          ? std::sqrt(SymmetricEigen<Eigen::Matrix3d>(covariance.topLeftCorner<3, 3>()).eigenvalues()[2])
          : horizontal_sigma_m(covariance);
  return sigma_m > std::max(options.max_sigma_m, kMaxDilution * mean_range_sigma_m(t, segment, model));
}

/// At the mirror image of a pose all ranges fit, and the heading can match one bearing; the other bearings
/// then disagree.
bool bearings_speak_against(const Count& c) {
  return c.poses == 0 && c.bearings_seen >= 2 && 2 * c.bearings < c.bearings_seen;
}

/// Returns true if the number of arrivals in agreement cannot be due to chance.
bool is_consensus(const Count& c, int unknowns) {
  if (c.poses > 0) return true;
  if (bearings_speak_against(c)) return false;
  const int rejected = c.heard - c.used, spare = c.used + c.bearings - unknowns;
  if (spare < 0) return false;
  if (rejected == 0) return true;
  // Any `unknowns` arrivals agree, and two beacons cannot identify which of three is shadowed.
  return spare >= 2 && 3 * c.used >= c.heard &&
         (c.beacons_used >= 3 || c.beacons_used == c.beacons_heard || c.bearings >= 2);
}

double instant_of(const Trajectory& t, const Segment& segment) {
  if (segment.first_arrival == segment.last_arrival) return t.nodes[segment.first_node].time_s;
  return t.arrivals[segment.first_arrival + (segment.last_arrival - segment.first_arrival) / 2].time_s;
}

/// Returns true if ranges alone may determine the node in closed form.
bool may_begin_closed(const Trajectory& t, const Segment& segment, const EpochFixOptions& options) {
  return options.range_uncertainty_m == 0.0 && t.motion == Motion::kPlanar && !t.has_cycle_offset &&
         segment.first_pose == segment.last_pose;
}

/// Returns true if the arrivals in use cover enough different paths (beacon, receiver): pings on one path
/// repeat one equation.
bool are_over_enough_paths(const Trajectory& t, const Segment& segment) {
  std::array<std::pair<BeaconId, ReceiverId>, kFewestPaths> paths;
  std::size_t count = 0;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival && count < kFewestPaths; ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    const std::pair path(a.beacon, a.receiver);
    const auto known = paths.begin() + static_cast<std::ptrdiff_t>(count);
    if (a.rejection == Rejection::kUsed && std::find(paths.begin(), known, path) == known)
      paths[count++] = path;
  }
  return count == kFewestPaths;
}

/// Returns true if the arrivals that disagree are echoes in any pose: late, at most a quarter, and each
/// beacon has arrivals that agree.
bool are_a_few_echoes(const Trajectory& t, const Segment& segment, const Count& c) {
  if (4 * (c.heard - c.used) > c.heard || c.beacons_used != c.beacons_heard) return false;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i)
    if (t.arrivals[i].rejection == Rejection::kEarly) return false;
  return true;
}

/// Returns true if no search could find a better pose. All arrivals except a few echoes must agree, on seven
/// or more paths from three or more beacons that are not collinear (as the closed form requires), and
/// determine the heading. Then no set of outliers is small enough to be compatible; four paths allow two
/// poses.
bool is_beyond_doubt(const Trajectory& t, const Segment& segment, const Count& c,
                     const NodeAdjustment& adjustment) {
  if (!adjustment.converged || !are_a_few_echoes(t, segment, c) || c.bearings != c.bearings_seen ||
      c.beacons_used < 3 || !are_over_enough_paths(t, segment))
    return false;
  return heading_information(adjustment.information) > 1.0 / (kHeadingSigmaRad * kHeadingSigmaRad);
}

/// Sets the node to the best pose of a planar search; returns true if another pose is equally good.
bool start_planar(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                  const EpochFixOptions& options, const std::optional<PlanarState>& start, bool& found) {
  const SearchProblem problem = make_search_problem(t, segment, model, options.range_uncertainty_m);
  Node& node = t.nodes[segment.first_node];
  found = true;
  if (segment.first_pose != segment.last_pose) {
    set_node(t, problem, node, start_at_measured_pose(t.poses[segment.first_pose], problem));
    return false;
  }
  SearchOptions search;
  // Long lever arms need denser headings: half a step must move a receiver by a few centimetres at most.
  const int wanted = static_cast<int>(std::ceil(0.5 * std::numbers::pi * problem.lever_m / kHeadingStepM));
  if (wanted > search.headings) {
    search.headings = std::min(wanted, kMaxHeadings);
    search.keep *= 2;
  }
  search.max_pairs = std::max(options.max_candidates / (2 * search.headings), 4);
  search.max_cells = options.max_candidates;
  search.start = start;
  search.margin = options.ambiguity_margin;
  search.bounded = options.bounded_search;
  const SearchResult result = search_pose(problem, search);
  found = !result.poses.empty();
  if (!found) return false;
  set_node(t, problem, node, result.poses.front().state);
  return result.poses.size() > 1 && result.poses[1].score < result.poses[0].score + options.ambiguity_margin;
}

}  // namespace

void reset_rejections(Trajectory& t, const Segment& segment, const EpochFixModel& model) {
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i)
    t.arrivals[i].rejection =
        model.beacon_usable[t.arrivals[i].beacon.index()] ? Rejection::kUsed : Rejection::kBeaconUnusable;
  for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i) {
    BearingObservation& b = t.bearings[i];
    b.rejection = !b.reflector.valid() || model.beacon_usable[b.reflector.index()]
                      ? Rejection::kUsed
                      : Rejection::kBeaconUnusable;
  }
}

Segment node_segment(const Trajectory& t, const Segment& segment, std::size_t node) {
  Segment out = segment;
  out.first_node = node;
  out.last_node = node + 1;
  const auto narrow = [node](const auto& list, std::size_t& first, std::size_t& last) {
    const auto begin = list.begin();
    const auto from = std::partition_point(begin + static_cast<std::ptrdiff_t>(first),
                                           begin + static_cast<std::ptrdiff_t>(last),
                                           [node](const auto& o) { return o.node < node; });
    const auto to = std::partition_point(from, begin + static_cast<std::ptrdiff_t>(last),
                                         [node](const auto& o) { return o.node == node; });
    first = static_cast<std::size_t>(from - begin);
    last = static_cast<std::size_t>(to - begin);
  };
  narrow(t.arrivals, out.first_arrival, out.last_arrival);
  narrow(t.bearings, out.first_bearing, out.last_bearing);
  narrow(t.poses, out.first_pose, out.last_pose);
  out.last_odometry = out.first_odometry;
  out.last_motion = out.first_motion;
  return out;
}

namespace {

/// Linear ranges without arrivals that came by a detour, followed by an adjustment. Returns true if no search
/// could do better. Otherwise all arrivals are in use again, and a search may start at the resulting node.
bool fix_in_closed_form(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                        const EpochFixOptions& options, CorrelatedArrivals& sigmas,
                        NodeAdjustment& adjustment, Count& c, std::optional<PlanarState>& start) {
  if (!may_begin_closed(t, segment, options)) return false;
  static_cast<void>(reject_detours(t, segment, model.state, options.rejection_sigmas));
  if (place_by_linear_ranges(t, segment, model.state, model.beacon_usable)) {
    Node& node = t.nodes[segment.first_node];
    node.placed = false;
    start = PlanarState{node.T_map_vehicle.translation_m.x(), node.T_map_vehicle.translation_m.y(),
                        node.T_map_vehicle.heading_rad(), 0.0};
    adjustment =
        adjust_and_reject(t, segment, model, options.range_uncertainty_m, options.rejection_sigmas, sigmas);
    c = count(t, segment, model);
    if (is_beyond_doubt(t, segment, c, adjustment)) return true;
    sigmas.restore();
  }
  reset_rejections(t, segment, model);
  c = count(t, segment, model);
  return false;
}

/// Unknowns of a node besides its cycle offset, if only the position is estimated.
constexpr int kPlaceUnknowns = 3;

/// @param place_alone  the model is a PlaceModel's
void fix_node(Trajectory& t, const Segment& segment, const EpochFixModel& model,
              const EpochFixOptions& options, bool place_alone, Fix& fix) {
  clear(fix);
  Node& node = t.nodes[segment.first_node];
  node.placed = false;
  fix.time_s = instant_of(t, segment);
  fix.vehicle = t.vehicle;
  fix.epoch = node.epoch;

  reset_rejections(t, segment, model);
  Count c = count(t, segment, model);
  // At least position and offset must be determined; the heading may be unknown.
  const int least = (t.motion == Motion::kPlanar ? 2
                     : place_alone               ? kPlaceUnknowns
                                                 : 6) +
                    (t.has_cycle_offset ? 1 : 0);
  const bool enough = c.poses > 0 || (c.heard + c.bearings >= least && c.beacons_heard + c.bearings >= 2);
  bool found = false, ambiguous = false;
  NodeAdjustment adjustment;
  std::optional<PlanarState> start;
  CorrelatedArrivals sigmas(t, segment, model.correlated, CorrelatedArrivals::Side::kSame);
  if (options.closed_form_first && enough)
    found = fix_in_closed_form(t, segment, model, options, sigmas, adjustment, c, start);
  const bool search = !found;
  if (enough && search)
    ambiguous = t.motion == Motion::kPlanar ? start_planar(t, segment, model, options, start, found)
                : place_alone               ? start_place(t, segment, model, options, found)
                                            : start_spatial(t, segment, model, options, found);
  if (!found) {
    fix.status = FixStatus::kTooFewArrivals;
    report_arrivals(t, segment.first_arrival, segment.last_arrival, fix);
    return;
  }
  if (search) {
    adjustment =
        adjust_and_reject(t, segment, model, options.range_uncertainty_m, options.rejection_sigmas, sigmas);
    c = count(t, segment, model);
  }
  fix.T_map_vehicle = node.T_map_vehicle;
  fix.cost = adjustment.cost;
  report_arrivals(t, segment.first_arrival, segment.last_arrival, fix);
  const bool determined = pose_covariance(t, adjustment.information, fix.covariance);
  const bool heading_open = t.motion == Motion::kPlanar && determined && fix.covariance(2, 2) > 1.0;
  const int unknowns = (place_alone ? kPlaceUnknowns : pose_dof(t.motion)) + (t.has_cycle_offset ? 1 : 0) -
                       (heading_open ? 1 : 0);
  if (!is_consensus(c, unknowns)) {
    fix.status = c.heard == c.used && !bearings_speak_against(c) ? FixStatus::kTooFewArrivals
                                                                 : FixStatus::kNoConsensus;
  } else if (!determined || is_poor(t, segment, model, options, place_alone, fix.covariance)) {
    fix.status = FixStatus::kPoorGeometry;
  } else if (ambiguous) {
    fix.status = FixStatus::kAmbiguous;
  } else {
    fix.status = adjustment.converged ? FixStatus::kOk : FixStatus::kNotConverged;
  }
  node.placed = fix.ok();
  if (!node.placed) sigmas.restore();
}

/// Returns true if three receivers that are not collinear received enough for a pose, or it was measured.
bool may_tell_attitude(const Trajectory& t, const Segment& segment, const EpochFixModel& model) {
  constexpr double kInLine_m2 = 1e-4;
  if (segment.first_pose != segment.last_pose) return true;
  std::array<Eigen::Vector3d, 2> corners;
  std::size_t known = 0;
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const Eigen::Vector3d& p = model.state.receiver_p_vehicle_m[t.arrivals[i].receiver.index()];
    if (known == 2 && (corners[1] - corners[0]).cross(p - corners[0]).norm() > kInLine_m2) return true;
    if (known == 0 || (known == 1 && (p - corners[0]).norm() > 1e-3)) corners[known++] = p;
  }
  return false;
}

}  // namespace

void fix_epoch(Trajectory& t, const Segment& segment, const EpochFixModel& model,
               const EpochFixOptions& options, Fix& fix) {
  fix_node(t, segment, model, options, false, fix);
}

const EpochFixModel& fix_pose_or_place(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                                       const PlaceModel& place, const EpochFixOptions& options, Fix& fix) {
  if (may_tell_attitude(t, segment, model)) {
    fix_node(t, segment, model, options, false, fix);
    if (fix.ok()) return model;
  }
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    ArrivalObservation& a = t.arrivals[i];
    const double speed = (a.model_speed_mps + model.state.speed_offset(t.run)) / a.legs();
    a.sigma_s = std::hypot(a.sigma_s, std::sqrt(place.receiver_variance_m2[a.receiver.index()]) / speed);
  }
  fix_node(t, segment, place.model, options, true, fix);
  return place.model;
}

Fix fix_epoch(Trajectory& t, const Segment& segment, const EpochFixModel& model,
              const EpochFixOptions& options) {
  Fix fix;
  fix_epoch(t, segment, model, options, fix);
  return fix;
}

bool pose_covariance(const Trajectory& t, const NodeBlock& information, PoseCovariance& covariance) {
  NodeBlock A = information;
  const int dof = pose_dof(t.motion);
  add_vague_angles(t.motion, A);
  const ObservedState<NodeBlock> observed(A);
  if (!observed.all()) return false;
  covariance = observed.covariance().topLeftCorner(dof, dof);
  return covariance.allFinite();
}

}  // namespace octant
