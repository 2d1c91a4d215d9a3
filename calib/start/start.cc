// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/start.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include "calib/problem/gates.h"
#include "calib/problem/ranges.h"
#include "calib/problem/trilaterate.h"
#include "calib/start/cold_start.h"
#include "models/localizers/common/open_attitude.h"
#include "models/localizers/drive/tracker.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/least_squares/place_fix.h"
#include "models/support/parallel.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// A beacon counts as known when its prior is this much tighter than the ranges it takes part in.
constexpr double kKnownShareOfRange = 0.2;

/// A thousand ranges determine a start as well as a million.
constexpr std::size_t kEnoughToStart = 1000;
/// A smaller number is sufficient to compare mirror images.
constexpr std::size_t kEnoughForImage = 200;

TrilaterationOptions trilateration_options(const Problem& problem, const SharedState& state,
                                           std::size_t beacon, double scale_m) {
  const SiteBeacon& known = problem.site.beacons[beacon];
  const double held_below_m = 0.05 * typical_range_m(problem);
  TrilaterationOptions options;
  options.guess = state.beacon_p_map_m[beacon];
  for (std::size_t i = 0; i < 3; ++i)
    options.held[i] = known.position_m[i] && known.sigma_m[i].value_or(INFINITY) <= held_below_m;
  options.scale_m = scale_m;
  options.above = problem.site.motion == Motion::kPlanar;
  return options;
}

class Starter {
 public:
  Starter(const Problem& problem, int threads) : threads_(threads), problem_(problem), site_(problem.site) {
    start_.state = prior_state(site_);
    start_.trajectories = problem.trajectories;
    start_.beacon_found.assign(site_.beacons.size(), false);
  }

  Start run() {
    ranges_by_beacon();
    set_known_beacons();
    spread();
    if (nothing_placed()) {
      start_cold();
      spread();
    }
    return std::move(start_);
  }

 private:
  /// Places states from beacons and beacons from states, alternately, until no more are found.
  void spread() {
    for (std::size_t round = 0; round < site_.beacons.size() + 2; ++round) {
      const std::size_t placed = place_all(), found = find_beacons();
      if (placed + found == 0) break;
    }
  }

  [[nodiscard]] bool nothing_placed() const {
    for (const Trajectory& t : start_.trajectories)
      for (const Node& node : t.nodes)
        if (node.placed) return false;
    return true;
  }

  void start_cold() {
    // With some beacons known the frame is theirs; a second one would not agree with it.
    if (std::ranges::count(start_.beacon_found, true) > 0) return;
    ColdStart cold = start_from_odometry(problem_, start_.trajectories);
    if (!cold.ok)
      cold = start_from_array(problem_, start_.state, start_.trajectories, start_.beacon_found,
                              typical_range_m_);
    start_.uncertainty_m = std::hypot(start_.uncertainty_m, cold.uncertainty_m);
  }

  void ranges_by_beacon() {
    std::vector<std::vector<double>> ranges(site_.beacons.size());
    std::vector<double> all;
    for (const Trajectory& t : start_.trajectories)
      for (const ArrivalObservation& a : t.arrivals) {
        ranges[a.beacon.index()].push_back(prior_range_m(t, a, start_.state));
        all.push_back(ranges[a.beacon.index()].back());
      }
    for (auto& r : ranges) median_range_m_.push_back(median(std::move(r)));
    typical_range_m_ = std::max(median(std::move(all)), 1e-3);
  }

  void set_known_beacons() {
    double worst_m = 0.0;
    for (std::size_t b = 0; b < site_.beacons.size(); ++b) {
      const SiteBeacon& beacon = site_.beacons[b];
      double sigma_m = 0.0;
      for (std::size_t i = 0; i < 3; ++i)
        sigma_m = std::max(sigma_m, beacon.position_m[i] ? beacon.sigma_m[i].value_or(0.3) : INFINITY);
      const double range_m = median_range_m_[b] > 0 ? median_range_m_[b] : typical_range_m_;
      start_.beacon_found[b] = sigma_m <= kKnownShareOfRange * range_m;
      if (start_.beacon_found[b]) worst_m = std::max(worst_m, sigma_m);
    }
    const double c = speed_mps(site_.medium);
    const double speed_m = std::min(0.15, site_.speed_sigma_mps / c) * typical_range_m_;
    const double delay_m = std::min(c * largest_delay_sigma_s(site_), 0.2 * typical_range_m_);
    double lever_m = 0.0;
    for (const SiteReceiver& r : site_.receivers) lever_m = std::max(lever_m, r.sigma_m.maxCoeff());
    lever_m = std::min(lever_m, 0.2 * typical_range_m_);
    start_.uncertainty_m =
        std::sqrt(worst_m * worst_m + speed_m * speed_m + delay_m * delay_m + lever_m * lever_m);
  }

  std::size_t place_all() {
    const EpochFixModel model = search_model(problem_, start_.state, start_.beacon_found);
    std::size_t placed = 0;
    if (std::ranges::count(start_.beacon_found, true) < 2) return 0;
    for (Trajectory& t : start_.trajectories)
      placed += place_states(t, model, start_.uncertainty_m, false, 0.0, threads_);
    return placed;
  }

  std::size_t find_beacons() {
    std::size_t found = 0;
    for (std::size_t b = 0; b < site_.beacons.size(); ++b)
      if (!start_.beacon_found[b] && find_beacon(b)) ++found;
    return found;
  }

  bool find_beacon(std::size_t b) {
    const std::vector<RangeFrom> ranges =
        some_of(ranges_to(start_.trajectories, start_.state, BeaconId(b)), kEnoughToStart);
    const std::vector<RayFrom> rays =
        some_of(rays_to(start_.trajectories, BeaconId(b), start_.beacon_found), kEnoughToStart);
    if (ranges.size() + rays.size() < 4) return false;
    const TrilaterationOptions options = trilateration_options(
        problem_, start_.state, b,
        std::max(start_.uncertainty_m, 3 * site_.noise.tof_sigma_s * speed_mps(site_.medium)));
    const Trilateration place = trilaterate(ranges, options, rays);
    if (!place.ok) return false;
    start_.state.beacon_p_map_m[b] = place.p_map_m;
    start_.beacon_found[b] = true;
    if (options.above && !options.held[2])
      start_.warnings.push_back(fmt::format(
          "beacon {}: its height is unknown; assumed to lie above the receivers", site_.beacons[b].name));
    return true;
  }

  int threads_;
  const Problem& problem_;
  const Site& site_;
  Start start_;
  std::vector<double> median_range_m_;
  double typical_range_m_ = 1.0;
};

bool suspicious(const Trajectory& t, const Segment& epoch, const SharedState& state, double sigmas) {
  for (std::size_t i = epoch.first_arrival; i < epoch.last_arrival; ++i)
    if (t.arrivals[i].rejection != Rejection::kBeaconUnusable &&
        std::abs(arrival_residual(t, t.arrivals[i], state)) > sigmas)
      return true;
  return false;
}

/// Model of stops in space whose arrivals determine a position, but no attitude.
PlaceModel open_attitude_model(const Trajectory& t, const EpochFixModel& model) {
  PlaceModel place{model, {}, {}};
  std::vector<Eigen::Vector3d>& receivers_m = place.model.state.receiver_p_vehicle_m;
  std::vector<bool> is_of_vehicle(receivers_m.size(), false);
  for (const ArrivalObservation& a : t.arrivals) is_of_vehicle[a.receiver.index()] = true;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t r = 0; r < receivers_m.size(); ++r)
    if (is_of_vehicle[r]) centre_m += receivers_m[r], count += 1.0;
  centre_m /= std::max(count, 1.0);
  place.p_centre_vehicle_m = {centre_m};
  for (Eigen::Vector3d& p_m : receivers_m) {
    place.receiver_variance_m2.push_back(open_attitude_variance_m2(p_m - centre_m));
    p_m.setZero();
  }
  for (auto& axis : place.model.receiver_axis) axis.reset();
  place.model.state.receiver_axis.clear();
  return place;
}

/// Fix of an epoch; in space of its position alone if its arrivals do not determine the attitude.
bool is_fixed(Trajectory& t, const Segment& epoch, const EpochFixModel& model, const PlaceModel* place,
              const EpochFixOptions& options) {
  if (place == nullptr) return fix_epoch(t, epoch, model, options).ok();
  std::vector<double> sigmas_s;
  for (std::size_t i = epoch.first_arrival; i < epoch.last_arrival; ++i)
    sigmas_s.push_back(t.arrivals[i].sigma_s);
  Fix fix;
  const bool is_place = &fix_pose_or_place(t, epoch, model, *place, options, fix) != &model;
  for (std::size_t i = epoch.first_arrival; i < epoch.last_arrival; ++i)
    t.arrivals[i].sigma_s = sigmas_s[i - epoch.first_arrival];
  if (fix.ok() && is_place) {
    Pose& pose = t.nodes[epoch.first_node].T_map_vehicle;
    pose.rotation.setIdentity();
    pose.translation_m -= place->p_centre_vehicle_m.front();
  }
  return fix.ok();
}

bool place_epoch(Trajectory& t, const Segment& epoch, const EpochFixModel& model, const PlaceModel* place,
                 const EpochFixOptions& options, bool again) {
  Node& node = t.nodes[epoch.first_node];
  if (epoch.first_pose < epoch.last_pose || (node.placed && !again))
    return false;  // a measured pose needs no search
  const Node before = node;
  std::vector<Rejection> rejections;
  for (std::size_t i = epoch.first_arrival; i < epoch.last_arrival; ++i)
    rejections.push_back(t.arrivals[i].rejection);
  const bool found = is_fixed(t, epoch, model, place, options);
  if (found) {
    node.placed = true;
  } else {
    node = before;
  }
  // The search used all arrivals; those that a gate rejected stay out until the adjustment has converged.
  for (std::size_t i = epoch.first_arrival; i < epoch.last_arrival; ++i)
    t.arrivals[i].rejection = is_gated(rejections[i - epoch.first_arrival])
                                  ? rejections[i - epoch.first_arrival]
                                  : Rejection::kUsed;
  return found;
}

}  // namespace

Start initial_values(const Problem& problem, int threads) { return Starter(problem, threads).run(); }

std::optional<Eigen::Vector3d> mirror_image(const Problem& problem, const SharedState& state,
                                            const std::vector<Trajectory>& trajectories, std::size_t beacon,
                                            double scale_m) {
  return mirror_image_of(state.beacon_p_map_m[beacon],
                         some_of(ranges_to(trajectories, state, BeaconId(beacon)), kEnoughForImage),
                         trilateration_options(problem, state, beacon, scale_m));
}

EpochFixModel search_model(const Problem& problem, const SharedState& state,
                           const std::vector<bool>& usable) {
  EpochFixModel model;
  model.state = state;
  model.beacon_usable = usable;
  for (const SiteReceiver& r : problem.site.receivers) model.receiver_axis.push_back(r.axis);
  model.nominal_speed_mps = speed_mps(problem.site.medium);
  return model;
}

std::size_t place_states(Trajectory& t, const EpochFixModel& model, double uncertainty_m, bool again,
                         double suspect_sigmas, int threads) {
  std::size_t placed = 0;
  if (t.moving && (!t.odometry.empty() || t.motion_prior)) {
    const bool all = std::ranges::all_of(t.nodes, [](const Node& n) { return n.placed; });
    if (all && (!again || !t.poses.empty())) return 0;
    TrackerOptions options;
    options.range_uncertainty_m = uncertainty_m;
    options.threads = threads;
    if (!place_drive(t, model, options)) return 0;
    for (Node& node : t.nodes) placed += !node.placed, node.placed = true;
    return placed + again;
  }
  EpochFixOptions options;
  options.range_uncertainty_m = uncertainty_m;
  options.max_sigma_m = INFINITY;
  std::optional<PlaceModel> place;
  if (t.motion == Motion::kSpatial) place = open_attitude_model(t, model);
  constexpr std::size_t kSegmentsAtOnce = 16;
  std::atomic<std::size_t> epochs{0};
  for_each_chunk(
      t.segments.size(), kSegmentsAtOnce, threads, [&](std::size_t, std::size_t first, std::size_t last) {
        std::size_t here = 0;
        for (std::size_t s = first; s < last; ++s)
          for (std::size_t node = t.segments[s].first_node; node < t.segments[s].last_node; ++node) {
            if (t.nodes[node].placed && !again) continue;
            const Segment epoch =
                node_segment(t, t.segments[s], node);  // epochs chained by odometry are searched one by one
            here += place_epoch(t, epoch, model, place ? &*place : nullptr, options,
                                again && suspicious(t, epoch, model.state, suspect_sigmas));
          }
        epochs += here;
      });
  placed += epochs;
  // Places states by odometry from a neighbour if the search could not place them.
  for (const OdometryObservation& o : t.odometry)
    if (t.nodes[o.node].placed && !t.nodes[o.node + 1].placed) {
      t.nodes[o.node + 1].T_map_vehicle = t.nodes[o.node].T_map_vehicle * o.T_before_after;
      t.nodes[o.node + 1].placed = true;
    }
  for (auto o = t.odometry.rbegin(); o != t.odometry.rend(); ++o)
    if (t.nodes[o->node + 1].placed && !t.nodes[o->node].placed) {
      t.nodes[o->node].T_map_vehicle = t.nodes[o->node + 1].T_map_vehicle * o->T_before_after.inverse();
      t.nodes[o->node].placed = true;
    }
  return placed;
}

}  // namespace octant::calib
