// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/start/refusals.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/start/mirror_images.h"

namespace octant::calib {

Solution interrupted_solution() {
  Solution solution;
  solution.status = SolveStatus::kInterrupted;
  solution.message = "interrupted";
  return solution;
}

std::optional<WeakDirection> missing_scale(const Problem& problem) {
  // Relative accuracy of a length or speed that determines the scale.
  constexpr double kKnownScale = 0.15;
  const Site& site = problem.site;
  const double range_m = typical_range_m(problem), speed = speed_mps(site.medium);
  if (site.speed_sigma_mps < kKnownScale * speed || !site.distances.empty()) return {};
  Eigen::AlignedBox3d receivers;
  double receiver_sigma_m = 0.0;
  for (const SiteReceiver& r : site.receivers) {
    receivers.extend(r.position_m);
    receiver_sigma_m = std::max(receiver_sigma_m, r.sigma_m.maxCoeff());
  }
  const double array_m = site.receivers.empty() ? 0.0 : receivers.diagonal().norm();
  if (array_m > 0 && receiver_sigma_m < kKnownScale * array_m) return {};
  std::size_t placed = 0;
  for (const SiteBeacon& b : site.beacons)
    placed +=
        b.position_m[0] && b.position_m[1] &&
        std::max(b.sigma_m[0].value_or(INFINITY), b.sigma_m[1].value_or(INFINITY)) < kKnownScale * range_m;
  if (placed >= 2) return {};
  for (const MeasurementLog& run : problem.runs)
    if (!run.odometry.empty() || run.poses.size() >= 2) return {};
  return WeakDirection{
      "speed of sound and overall scale",
      {parameter_name(parameters::speed(), names_of(site))},
      INFINITY,
      INFINITY,
      "tape the distance between two beacons, or state the temperature and a smaller medium.sigma_mps",
      true};
}

Solution refused(WeakDirection direction) {
  Solution solution;
  solution.status = SolveStatus::kUndetermined;
  solution.message = fmt::format("the data do not determine {}; nothing is exported. To resolve this: {}",
                                 direction.description, direction.remedy);
  solution.undetermined = direction.parameters;
  solution.weak.push_back(std::move(direction));
  return solution;
}

namespace {

struct PlacedArrivals {
  std::size_t placed = 0, all = 0;
  bool any_state = false;  ///< any state, also of bearings
};
PlacedArrivals placed_of(const std::vector<Trajectory>& trajectories) {
  PlacedArrivals n;
  for (const Trajectory& t : trajectories) {
    n.all += t.arrivals.size() + t.stateless_arrivals.size();
    for (const ArrivalObservation& a : t.arrivals) n.placed += t.nodes[a.node].placed ? 1 : 0;
    for (const Segment& s : t.segments) n.any_state = n.any_state || t.nodes[s.first_node].placed;
  }
  return n;
}

bool are_all_held(const Site& site) {
  return std::ranges::all_of(site.beacons, [](const SiteBeacon& b) { return b.is_control_point(); });
}

/// The poses of the vehicle are not determined, and thus these beacons are not either.
Solution refused_poses(const Problem& problem, const std::vector<std::size_t>& beacons,
                       std::string description, std::string remedy) {
  WeakDirection direction;
  direction.description = std::move(description);
  direction.remedy = std::move(remedy);
  direction.blocking = true;
  for (const std::size_t b : beacons)
    direction.parameters.push_back(owner_name(parameters::beacon_delay(b), names_of(problem.site)));
  return refused(std::move(direction));
}

/// Share of the stops that receive at least three beacons.
double share_of_stops_in_reach(const std::vector<Trajectory>& trajectories) {
  constexpr std::size_t kBeacons = 3;
  std::size_t stops = 0, in_reach = 0;
  for (const Trajectory& t : trajectories)
    for (const Segment& s : t.segments) {
      std::set<BeaconId> heard;
      for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) heard.insert(t.arrivals[i].beacon);
      ++stops;
      in_reach += heard.size() >= kBeacons;
    }
  return static_cast<double>(in_reach) / static_cast<double>(std::max<std::size_t>(stops, 1));
}

/// First run of a moving vehicle without information on its motion; no value if there is no such run.
std::optional<std::size_t> run_without_motion(const Problem& problem) {
  for (std::size_t run = 0; run < problem.runs.size(); ++run) {
    const MeasurementLog& log = problem.runs[run];
    if (log.has_epochs || !log.odometry.empty() || !log.poses.empty() || log.arrivals.empty()) continue;
    if (std::ranges::any_of(problem.site.vehicles, [](const SiteVehicle& v) { return v.motion.has_value(); }))
      continue;
    return run;
  }
  return std::nullopt;
}

/// Refusal for known beacons from which no pose can be determined.
Solution without_pose_among_known(const Problem& problem, const std::vector<Trajectory>& trajectories,
                                  const std::vector<std::size_t>& beacons) {
  constexpr double kMany = 0.25;
  if (const auto run = run_without_motion(problem))
    return refused_poses(problem, beacons,
                         fmt::format("where the vehicle was in {}: it has neither epochs nor odometry, and "
                                     "one arrival at a time determines no pose",
                                     problem.runs[*run].path),
                         "number the stops in a column epoch, record odometry.csv or poses.tum, or state "
                         "vehicles[].motion in the site file");
  if (share_of_stops_in_reach(trajectories) > kMany)
    return refused_poses(problem, beacons,
                         "any place of the vehicle: its arrivals contradict what was stated, although enough "
                         "beacons are received together",
                         "check the positions and labels of the beacons, and the form in which the "
                         "recording was written");
  return refused_poses(
      problem, beacons, "any place of the vehicle: hardly anywhere are three beacons received together",
      "record at places where more beacons are received, or give measured poses of the vehicle");
}

Solution without_any_pose(const Problem& problem, const std::vector<Trajectory>& trajectories,
                          const std::vector<bool>& beacon_found) {
  std::vector<std::size_t> lost, all(beacon_found.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::ranges::copy_if(all, std::back_inserter(lost), [&](std::size_t b) { return !beacon_found[b]; });
  std::vector<std::string> names;
  for (const std::size_t b : lost.empty() ? all : lost) names.push_back(problem.site.beacons[b].name);
  if (lost.empty()) return without_pose_among_known(problem, trajectories, all);
  return refused_poses(
      problem, lost,
      fmt::format("any pose of the vehicle, and with it the positions of beacons {}", fmt::join(names, ", ")),
      "give approximate positions of three beacons that do not stand in line with the path, or measured "
      "poses of the vehicle");
}

/// All beacons are in one line, so a pose is not distinguishable from its mirror image.
Solution without_a_side(const Problem& problem, const PlacedArrivals& n) {
  std::vector<std::size_t> all(problem.site.beacons.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return refused_poses(
      problem, all,
      fmt::format("the poses of the vehicle ({} of {} arrivals have none): beacons {} stand in one line, and "
                  "the image of each pose in it explains the arrivals as well",
                  n.all - n.placed, n.all, fmt::join(names_of(problem.site).beacons, ", ")),
      "add a beacon beside that line, record odometry or poses of the vehicle, or use receivers that tell "
      "left "
      "from right");
}

}  // namespace

std::optional<Solution> without_poses(const Problem& problem, const AdjustedLog& log, double least_share) {
  const PlacedArrivals n = placed_of(log.trajectories);
  const bool are_few = static_cast<double>(n.placed) < least_share * static_cast<double>(n.all);
  const bool all_held = are_all_held(problem.site);
  if (n.any_state && !(are_few && all_held)) return std::nullopt;
  if (all_held && is_known_in_line(problem, log)) return without_a_side(problem, n);
  return without_any_pose(problem, log.trajectories, log.estimate.beacon_usable);
}

}  // namespace octant::calib
