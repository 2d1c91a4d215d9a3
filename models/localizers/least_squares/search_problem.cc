// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/search_problem.h"

#include <algorithm>
#include <cmath>

#include "models/physics/range.h"
#include "models/trajectory/observed_range.h"

namespace octant {
namespace {

Pose relative_pose(const RigidPath& path, std::size_t node, double alpha) {
  if (path.T_anchor_node.empty()) return {};
  const std::size_t k = node - path.first_node;
  if (alpha == 0.0 || k + 1 >= path.T_anchor_node.size()) return path.T_anchor_node[k];
  return interpolate(path.T_anchor_node[k], path.T_anchor_node[k + 1], alpha);
}

double drift(const RigidPath& path, std::size_t node) {
  return path.drift_m.empty() ? 0.0 : path.drift_m[node - path.first_node];
}

void add_ranges(const Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                const RigidPath& path, SearchProblem& problem) {
  for (std::size_t i = segment.first_arrival; i < segment.last_arrival; ++i) {
    const ArrivalObservation& a = trajectory.arrivals[i];
    if (!model.beacon_usable[a.beacon.index()]) continue;
    const Pose T = relative_pose(path, a.node, a.alpha);
    const Eigen::Vector3d& o = model.state.receiver_p_vehicle_m[a.receiver.index()];
    SearchRange r;
    r.p_beacon_map_m = model.state.beacon_p_map_m[a.beacon.index()];
    r.p_lever_m =
        a.two_way
            ? Eigen::Vector3d(
                  0.5 * (T * o + T * (trajectory.T_hear_send[static_cast<std::size_t>(a.hear_send)] * o)))
            : T * o;
    if (const auto& axis = model.receiver_axis[a.receiver.index()]) {
      const Eigen::Vector2d flat = (T.rotation * *axis).head<2>();
      if (flat.norm() > 0.1) r.axis = flat.normalized();
      if (a.receiver.index() < model.hearing_cosine.size())
        r.hearing_cosine = model.hearing_cosine[a.receiver.index()];
    }
    r.range_m = observed_range_m(trajectory, a, model.state);
    const double speed = a.model_speed_mps + model.state.speed_offset(trajectory.run);
    r.sigma_m = std::hypot(a.sigma_s * speed / a.legs(), drift(path, a.node));
    if (model.state.attenuation && model.state.attenuation->directional() && !(a.log_amplitude_sigma > 0)) {
      // The angle off the axis is not known here.
      r.sigma_m = std::hypot(r.sigma_m, speed * off_axis_walk_sigma_s(r.range_m, *model.state.attenuation,
                                                                      model.state.log_gain(a.beacon)));
    }
    r.beacon = a.beacon;
    r.observation = i;
    if (std::isfinite(r.range_m) && (trajectory.has_cycle_offset || r.range_m > 0))
      problem.ranges.push_back(r);
  }
}

/// Calibration sigma common to all ranges of a beacon, for any direction.
double calibration_sigma_m(const EpochFixModel& model, BeaconId beacon, double range_m, double speed_mps) {
  if (beacon.index() >= model.beacon_covariance.size()) return 0.0;
  const auto& C = model.beacon_covariance[beacon.index()];
  const double by_speed = range_m / speed_mps;
  return std::sqrt(std::max(0.0, C.topLeftCorner<3, 3>().trace() / 3 + speed_mps * speed_mps * C(3, 3) +
                                     by_speed * by_speed * C(4, 4)));
}

void add_bearings(const Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                  const RigidPath& path, SearchProblem& problem) {
  for (std::size_t i = segment.first_bearing; i < segment.last_bearing; ++i) {
    const BearingObservation& b = trajectory.bearings[i];
    if (!b.reflector.valid() || !model.beacon_usable[b.reflector.index()]) continue;
    const Pose T = relative_pose(path, b.node, b.alpha);
    SearchBearing s;
    s.p_reflector_map_m = model.state.beacon_p_map_m[b.reflector.index()].head<2>();
    s.p_lever_m = T.translation_m.head<2>();
    s.bearing_rad = wrap_angle(b.bearing_rad + T.heading_rad());
    s.sigma_rad = b.sigma_rad;
    problem.bearings.push_back(s);
  }
}

}  // namespace

SearchProblem make_search_problem(const Trajectory& trajectory, const Segment& segment,
                                  const EpochFixModel& model, double range_uncertainty_m,
                                  const RigidPath& path) {
  SearchProblem problem;
  problem.has_offset = trajectory.has_cycle_offset;
  problem.common_bias = path.T_anchor_node.empty();
  problem.uncertainty_m = range_uncertainty_m;
  add_ranges(trajectory, segment, model, path, problem);
  add_bearings(trajectory, segment, model, path, problem);
  // Ordered by observation within a beacon; a stable sort would allocate.
  std::ranges::sort(problem.ranges, [](const SearchRange& a, const SearchRange& b) {
    return a.beacon != b.beacon ? a.beacon < b.beacon : a.observation < b.observation;
  });
  std::pmr::vector<double> sigma(scratch());
  for (std::size_t i = 0; i < problem.ranges.size(); ++i) {
    const SearchRange& r = problem.ranges[i];
    if (i == 0 || r.beacon != problem.ranges[i - 1].beacon) {
      problem.group_first.push_back(i);
      problem.group_bias_m.push_back(std::hypot(
          range_uncertainty_m, calibration_sigma_m(model, r.beacon, r.range_m, model.nominal_speed_mps)));
    }
    problem.span_m = std::max(problem.span_m, r.range_m);
    problem.lever_m = std::max(problem.lever_m, r.p_lever_m.head<2>().norm());
    sigma.push_back(r.sigma_m);
  }
  if (sigma.empty()) return problem;
  problem.group_first.push_back(problem.ranges.size());
  const ArrivalObservation& middle =
      trajectory.arrivals[problem.ranges[problem.ranges.size() / 2].observation];
  problem.speed_mps = (middle.model_speed_mps + model.state.speed_offset(trajectory.run)) / middle.legs();
  std::ranges::nth_element(sigma, sigma.begin() + static_cast<std::ptrdiff_t>(sigma.size() / 2));
  problem.median_sigma_m = sigma[sigma.size() / 2];
  return problem;
}

}  // namespace octant
